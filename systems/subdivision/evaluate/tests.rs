use crate::subdivision::test_meshes as meshes;

use std::sync::Arc;

use selvedge_components::evaluate::Evaluate;
use selvedge_components::mesh::{Connectivity, VertexId};

use super::*;
use meshes::{Cage, Random, zoo};

fn surface((points, faces, corners): &Cage) -> PlainLoop {
    let mesh = Connectivity::new(points.len(), faces).expect("a mesh of the tests is sound");
    let corners: Vec<VertexId> = corners.iter().map(|&c| VertexId(c)).collect();
    PlainLoop::new(Arc::new(mesh), points.clone(), &corners).expect("its corners are on its border")
}

/// Anywhere, near vertices at every distance, at vertices, on edges, and outside.
fn places(faces: usize, count: usize, seed: u64) -> Vec<SurfacePoint> {
    let mut random = Random(seed);
    let mut place = |i: usize| {
        let (s, t) = random.place();
        let small = 2_f64.powi(-(random.below(100) as i32));
        match i % 8 {
            0 => (s * small, t * small),
            1 => (1.0 - small * s, small * s * t),
            2 => (small * s * t, 1.0 - small * s),
            3 => [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5)][random.below(4)],
            4 => (s, 1.0 - s),
            5 => [(-1.0, 0.2), (f64::NAN, 0.3), (f64::INFINITY, 0.1), (3.0, 4.0)][random.below(4)],
            _ => (s, t),
        }
    };
    let mut places: Vec<(f64, f64)> = (0..count).map(&mut place).collect();
    places.drain(..).map(|(s, t)| SurfacePoint::new(FaceId::new(random.below(faces)), s, t)).collect()
}

fn bits(jets: &[Jet]) -> Vec<[u64; 9]> {
    let numbers = |j: &Jet| [j.position, j.ds, j.dt].map(|v| v.to_array());
    jets.iter().map(|j| std::array::from_fn(|i| numbers(j)[i / 3][i % 3].to_bits())).collect()
}

/// In bulk, in any order, in lanes: bit for bit what the surface says of each place alone.
#[test]
fn bulk_has_the_bits_of_one_by_one() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let mut places = places(cage.1.len(), 1500, 11);
        let mut out = vec![Jet::default(); places.len()];
        jets(&surface, &places, &mut out).expect("the places are on the surface");
        let alone: Vec<Jet> = places.iter().map(|&p| surface.jet(p)).collect();
        assert!(out.iter().all(|j| j.position.is_finite() && j.ds.is_finite() && j.dt.is_finite()), "{name}");
        assert_eq!(bits(&out), bits(&alone), "{name}");
        places.sort_by_key(|p| p.face);
        jets_by_face(&surface, &places, &mut out).expect("the places are on the surface");
        let alone: Vec<Jet> = places.iter().map(|&p| surface.jet(p)).collect();
        assert_eq!(bits(&out), bits(&alone), "{name}, by face");
    }
}

/// Few places on many faces take another way to the same bits.
#[test]
fn sparse_places_have_the_same_bits() {
    let cage = meshes::torus(40, 30);
    let surface = surface(&cage);
    let places = places(cage.1.len(), 50, 3);
    let mut out = vec![Jet::default(); places.len()];
    jets(&surface, &places, &mut out).expect("the places are on the surface");
    let alone: Vec<Jet> = places.iter().map(|&p| surface.jet(p)).collect();
    assert_eq!(bits(&out), bits(&alone));
}

/// So do places each of which is on another face than the one before.
#[test]
fn places_in_no_order_have_the_same_bits() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let places = places(cage.1.len(), 1500, 17);
        let mut out = vec![Jet::default(); places.len()];
        jets_by_face(&surface, &places, &mut out).expect("the places are on the surface");
        let alone: Vec<Jet> = places.iter().map(|&p| surface.jet(p)).collect();
        assert_eq!(bits(&out), bits(&alone), "{name}");
    }
}

/// Threads leave no trace.
#[test]
#[cfg(feature = "parallel")]
fn bits_do_not_depend_on_threads() {
    let cage = meshes::scrambled(9, 80, 6);
    let surface = surface(&cage);
    let places = places(cage.1.len(), 30_000, 5);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let mut out = vec![Jet::default(); places.len()];
        pool.install(|| jets(&surface, &places, &mut out)).expect("the places are on the surface");
        bits(&out)
    };
    let one = run(1);
    assert!((2..=4).all(|threads| run(threads) == one));
}

/// What cannot be evaluated is named, and nothing is written.
#[test]
fn wrong_input_is_an_error() {
    let surface = surface(&meshes::bipyramid(4));
    let mut places = vec![SurfacePoint::default(); 3];
    let mut out = vec![Jet::default(); 2];
    assert_eq!(jets(&surface, &places, &mut out), Err(EvaluateError::Length { places: 3, results: 2 }));
    places[1].face = FaceId(8);
    out.push(Jet::default());
    let error = EvaluateError::NoSuchFace { place: 1, face: FaceId(8), faces: 8 };
    assert_eq!(jets(&surface, &places, &mut out), Err(error.clone()));
    assert_eq!(jets_by_face(&surface, &places, &mut out), Err(error));
    assert!(out.iter().all(|j| *j == Jet::default()));
}
