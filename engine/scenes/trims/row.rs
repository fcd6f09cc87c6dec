//! The figures of a trim, as the examples print them.

use core::cmp::Ordering;

use selvedge_components::subdivision::fit::Rung;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};
use serde::Serialize;
use thiserror::Error;

use super::{Scene, Settings, TrimSceneError, Trimmed, measure, run};

/// The figures of one scene. Every one is measured on what came out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrimRow {
    /// What it is called.
    pub name: String,
    /// The distance asked for, in metres; none where levels were asked for.
    pub tolerance_m: Option<f64>,
    /// The greatest distance of the new cage's limit surface to the given one before any detail.
    pub remesh_max_m: f64,
    /// Level by level.
    pub levels: Vec<LevelRow>,
    /// The greatest distance found afterwards, at 45 other places of every patch.
    pub achieved_max_m: f64,
    /// Edges of the triangles that are open where no border is.
    pub open_edges: usize,
    /// Are the border's vertices the curve's own values, bit for bit?
    pub curve_samples_exact: bool,
    /// Faces beyond the region that the trims may have changed.
    pub outside_faces: usize,
    /// Have these the same limit points as before, bit for bit? Where the whole cage was refined first,
    /// for a small reach, they are the same up to rounding only.
    pub outside_bit_identical: bool,
    /// How far from the curves the farthest corner of a face lies that may have changed.
    pub changed_radius_m: f64,
    /// The greatest valence of an interior vertex.
    pub max_valence: u32,
    /// Faces of the new cage.
    pub triangles: usize,
    /// The longest step that cannot be interrupted, in milliseconds.
    pub longest_step_ms: f64,
    /// All steps of the trims, measuring what came out not counted.
    pub seconds: f64,
}

/// One level of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelRow {
    /// The level.
    pub level: u32,
    /// The greatest distance, in metres, at 15 places of every patch.
    pub max_m: f64,
    /// The mean over the places sampled.
    pub mean_m: f64,
    /// Vectors stored, all levels together.
    pub details: usize,
    /// Vectors that this level could move.
    pub active: usize,
}

/// A promise that a trim has not kept.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Broken {
    /// The distance to the given surface.
    #[error("{achieved:e} m from the given surface, where {asked:e} m were asked for")]
    Tolerance {
        /// Asked for, in metres.
        asked: f64,
        /// Found, in metres.
        achieved: f64,
    },
    /// Its triangles are closed but for the borders.
    #[error("{0} open edges where no border is")]
    OpenEdges(usize),
    /// Border vertices are values of the curve.
    #[error("vertices of a border are not the curve's own values")]
    OffCurve,
    /// Nothing changes beyond its region.
    #[error("faces beyond its region are not what they were")]
    ChangedOutside,
}

/// The subdivision level at which borders and seams are looked at.
const LOOK: u32 = 2;

impl TrimRow {
    /// Measures a scene, and holds the figures against what was promised.
    ///
    /// # Errors
    /// If the result cannot be evaluated; [`TrimSceneError::Broken`].
    pub fn of(trimmed: &Trimmed, settings: &Settings) -> Result<Self, TrimSceneError> {
        let options = TriangulateOptions { density: Density::Level(LOOK), ..TriangulateOptions::default() };
        let triangles = triangulate(&trimmed.surface, &options)?.triangles;
        let mesh = &trimmed.surface.mesh;
        let row = Self {
            name: trimmed.name.clone(),
            tolerance_m: settings.tolerance.map(|t| t.fit),
            remesh_max_m: trimmed.initial.map_or(f64::NAN, |rung| rung.max),
            levels: trimmed.ladder.iter().map(LevelRow::new).collect(),
            achieved_max_m: measure::achieved(trimmed)?,
            open_edges: measure::open_edges(&triangles, mesh),
            curve_samples_exact: measure::curve_samples_exact(&trimmed.surface, &triangles, LOOK),
            outside_faces: trimmed.untouched().count(),
            outside_bit_identical: measure::outside_is_identical(trimmed)?,
            changed_radius_m: measure::changed_radius(trimmed)?,
            max_valence: measure::most_valence(mesh),
            triangles: mesh.face_count(),
            longest_step_ms: 1e3 * trimmed.longest_step.as_secs_f64(),
            seconds: trimmed.time.as_secs_f64(),
        };
        row.kept()
    }

    /// The row, if what it tells is what every trim promises.
    ///
    /// # Errors
    /// [`TrimSceneError::Broken`].
    pub fn kept(self) -> Result<Self, TrimSceneError> {
        let broken = match self.tolerance_m {
            // A distance that is no number is not within any other.
            Some(asked)
                if !matches!(self.achieved_max_m.partial_cmp(&asked), Some(Ordering::Less | Ordering::Equal)) =>
            {
                Some(Broken::Tolerance { asked, achieved: self.achieved_max_m })
            }
            _ if self.open_edges > 0 => Some(Broken::OpenEdges(self.open_edges)),
            _ if !self.curve_samples_exact => Some(Broken::OffCurve),
            _ if !self.outside_bit_identical => Some(Broken::ChangedOutside),
            _ => None,
        };
        match broken {
            Some(what) => Err(TrimSceneError::Broken { name: self.name, what }),
            None => Ok(self),
        }
    }

    /// The figures of several scenes, one after the other: each trimmed and measured.
    ///
    /// # Errors
    /// The first failure.
    pub fn of_all(scenes: &[Scene], settings: &Settings) -> Result<Vec<Self>, TrimSceneError> {
        scenes.iter().map(|scene| Self::of(&run(scene, settings)?, settings)).collect()
    }

    /// Rows as one JSON array.
    ///
    /// # Errors
    /// None: every field can be written.
    pub fn json(rows: &[Self]) -> Result<String, serde_json::Error> {
        serde_json::to_string(rows)
    }

    /// The row as lines for people.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("{}: {:.3e} m before any detail", self.name, self.remesh_max_m)];
        lines.extend(self.levels.iter().map(|l| {
            format!("  level {:2}  max {:.3e}  mean {:.3e}  {:6} details", l.level, l.max_m, l.mean_m, l.details)
        }));
        lines.push(format!(
            "  found afterwards {:.3e} m; {} open edges; samples exact: {}; {} faces outside, identical: {}",
            self.achieved_max_m,
            self.open_edges,
            self.curve_samples_exact,
            self.outside_faces,
            self.outside_bit_identical
        ));
        lines.push(format!(
            "  changed within {:.4} m; {} faces, valence up to {}; {:.3} s, longest step {:.1} ms",
            self.changed_radius_m, self.triangles, self.max_valence, self.seconds, self.longest_step_ms
        ));
        lines
    }
}

impl LevelRow {
    fn new(rung: &Rung) -> Self {
        let &Rung { level, max: max_m, mean: mean_m, details, active, .. } = rung;
        Self { level, max_m, mean_m, details, active }
    }
}
