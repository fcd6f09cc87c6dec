//! Random trims in stated strata, and an oracle that does not know how they were made.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use selvedge::budget::Budgets;
use selvedge::curve::{BSpline, Circle, Curve, Heading, Polyline, Traversal};
use selvedge::evaluate::{Evaluate, SurfacePoint};
use selvedge::io::{Cage, Limits, obj};
use selvedge::mesh::{Connectivity, FaceId, VertexId};
use selvedge::scenes::trims;
use selvedge::subdivision::{Border, LoopSurface};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{TrimFault, TrimOptions};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::remesh::Cut;
use selvedge_systems::subdivision::trim::{Ground, LocateWork, TrimWork};

#[path = "random.rs"]
mod random;

pub use random::Draw;

/// What is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Bore,
    Slot,
    Star,
    Blob,
}

/// Where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Where {
    /// Anywhere.
    Anywhere,
    /// About an irregular vertex.
    Irregular,
    /// Across the rim of an earlier hole.
    OverAHole,
}

/// Some trims that are alike.
#[derive(Clone, Copy, Debug)]
pub struct Stratum {
    pub subject: &'static str,
    pub shape: Shape,
    pub place: Where,
    /// The least and the greatest radius, in edges of the cage there.
    pub sizes: [f64; 2],
}

/// All strata. Sizes are the curve's radius in edges of the cage, kept smaller than the part.
pub const STRATA: [Stratum; 16] = {
    use Shape::{Blob, Bore, Slot, Star};
    use Where::{Anywhere, Irregular, OverAHole};
    const fn of(subject: &'static str, shape: Shape, place: Where, sizes: [f64; 2]) -> Stratum {
        Stratum { subject, shape, place, sizes }
    }
    [
        of("plate32", Bore, Anywhere, [0.2, 10.0]),
        of("plate32", Slot, Anywhere, [0.4, 8.0]),
        of("plate32", Star, Anywhere, [0.4, 8.0]),
        of("plate32", Blob, Anywhere, [0.4, 8.0]),
        of("plate32", Bore, OverAHole, [0.5, 4.0]),
        of("plate8", Bore, Anywhere, [0.2, 2.0]),
        of("plate8", Star, Anywhere, [0.4, 2.0]),
        of("disc", Bore, Anywhere, [0.2, 2.5]),
        of("disc", Blob, Anywhere, [0.4, 2.0]),
        of("disc", Star, Anywhere, [0.4, 2.0]),
        of("spot", Bore, Anywhere, [0.2, 0.6]),
        of("spot", Blob, Irregular, [0.3, 0.6]),
        of("spot", Star, Anywhere, [0.3, 0.6]),
        of("ball", Bore, Irregular, [0.2, 2.5]),
        of("ball", Slot, Irregular, [0.4, 2.0]),
        of("ball", Blob, OverAHole, [0.5, 1.5]),
    ]
};

/// The surfaces that are trimmed.
pub struct Subjects(BTreeMap<&'static str, Arc<Ground>>);

impl Subjects {
    pub fn new() -> Self {
        let spot =
            obj::read(include_bytes!("../../data/cages/spot_control_mesh.obj"), &Limits::default()).expect("spot");
        let spot = Cage::from_polygons(spot).expect("a cage");
        let spot = closed(spot.positions, &spot.triangles);
        let all = [
            ("plate32", trims::ground::plate32().expect("a plate")),
            ("plate8", trims::ground::plate8().expect("a plate")),
            ("disc", trims::ground::contoured_disc().expect("a disc")),
            ("spot", ready(spot)),
            ("ball", ready(poled_ball(12, 9))),
        ];
        Self(all.into_iter().collect())
    }

    fn of(&self, name: &str) -> &Arc<Ground> {
        &self.0[name]
    }
}

fn ready(surface: LoopSurface) -> Arc<Ground> {
    Arc::new(Ground::new(Arc::new(surface), 0).expect("sound"))
}

fn closed(points: Vec<DVec3>, triangles: &[[u32; 3]]) -> LoopSurface {
    let mesh = Connectivity::new(points.len(), triangles).expect("sound");
    LoopSurface::plain(Arc::new(mesh), points, &[])
}

/// A ball with poles of valence `around`, and rings of vertices between.
fn poled_ball(around: u32, rings: u32) -> LoopSurface {
    let mut points = vec![DVec3::Z * 0.3];
    for ring in 1..rings {
        let (polar, turn) = (0.5 * TAU * f64::from(ring) / f64::from(rings), 0.5 * f64::from(ring));
        for k in 0..around {
            let angle = TAU * (f64::from(k) + turn) / f64::from(around);
            let bump = 1.0 + 0.05 * (3.0 * angle).sin() * polar.sin();
            points.push(0.3 * bump * DVec3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()));
        }
    }
    points.push(DVec3::Z * -0.3);
    let name = |ring: u32, k: u32| 1 + (ring - 1) * around + k % around;
    let last = points.len() as u32 - 1;
    let mut faces = Vec::new();
    for k in 0..around {
        faces.push([0, name(1, k), name(1, k + 1)]);
        for ring in 1..rings - 1 {
            faces.push([name(ring, k), name(ring + 1, k), name(ring, k + 1)]);
            faces.push([name(ring, k + 1), name(ring + 1, k), name(ring + 1, k + 1)]);
        }
        faces.push([last, name(rings - 1, k + 1), name(rings - 1, k)]);
    }
    closed(points, &faces)
}

