//! A plate in a world, and trims of it.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use selvedge::curve::{Circle, Curve, Heading};
use selvedge::io::{Cage, Limits, obj};
use selvedge::mesh::Connectivity;
use selvedge::subdivision::{DetailOf, LoopSurface, Snapshot};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{Trim, TrimFailed, TrimFault, TrimJob, TrimOptions, TrimReport, TrimState, TrimmedTo};
use selvedge::{spawn_curve, spawn_surface, spawn_trim};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
use selvedge_systems::subdivision::limit::LimitSurface;

use super::world::{bits, host};

pub const TOLERANCE: f64 = 13e-6;

pub fn plate() -> LoopSurface {
    let polygons = obj::read(include_bytes!("../../data/plates/plate8.obj"), &Limits::default()).expect("a plate");
    let cage = Cage::from_polygons(polygons).expect("a cage");
    let mesh = Arc::new(Connectivity::new(cage.positions.len(), &cage.triangles).expect("sound"));
    let corners: Vec<_> = mesh.border_loops()[0].iter().copied().filter(|&v| mesh.valence(v) < 4).collect();
    LoopSurface::plain(mesh, cage.positions, &corners)
}

/// A wavy plate of `n` by `n` squares of 5 cm.
pub fn wide_plate(n: u32) -> LoopSurface {
    let at = |i: u32| (f64::from(i) - 0.5 * f64::from(n)) * 0.05;
    let points = (0..=n).flat_map(|i| (0..=n).map(move |j| (at(i), at(j))));
    let points: Vec<DVec3> =
        points.map(|(x, y)| DVec3::new(x, y, 0.006 * (11.0 * x).sin() * (9.0 * y).cos())).collect();
    let name = |i: u32, j: u32| i * (n + 1) + j;
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let faces: Vec<[u32; 3]> = squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let mesh = Arc::new(Connectivity::new(points.len(), &faces).expect("sound"));
    let corners: Vec<_> = mesh.border_loops()[0].iter().copied().filter(|&v| mesh.valence(v) < 4).collect();
    LoopSurface::plain(mesh, points, &corners)
}

/// The circle about `centre` on `surface`, seen from above.
pub fn circle(surface: &LoopSurface, centre: DVec2, radius: f64) -> Arc<dyn Curve> {
    laid(surface, Circle::new(centre.extend(0.0), DVec3::Z, radius).expect("a circle"))
}

/// A plane curve on `surface`, seen from above; where it leaves that, it goes on beside it.
pub fn laid(surface: &LoopSurface, plane: impl Curve + 'static) -> Arc<dyn Curve> {
    let limit = LimitSurface::new(Arc::new(surface.clone())).expect("sound");
    let index = Arc::new(SurfaceIndex::new(Arc::new(limit)).expect("finite"));
    let plane: Arc<dyn Curve> = Arc::new(plane);
    let above: Arc<dyn Curve> = Arc::new(Above(Arc::clone(&plane)));
    let onto = ProjectedCurve::new(above, DVec3::NEG_Z, index, Pick::First).expect("a direction");
    Arc::new(Laid { onto, plane })
}

#[derive(Debug)]
struct Above(Arc<dyn Curve>);

impl Curve for Above {
    fn position(&self, u: f64) -> DVec3 {
        self.0.position(u) + DVec3::Z
    }

    fn corners(&self) -> &[f64] {
        self.0.corners()
    }

    fn closed(&self) -> bool {
        self.0.closed()
    }
}

#[derive(Debug)]
struct Laid {
    onto: ProjectedCurve<LimitSurface>,
    plane: Arc<dyn Curve>,
}

impl Curve for Laid {
    fn position(&self, u: f64) -> DVec3 {
        let on = self.onto.position(u);
        if on.is_finite() { on } else { self.plane.position(u) }
    }

    fn corners(&self) -> &[f64] {
        self.plane.corners()
    }

    fn closed(&self) -> bool {
        self.plane.closed()
    }
}

pub fn tolerance() -> Option<Tolerance> {
    Some(Tolerance { fit: TOLERANCE, chord: TOLERANCE, curve: TOLERANCE })
}

/// A world with a plate and bores in it.
pub struct Plate {
    pub world: World,
    pub schedule: Schedule,
    pub source: Entity,
    pub surface: LoopSurface,
}

impl Plate {
    pub fn new() -> Self {
        Self::of(plate())
    }

    pub fn of(surface: LoopSurface) -> Self {
        let (mut world, schedule) = host();
        let source = spawn_surface(&mut world, &surface);
        Self { world, schedule, source, surface }
    }

    pub fn bore(&mut self, centre: DVec2, radius: f64) -> Entity {
        let curve = spawn_curve(&mut self.world, circle(&self.surface, centre, radius));
        self.cut(curve, Heading::Against)
    }

    pub fn cut(&mut self, curve: Entity, heading: Heading) -> Entity {
        spawn_trim(&mut self.world, self.source, &[(curve, heading)], tolerance(), TrimOptions::default())
    }

    pub fn run(&mut self) {
        self.schedule.run(&mut self.world);
        self.world.clear_trackers();
    }

    /// Passes until no trim is at work. Returns how many.
    pub fn settle(&mut self) -> u64 {
        for passes in 1..10_000 {
            self.run();
            let mut jobs = self.world.query::<(Option<&TrimJob>, &Trim)>();
            if jobs.iter(&self.world).all(|(job, _)| job.is_some_and(|job| !job.is_running())) {
                self.run();
                return passes;
            }
        }
        panic!("trims do not end");
    }

    pub fn state(&self, trim: Entity) -> TrimState {
        self.world.get::<TrimJob>(trim).expect("the trim was begun").state
    }

    pub fn report(&self, trim: Entity) -> &TrimReport {
        if let Some(failed) = self.world.get::<TrimFailed>(trim) {
            panic!("{failed}");
        }
        self.world.get::<TrimReport>(trim).expect("the trim is done")
    }

    pub fn failure(&self, trim: Entity) -> &TrimFault {
        &self.world.get::<TrimFailed>(trim).expect("the trim has failed").why
    }

    pub fn result(&self) -> Option<&LoopSurface> {
        let result = self.world.get::<TrimmedTo>(self.source)?;
        Some(&self.world.get::<Snapshot>(result.0).expect("a result has a snapshot").surface)
    }

    pub fn details(&mut self) -> usize {
        self.world.query::<&DetailOf>().iter(&self.world).count()
    }

    pub fn source_bits(&self) -> Vec<u64> {
        bits(&self.world.get::<Snapshot>(self.source).expect("gathered").surface)
    }
}

impl Plate {
    pub fn bore_in_the_air(&mut self) -> Entity {
        let circle = Circle::new(DVec3::new(0.0, 0.0, 0.3), DVec3::Z, 0.05).expect("a circle");
        let curve = spawn_curve(&mut self.world, Arc::new(circle));
        self.cut(curve, Heading::Against)
    }
}
