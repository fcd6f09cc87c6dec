//! # Gather: entities become dense snapshots
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | `Cage`, `Sides`, `ControlPoints`; `Position`, `ControlPointOf`, `ControlPointIndex`; `Detail`, `DetailLevel`, `Address`, `DetailOf` | `Snapshot`, or `SurfaceFailed` and no `Snapshot` | - | `Check` |
//!
//! Why: kernels read arrays, not entities, for a random read of an entity costs ten of an array.
//! Rows come as slices of tables, in any order and spread over any number of tables, and are put in
//! order by their index, so that the same values make the same bits wherever they are stored.
//!
//! What changed is found in three steps, each of which ends most passes: the summary ticks of a
//! table tell that no row of it was touched; the ticks of its rows, which of them were; a comparison
//! with the snapshot, which of those have another value. A snapshot that nobody else holds is then
//! changed in place. Rows that have left are found by counting ([`Ledger`]).

mod build;
mod rows;
mod survey;
mod system;

pub use build::{
    DetailBuild, PointBuild, patch_details, patch_points, same_bits, same_details, same_places, same_points,
    scatter_details, scatter_points,
};
pub use rows::{DetailRows, News, OwnerRows, PointRows, Rows, Table, runs, stretches};
pub use survey::{Ledger, Slots, survey};
pub use system::{Memory, gather_surfaces};
