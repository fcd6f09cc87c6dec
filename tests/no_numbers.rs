//! What is no number, or no size, where one is asked for: refused by what it is, once, and the world comes to
//! rest.

mod support;

use selvedge::diagnostics::{GroundDiagnostics, SubdivisionDiagnostics};
use selvedge::error::{FitFailed, FitFault};
use selvedge::subdivision::fit::{FitError, FitOptions};
use selvedge::tolerance::Tolerance;
use selvedge::triangulation::{Density, TriangulateError, TriangulateOptions, TriangulationFailed};
use selvedge::{Engine, Pass};
use support::octant;
use support::world::{bits, down_to, snapshot, sphere};

const NO_SIZES: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0];

/// Where nothing changes, nothing is done: the passes that the world takes to come to rest are few, and after
/// them nobody writes.
fn comes_to_rest(engine: &mut Engine, what: &str) {
    let mut passes = 0;
    while engine.update() == Pass::Busy {
        passes += 1;
        assert!(passes < 100, "{what} keeps the world busy");
    }
    let written = |engine: &Engine| {
        let fits = engine.world().resource::<SubdivisionDiagnostics>();
        let triangles = engine.world().resource::<GroundDiagnostics>().triangulate;
        [fits.admit, fits.refine, fits.advance, triangles].map(|counters| counters.written)
    };
    let before = written(engine);
    assert!(engine.settle().expect("nothing is left to do") <= 1, "{what}");
    assert_eq!(engine.update(), Pass::Idle, "{what}");
    assert_eq!(written(engine), before, "{what} is told once");
}

#[test]
fn a_fit_within_no_size_is_refused_once() {
    for asked in NO_SIZES {
        for by_component in [false, true] {
            let mut engine = Engine::new();
            let source = octant("cone(1,1)");
            let surface = engine.spawn_surface(&source);
            let options = FitOptions { tolerance: (!by_component).then_some(asked), ..down_to(2) };
            let fit = engine.spawn_fit(surface, sphere(), options);
            if by_component {
                // It goes before that of the options.
                let tolerance = Tolerance { fit: asked, chord: 1e-3, curve: 1e-3 };
                engine.world_mut().entity_mut(fit).insert(tolerance);
            }
            comes_to_rest(&mut engine, &format!("a tolerance of {asked}"));
            let why = &engine.world().get::<FitFailed>(fit).expect("it cannot be met").why;
            let FitFault::Fit(FitError::BadTolerance { tolerance }) = why else { panic!("{asked}: {why}") };
            assert_eq!(tolerance.to_bits(), asked.to_bits());
            assert_eq!(bits(&snapshot(engine.world(), surface).surface), bits(&source), "nothing is changed");
        }
    }
}

#[test]
fn triangles_within_no_chord_are_refused_once() {
    for asked in NO_SIZES {
        for by_component in [false, true] {
            let mut engine = Engine::new();
            let surface = engine.spawn_surface(&octant("cone(1,1)"));
            let density = if by_component { Density::Level(1) } else { Density::Chord(asked) };
            let options = TriangulateOptions { density, ..TriangulateOptions::default() };
            let mut surface = engine.world_mut().entity_mut(surface);
            surface.insert(options);
            if by_component {
                surface.insert(Tolerance { fit: 1e-3, chord: asked, curve: 1e-3 });
            }
            let surface = surface.id();
            comes_to_rest(&mut engine, &format!("a chord of {asked}"));
            let why = &engine.world().get::<TriangulationFailed>(surface).expect("it cannot be kept").0;
            let TriangulateError::BadChord { chord } = why else { panic!("{asked}: {why}") };
            assert_eq!(chord.to_bits(), asked.to_bits());
        }
    }
}