impl Draw {
    fn weights(&mut self) -> [f64; 3] {
        let [s, t] = self.in_triangle();
        [1.0 - s - t, s, t]
    }
}

/// A plane in space: an origin and two unit directions.
#[derive(Clone, Copy, Debug)]
struct Frame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
}

impl Frame {
    fn normal(&self) -> DVec3 {
        self.x.cross(self.y)
    }

    fn at(&self, p: DVec2) -> DVec3 {
        self.origin + self.x * p.x + self.y * p.y
    }

    /// Where a point is over the plane.
    fn under(&self, point: DVec3) -> DVec2 {
        let way = point - self.origin;
        DVec2::new(way.dot(self.x), way.dot(self.y))
    }
}

/// A curve in its plane: points of it, and its size in model units.
type Outline = (Frame, Vec<DVec2>, f64);

/// One random trim: its curves, and what they are in their planes.
pub struct Case {
    pub ground: Arc<Ground>,
    pub cuts: Vec<Cut>,
    pub tolerance: Tolerance,
    outlines: Vec<Outline>,
}

impl Case {
    /// The trim number `number` of a stratum.
    pub fn new(subjects: &Subjects, stratum: &Stratum, number: u64) -> Self {
        let ground = Arc::clone(subjects.of(stratum.subject));
        let mut draw = Draw(number.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x7e11_5a6e);
        // A curve that does not lie flat enough to be projected is drawn again.
        let first = (0..1000).find_map(|_| Self::hole(&ground, stratum, None, &mut draw)).expect("a place for a curve");
        let mut holes = vec![first];
        if stratum.place == Where::OverAHole {
            let near = &holes[0].1;
            let second = (0..1000).find_map(|_| Self::hole(&ground, stratum, Some(near), &mut draw));
            holes.push(second.expect("a place for a curve"));
        }
        let edge = ground.edge;
        let fit = 2e-4 * edge;
        let (cuts, outlines) = holes.into_iter().unzip();
        Self { ground, cuts, tolerance: Tolerance { fit, chord: fit, curve: fit }, outlines }
    }

    fn hole(
        ground: &Arc<Ground>,
        stratum: &Stratum,
        over: Option<&Outline>,
        draw: &mut Draw,
    ) -> Option<(Cut, Outline)> {
        let size = stratum.sizes[0] * (stratum.sizes[1] / stratum.sizes[0]).powf(draw.unit()) * ground.edge;
        let frame = match over {
            // About a point of the earlier outline, so that the two cross.
            Some((frame, outline, _)) => {
                let rim = frame.at(outline[draw.below(outline.len())]);
                frame_at(ground, ground.index.closest(rim).ok()?.at, draw)
            }
            None => frame_at(ground, place(ground, stratum.place, draw), draw),
        };
        let plane: Arc<dyn Curve> = outline(stratum.shape, &frame, size, draw)?;
        let curve =
            ProjectedCurve::new(plane.clone(), -frame.normal(), Arc::clone(&ground.index), Pick::Nearest).ok()?;
        let mut knots: Vec<f64> =
            (0..256).map(|k| f64::from(k) / 256.0).chain(plane.corners().iter().copied()).collect();
        knots.sort_by(f64::total_cmp);
        let drawn: Vec<DVec2> = knots.into_iter().map(|u| frame.under(plane.position(u))).collect();
        lies_flat(ground, &curve, &*plane, &frame, size).then(|| {
            let cut = Cut::new(Arc::new(curve), Heading::Against);
            (cut, (frame, drawn, size))
        })
    }
}

