//! Round bores in plates.

use std::sync::Arc;

use glam::DVec2;
use selvedge_components::subdivision::Heading;

use super::super::*;
use super::draw;
use super::support::{Bore, Walker, plate8};

pub fn bore(walker: &Arc<Walker>, x: f64, y: f64, radius: f64) -> Cut {
    let curve = Bore { walker: Arc::clone(walker), centre: DVec2::new(x, y), radius };
    Cut { curve: Arc::new(curve), heading: Heading::Along }
}

const TRACE: TraceOptions = TraceOptions { curve: 1e-6, step: 0.05 / 8.0 };

#[test]
fn the_seeds_bore_leaves_one_rim_with_valence_four() {
    let plate = plate8();
    let walker = Arc::new(Walker::new(&plate));
    let cut = bore(&walker, 0.013, -0.007, 0.06);
    let image = trace(&plate.mesh, &*walker, &*cut.curve, TRACE).expect("a pre-image");
    println!("{} points, off by {:e}", image.points.len(), image.distance());
    let result = remesh(&plate, &[cut], &[image], &RemeshOptions::default()).expect("a cage");
    let mesh = &result.surface.mesh;
    let mut valences = [0; 16];
    for v in 0..mesh.vertex_count() {
        let v = selvedge_components::mesh::VertexId::new(v);
        if !mesh.is_border(v) {
            valences[mesh.valence(v) as usize] += 1;
        }
    }
    println!("{valences:?} {:?} flips {} faces {} changed {}", result.relaxed, result.flipped, mesh.face_count(), result.changed.len());
    let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| f.map(|v| v.0)).collect();
    draw::triangles("bore.svg", &result.limit, &faces, |f| match result.face_origin[f] {
        FaceOrigin::Leaf { level: 0, .. } => "white",
        FaceOrigin::Leaf { .. } => "lightgrey",
        FaceOrigin::Closure { .. } => "khaki",
        FaceOrigin::Strip { .. } => "salmon",
    });
}
