//! Round bores in plates.

use std::sync::Arc;

use glam::DVec2;
use selvedge_components::curve::Heading;
use selvedge_components::subdivision::LoopSurface;

use super::super::*;
use super::judge::{judge, picture};
use super::support::{Numbers, OnPlate, Walker, circle, plate8};
use crate::subdivision::fit::{FitOptions, FitWork, Region};

fn bore(walker: &Arc<Walker>, centre: DVec2, radius: f64) -> Cut {
    let curve = OnPlate { walker: Arc::clone(walker), plane: circle(centre, radius), corners: Vec::new() };
    Cut::new(Arc::new(curve), Heading::Along)
}

fn traced(plate: &LoopSurface, walker: &Walker, cuts: &[Cut]) -> Result<Remeshed, RemeshError> {
    let options = TraceOptions { curve: 1e-6, step: 0.05 / 8.0 };
    let image = |(curve, cut): (usize, &Cut)| {
        let found = trace(&plate.mesh, walker, &*cut.curve, options);
        found.map_err(|source| RemeshError::PreImage { curve, source })
    };
    let images: Vec<PreImage> = cuts.iter().enumerate().map(image).collect::<Result<_, _>>()?;
    remesh(plate.clone(), cuts, &images, &RemeshOptions::default())
}

/// The bore of [Litke et al. 2001, Fig. 14]: 218, 29 and 10 um there.
#[test]
fn the_ladder_of_the_seeds_bore_is_met() {
    let plate = plate8();
    let walker = Arc::new(Walker::new(&plate));
    let cuts = [bore(&walker, DVec2::new(0.013, -0.007), 0.06)];
    let result = traced(&plate, &walker, &cuts).expect("a cage");
    let verdict = judge(&plate, &cuts, &result);
    assert!(verdict.most_valence <= 7, "{verdict:?}");
    picture("bore.svg", &result);
    let region = Region::Faces(result.omega.clone());
    let options = FitOptions { tolerance: None, last_level: 2, region, ..FitOptions::default() };
    let mut fit = FitWork::new(Arc::new(result.surface), walker, options).expect("a fit");
    fit.run().expect("a fit");
    let ladder: Vec<f64> = fit.ladder().iter().map(|rung| rung.max * 1e6).collect();
    assert!(ladder[0] < 80.0 && ladder[1] < 10.5 && ladder[2] < 1.8, "{ladder:?}");
}

#[test]
fn random_bores_leave_a_sound_cage() {
    let plate = plate8();
    let walker = Arc::new(Walker::new(&plate));
    let mut numbers = Numbers(5);
    let mut most = [0; 16];
    let count = std::env::var("SELVEDGE_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    for case in 0..count {
        // From a fifth of a cage edge to nearly two.
        let radius = numbers.between(0.01, 0.09);
        let centre = DVec2::new(numbers.between(-0.05, 0.05), numbers.between(-0.05, 0.05));
        let cuts = [bore(&walker, centre, radius)];
        let result = traced(&plate, &walker, &cuts).unwrap_or_else(|e| panic!("case {case}: {centre} {radius}: {e}"));
        let verdict = judge(&plate, &cuts, &result);
        assert_eq!(result.surface.mesh.euler(), plate.mesh.euler() - 1);
        most[verdict.most_valence as usize] += 1;
        if verdict.worst_shape < 0.02 {
            picture(&format!("bore{case}.svg"), &result);
        }
    }
    assert_eq!(most[9..].iter().sum::<i32>(), 0, "{most:?}");
}