fn place(ground: &Ground, place: Where, draw: &mut Draw) -> SurfacePoint {
    let mesh = &ground.surface.mesh;
    let irregular: Vec<VertexId> =
        (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| !mesh.is_border(v) && mesh.valence(v) != 6).collect();
    if place == Where::Irregular && !irregular.is_empty() {
        let h = mesh.outgoing(irregular[draw.below(irregular.len())]);
        let mut weights = [0.0; 3];
        weights[h.corner()] = 1.0;
        return SurfacePoint::new(h.face(), weights[1], weights[2]);
    }
    let [_, s, t] = draw.weights();
    SurfacePoint::new(FaceId::new(draw.below(mesh.face_count())), s, t)
}

/// The tangent plane at a place, turned at random, a little beside it.
fn frame_at(ground: &Ground, at: SurfacePoint, draw: &mut Draw) -> Frame {
    let jet = ground.limit().jet(at);
    let normal = jet.normal();
    let x = normal.any_orthonormal_vector();
    let (x, angle) = (x, TAU * draw.unit());
    let turned = x * angle.cos() + normal.cross(x) * angle.sin();
    let beside = turned * (0.2 * draw.unit() * ground.edge);
    Frame { origin: jet.position + beside, x: turned, y: normal.cross(turned) }
}

/// A closed plane curve of about radius `size` that runs counter-clockwise in its frame.
fn outline(shape: Shape, frame: &Frame, size: f64, draw: &mut Draw) -> Option<Arc<dyn Curve>> {
    let at = |radius: f64, angle: f64| frame.at(radius * DVec2::new(angle.cos(), angle.sin()));
    Some(match shape {
        Shape::Bore => Arc::new(Circle::from_axes(frame.origin, frame.x, frame.y, size).ok()?),
        Shape::Blob => {
            let count = 6 + draw.below(7);
            let points = (0..count).map(|k| at(size * draw.between(0.6, 1.3), TAU * k as f64 / count as f64));
            Arc::new(BSpline::uniform_periodic(3, points.collect()).ok()?)
        }
        Shape::Slot => {
            let width = draw.between(0.25, 0.6) * size;
            let corners = [
                (-1.0, -1.0),
                (0.0, -1.0),
                (1.0, -1.0),
                (1.25, 0.0),
                (1.0, 1.0),
                (0.0, 1.0),
                (-1.0, 1.0),
                (-1.25, 0.0),
            ];
            let points = corners.map(|(x, y)| frame.at(DVec2::new(x * size, y * width)));
            Arc::new(BSpline::uniform_periodic(3, points.to_vec()).ok()?)
        }
        Shape::Star => {
            let (tips, inner) = (3 + draw.below(4), draw.between(0.45, 0.75));
            let corner = |k: usize| {
                at(if k.is_multiple_of(2) { size } else { inner * size }, TAU * k as f64 / (2 * tips) as f64)
            };
            let points: Vec<DVec3> = (0..2 * tips).map(corner).collect();
            Arc::new(Polyline::closed(points).ok()?)
        }
    })
}

/// Is the curve on the surface everywhere, near its plane, on one sheet, and away from borders?
fn lies_flat(ground: &Ground, curve: &dyn Curve, plane: &dyn Curve, frame: &Frame, size: f64) -> bool {
    let mesh = &ground.surface.mesh;
    (0..96).all(|k| {
        let u = f64::from(k) / 96.0;
        let (x, above) = (curve.position(u), plane.position(u));
        let Ok(found) = ground.index.closest(x) else { return false };
        let inside = !mesh.face(found.at.face).iter().any(|&v| mesh.is_border(v));
        x.distance(above) < 0.5 * size && inside && ground.limit().jet(found.at).normal().dot(frame.normal()) > 0.7
    })
}

