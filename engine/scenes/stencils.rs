//! Every stencil of the scheme, taken from the rules themselves, as numbers and as pictures.
//!
//! [Litke et al. 2001, Fig. 2, 3 and 5], for valences 3 to 12.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use selvedge_components::mesh::{Connectivity, Fault, VertexId};
use selvedge_components::subdivision::{CornerTable, Details, LimitRows, LoopSurface, masks};
use selvedge_systems::subdivision::{chain, quasi};
use serde::Serialize;

/// One stencil.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StencilRow {
    /// Figure of the paper.
    pub figure: &'static str,
    /// What it computes.
    pub name: &'static str,
    /// The valence of its vertex, where it depends on one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valence: Option<u32>,
    /// Where each weight stands: `centre`, `ring`, or a place of its own.
    pub weights: Vec<(&'static str, f64)>,
}

/// All valences that the figures show.
pub const VALENCES: core::ops::RangeInclusive<u32> = 3..=12;

/// All stencils.
///
/// # Errors
/// The faults of a wheel of triangles, which has none.
pub fn all() -> Result<Vec<StencilRow>, Vec<Fault>> {
    let mut rows = Vec::new();
    for k in VALENCES {
        let [vertex, limit] = interior(k)?;
        rows.push(StencilRow { figure: "2", name: "vertex", valence: Some(k), weights: vertex });
        rows.push(StencilRow { figure: "2", name: "limit", valence: Some(k), weights: limit });
        let beta = -0.5 / f64::from(k);
        let quasi = vec![("centre", 1.0 - f64::from(k) * beta), ("ring", beta)];
        rows.push(StencilRow { figure: "5a", name: "interior detail", valence: Some(k), weights: quasi });
        let own = vec![("centre", (3.0 + masks::alpha(k)) / 3.0)];
        rows.push(StencilRow { figure: "5d", name: "interpolating detail", valence: Some(k), weights: own });
        for (name, angle) in
            [("edge at a corner of 90 degrees", 0.5 * PI), ("edge at a corner of 270 degrees", 1.5 * PI)]
        {
            let gamma = masks::corner_weight(angle, k);
            let weights = vec![("corner", 0.75 - gamma), ("far end", gamma), ("across", 0.125)];
            rows.push(StencilRow { figure: "2", name, valence: Some(k), weights });
        }
    }
    rows.extend(without_valence());
    Ok(rows)
}

/// The stencils that know no valence.
fn without_valence() -> Vec<StencilRow> {
    let row = |figure, name, weights| StencilRow { figure, name, valence: None, weights };
    let [n, _, apex] = quasi::QUADRATIC;
    let [c1, _, c2, c3, _, c4, _] = quasi::CUBIC;
    vec![
        row("2", "edge", vec![("end", 0.375), ("across", 0.125)]),
        row("3", "boundary parameter, vertex", vec![("own", 0.75), ("neighbour", 0.125)]),
        row("3", "boundary parameter, edge", vec![("end", 0.5)]),
        row("3", "boundary detail, vertex", vec![("own", 0.25)]),
        row("3", "boundary detail, edge", vec![("end", 0.125)]),
        row("5b", "boundary detail, exact on quadratics", vec![("row 1", n), ("row 2 middle", apex)]),
        row(
            "5b",
            "boundary detail, exact on cubics",
            vec![("row 1", c1), ("row 2 middle", c2), ("row 2 sides", c3), ("row 3", c4)],
        ),
        row("5c", "corner detail", vec![("neighbour's detail", 0.5)]),
    ]
}

/// The vertex and the limit rule at the hub of a wheel of `k` triangles, as the scheme applies them.
fn interior(k: u32) -> Result<[Vec<(&'static str, f64)>; 2], Vec<Fault>> {
    let spokes: Vec<[u32; 3]> = (0..k).map(|i| [0, 1 + i, 1 + (i + 1) % k]).collect();
    let mesh = Connectivity::new(k as usize + 1, &spokes)?;
    let points = vec![DVec3::ZERO; k as usize + 1];
    let surface = LoopSurface::plain(Arc::new(mesh), points, &[] as &[VertexId]);
    let corners = CornerTable::new(&surface);
    let none = Details::default();
    let root = chain::root(&surface, &corners, &none);
    let (_, step) = chain::refine(&surface, &corners, &none, &root, &root.mesh.all_refinable());
    let limit = LimitRows::new(&surface, &corners, &root.mesh, |v| v == 0);
    let named = |(columns, weights): (&[u32], &[f64])| {
        let find = |hub: bool| columns.iter().zip(weights).find(|(c, _)| (**c == 0) == hub).map_or(0.0, |e| *e.1);
        vec![("centre", find(true)), ("ring", find(false))]
    };
    Ok([named(step.rows.row(0)), named(limit.rows.row(0))])
}
