//! What is told of trims that are made.

use glam::DVec3;
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::FaceCode;
use selvedge_components::trim::{OtherReport, TrimReport, TrimmedCage};

use super::TrimWork;
use crate::spatial::{Bounds, Bvh};
use crate::subdivision::fit::FitWork;
use crate::subdivision::relax::shape;
use crate::subdivision::remesh::Remeshed;

impl TrimWork {
    /// How the other side of a trim went, by its index among those made together.
    pub fn other_report(&self, trim: usize) -> Option<OtherReport> {
        self.others.iter().find(|other| other.trim == trim)?.report(self)
    }

    /// The report; `None` before the audit is done.
    pub fn report(&self, fit: &FitWork) -> Option<TrimReport> {
        let (remeshed, audit) = (self.remeshed.as_ref()?, self.audit.as_ref()?);
        Some(TrimReport {
            together: Vec::new(),
            off: self.parts().map(|(_, part)| part.distance()).fold(0.0, f64::max),
            initial: fit.initial().copied(),
            ladder: fit.ladder().to_vec(),
            outcome: fit.outcome()?,
            details: fit.details().count(),
            relaxed: remeshed.relaxed.clone(),
            cage: self.cage(remeshed),
            audit: *audit.found(),
            other: None,
        })
    }

    pub(in super::super) fn cage(&self, remeshed: &Remeshed) -> TrimmedCage {
        let mesh = &remeshed.surface.mesh;
        let omega = &remeshed.omega;
        let changed = remeshed.changed.iter();
        let worst = |worst: f64, face: &FaceCode| {
            worst.min(shape(mesh.face(face.root_face(0)).map(|v| remeshed.limit[v.index()])))
        };
        TrimmedCage {
            faces: mesh.face_count(),
            outside: mesh.face_count() - omega.len(),
            changed_radius: self.changed_radius(remeshed),
            greatest_valence: changed.map(|&v| mesh.valence(v)).max().unwrap_or(0),
            worst_shape: omega.iter().fold(f64::INFINITY, worst),
        }
    }

    /// The farthest from the curves that a control point has changed.
    fn changed_radius(&self, remeshed: &Remeshed) -> f64 {
        let path: Vec<DVec3> = self.parts().flat_map(|(_, part)| &part.points).map(|p| p.position).collect();
        let boxes: Vec<Bounds> = path.iter().map(|&p| Bounds::of([p])).collect();
        let tree = Bvh::new(&boxes);
        let away = |v: &VertexId| {
            let x = remeshed.limit[v.index()];
            tree.nearest(x, |i| path[i as usize].distance_squared(x)).map_or(f64::INFINITY, |nearest| nearest.1)
        };
        remeshed.changed.iter().map(away).fold(0.0, f64::max).sqrt()
    }
}