/// What became of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It was made, and the oracle agrees.
    Sound,
    /// It was refused or failed, for this reason.
    Refused(String),
    /// It was made, and the oracle found this wrong.
    FalseSuccess(String),
    /// It panicked.
    Panicked,
}

/// Makes a trim and asks the oracle. Tells how long it took to make it, and the worst shape of a face that was
/// made: infinite where none was.
pub fn run(case: &Case) -> (Verdict, Duration, f64) {
    let start = Instant::now();
    let made = catch_unwind(AssertUnwindSafe(|| make(case)));
    let took = start.elapsed();
    let mut worst_shape = f64::INFINITY;
    let verdict = match made {
        Err(_) => Verdict::Panicked,
        Ok(Err(why)) => Verdict::Refused(why.to_string()),
        Ok(Ok((surface, worst))) => {
            worst_shape = worst;
            match oracle(case, &surface) {
                Ok(()) => Verdict::Sound,
                Err(what) => Verdict::FalseSuccess(what),
            }
        }
    };
    (verdict, took, worst_shape)
}

/// The result, and the worst shape of its faces.
fn make(case: &Case) -> Result<(Arc<LoopSurface>, f64), TrimFault> {
    let options = TrimOptions::default();
    let mut members = Vec::new();
    for cut in &case.cuts {
        let work = LocateWork::new(Arc::clone(&case.ground), vec![cut.clone()], options.clone(), Some(case.tolerance));
        members.push(work?.run()?);
    }
    let mut work = TrimWork::on_all(Arc::clone(&case.ground), members);
    let fit = work.run(&Budgets::default()).map_err(|blamed| blamed.why)?;
    let report = work.report(&fit).expect("an audited result");
    Ok((Arc::clone(work.result().expect("an audited result")), report.cage.worst_shape))
}

/// Looks at a result as a stranger would: is it sound, does its border lie on the curves, bit for
/// bit, is it near the source, and is what is inside the outlines gone and what is outside still
/// there?
pub fn oracle(case: &Case, surface: &Arc<LoopSurface>) -> Result<(), String> {
    let faults = selvedge_systems::check::surface_faults(surface, &Budgets::default());
    if let Some(fault) = faults.first() {
        return Err(fault.to_string());
    }
    on_curves(surface)?;
    let limit = Arc::new(LimitSurface::new(Arc::clone(surface)).map_err(|e| e.to_string())?);
    let index = SurfaceIndex::new(Arc::clone(&limit)).map_err(|e| e.to_string())?;
    let mut draw = Draw(0x0dd_ba11);
    let (source, mesh) = (&case.ground, &surface.mesh);
    for f in 0..mesh.face_count() {
        for _ in 0..6 {
            let [_, s, t] = draw.weights();
            let x = limit.position(SurfacePoint::new(FaceId::new(f), s, t));
            let off = source.index.closest(x).map_err(|e| e.to_string())?.distance;
            if off > case.tolerance.fit {
                return Err(format!("{x} is {off:e} off the source, {:e} allowed", case.tolerance.fit));
            }
            if let Some(depth) = case.depth(x).filter(|&depth| depth > 1e-3) {
                return Err(format!("{x} is left, {depth} of the size inside an outline"));
            }
        }
    }
    for f in 0..source.surface.mesh.face_count() {
        for _ in 0..4 {
            let [_, s, t] = draw.weights();
            let y = source.limit().position(SurfacePoint::new(FaceId::new(f), s, t));
            let off = index.closest(y).map_err(|e| e.to_string())?.distance;
            match case.depth(y) {
                None if off > case.tolerance.fit => return Err(format!("{y} is gone: what is left is {off:e} off")),
                Some(depth) if depth > 0.02 && off < case.tolerance.fit => {
                    return Err(format!("{y} is still there, {depth} of the size inside an outline"));
                }
                _ => {}
            }
        }
    }
    let far = |y: DVec3| index.closest(y).map(|found| found.distance).map_err(|e| e.to_string());
    case.is_cut(&mut draw, |y| Ok(far(y)? >= case.tolerance.fit))
}

fn on_curves(surface: &LoopSurface) -> Result<(), String> {
    let bits = |x: DVec3| x.to_array().map(f64::to_bits);
    for side in &surface.sides {
        let Border::Given { curve, first, heading } = &side.border else { continue };
        let along = Traversal { first: *first, heading: *heading };
        for step in 0..(side.edge_count() as u64) << 3 {
            let place = along.vertex(curve, 3, step);
            let sample = curve.sample(3, place);
            let on = side.point_on(3, step, 0.0).ok_or("a given side has no point")?;
            if bits(sample) != bits(on) || bits(sample) != bits(curve.curve().position(curve.parameter(3, place))) {
                return Err(format!("border sample {on} is not the curve's {sample}"));
            }
        }
    }
    Ok(())
}

impl Case {
    /// Are places of the source inside the outlines `gone`? However small an outline is, it is looked into.
    fn is_cut(&self, draw: &mut Draw, gone: impl Fn(DVec3) -> Result<bool, String>) -> Result<(), String> {
        for (frame, outline, size) in &self.outlines {
            for _ in 0..64 {
                let p = *size * DVec2::new(draw.between(-1.3, 1.3), draw.between(-1.3, 1.3));
                let rim = nearest(outline, p);
                let depth = p.distance(rim) / size;
                if winding(outline, p) == 0 || depth <= 0.02 {
                    continue;
                }
                let Some(height) = self.sheet(frame, [rim, p], *size).filter(|h| h.abs() < 0.6 * size) else {
                    continue;
                };
                let y = frame.at(p) + frame.normal() * height;
                if !gone(y)? {
                    return Err(format!("{y} is still there, {depth} of the size inside an outline"));
                }
            }
        }
        Ok(())
    }

    /// How far inside an outline a point of the surface is, in sizes of the outline, if it is: on the sheet
    /// that the outline's curve lies on.
    fn depth(&self, x: DVec3) -> Option<f64> {
        let inside = self.outlines.iter().filter_map(|(frame, outline, size)| {
            let p = frame.under(x);
            let height = (x - frame.at(p)).dot(frame.normal());
            let near = height.abs() < 0.6 * size && p.length() < 2.0 * size;
            let rim = (near && winding(outline, p) != 0).then(|| nearest(outline, p))?;
            // Where there is nothing to follow, whatever is there is looked at.
            let followed = self.sheet(frame, [rim, p], *size);
            let is_meant = followed.is_none() || followed == self.height(frame, p, height, *size);
            is_meant.then(|| p.distance(rim) / size)
        });
        inside.reduce(f64::max)
    }

    /// The height over the plane of an outline, at a place in it, of the sheet that the outline's curve lies
    /// on: followed from the outline, from height to height.
    fn sheet(&self, frame: &Frame, [rim, place]: [DVec2; 2], size: f64) -> Option<f64> {
        const STEPS: u32 = 16;
        // The curve was carried to the sheet nearest to its plane.
        (0..=STEPS).try_fold(0.0, |before, k| {
            self.height(frame, rim.lerp(place, f64::from(k) / f64::from(STEPS)), before, size)
        })
    }

    /// The height nearest to `wanted` that the source has over a place.
    fn height(&self, frame: &Frame, p: DVec2, wanted: f64, size: f64) -> Option<f64> {
        let hits = self.ground.index.hits(frame.at(p), frame.normal(), [-2.0 * size, 2.0 * size]);
        hits.into_iter().map(|hit| hit.t).min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()))
    }
}

fn winding(outline: &[DVec2], p: DVec2) -> i32 {
    let mut turns = 0;
    for (k, &a) in outline.iter().enumerate() {
        let b = outline[(k + 1) % outline.len()];
        let left = (b - a).perp_dot(p - a);
        if a.y <= p.y && b.y > p.y && left > 0.0 {
            turns += 1;
        } else if a.y > p.y && b.y <= p.y && left < 0.0 {
            turns -= 1;
        }
    }
    turns
}

/// The point of an outline nearest to `p`.
fn nearest(outline: &[DVec2], p: DVec2) -> DVec2 {
    let on = |k: usize| {
        let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
        // A point given twice is a side without a direction.
        let along = (p - a).dot(b - a) / (b - a).length_squared();
        if along.is_nan() { a } else { a.lerp(b, along.clamp(0.0, 1.0)) }
    };
    let apart = |q: &DVec2| p.distance_squared(*q);
    (0..outline.len()).map(on).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(p)
}
