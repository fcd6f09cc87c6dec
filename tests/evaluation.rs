//! Evaluation anywhere agrees with subdividing everything, on every kind of border and corner.

#[path = "support/draw.rs"]
mod draw;
mod support;

use std::sync::Arc;

use draw::{Draw, add_details, ball, disc};
use glam::{DVec2, DVec3};
use selvedge_components::curve::Heading;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, FaceId, VertexId};
use selvedge_components::subdivision::{
    Address, CornerRule, CornerTable, Details, Deviation, FaceCode, Kind, LimitRows, LoopSurface, NONE, Patch,
    PatchLattice, Scheme, limit_frame,
};
use selvedge_systems::subdivision::chain;
use selvedge_systems::subdivision::limit::{LimitSurface, Nest};
use support::{detail, fan, graph, octant, parallelogram, spherical_fan};

/// Every kind of surroundings that a face can have.
fn surfaces() -> Vec<(String, LoopSurface)> {
    let mut all = vec![
        ("octant".into(), octant("cone(1,2)")),
        ("small octant".into(), octant("cone(1,1)")),
        ("parallelogram".into(), graph(&parallelogram(3), |p| 0.1 * p.x * p.x * p.y - 0.2 * p.y)),
        ("one face".into(), graph(&parallelogram(1), |p| 0.1 * p.x * p.y)),
    ];
    for sectors in 1..=6 {
        // A lattice sector is brought to its angle by an affine map: convex to convex.
        let angles: &[f64] = match sectors {
            1 | 2 => &[80.0, 130.0],
            4 | 5 => &[230.0, 290.0],
            _ => &[80.0, 130.0, 180.0, 230.0, 290.0],
        };
        for degrees in angles {
            for n in [1, 2] {
                let surface = spherical_fan(sectors, n, degrees.to_radians());
                all.push((format!("fan of {sectors} by {n} over {degrees}"), surface));
            }
        }
    }
    for (sectors, rings) in [(3, 1), (5, 1), (3, 2), (5, 2), (6, 3), (8, 2)] {
        for heading in [Heading::Along, Heading::Against] {
            all.push((format!("disc of {sectors} by {rings}"), oriented_disc(sectors, rings, heading)));
        }
    }
    let (points, triangles) = ball(120, 7);
    all.push(("ball".into(), support::plain(points.clone(), &triangles)));
    all.push(("cut ball".into(), cut(&points, &triangles, 40, &[])));
    let declared: Vec<VertexId> = (0..60).step_by(3).map(VertexId).collect();
    all.push(("cut ball with corners".into(), cut(&points, &triangles, 60, &declared)));
    all
}

/// A disc, whichever way its border runs along the circle.
fn oriented_disc(sectors: usize, rings: usize, heading: Heading) -> LoopSurface {
    disc(sectors, rings, 3, heading)
}

/// The triangles left when the first `count` are taken away, with plain borders.
fn cut(points: &[DVec3], triangles: &[[u32; 3]], count: usize, corners: &[VertexId]) -> LoopSurface {
    let mut count = count;
    // As few more as it takes to leave a manifold.
    loop {
        let left = &triangles[count..];
        let mut names = vec![u32::MAX; points.len()];
        let mut kept = Vec::new();
        let faces: Vec<[u32; 3]> = left
            .iter()
            .map(|f| {
                f.map(|v| {
                    if names[v as usize] == u32::MAX {
                        names[v as usize] = kept.len() as u32;
                        kept.push(points[v as usize]);
                    }
                    names[v as usize]
                })
            })
            .collect();
        if let Ok(mesh) = Connectivity::new(kept.len(), &faces) {
            return LoopSurface::plain(Arc::new(mesh), kept, corners);
        }
        count += 1;
    }
}

/// Positions at the lattice of `level`, by subdividing everything.
fn by_force(surface: &LoopSurface, level: u32) -> Vec<(SurfacePoint, DVec3)> {
    let corners = CornerTable::new(surface);
    let mut at = chain::root(surface, &corners, &surface.details);
    for _ in 0..level {
        at = chain::refine(surface, &corners, &surface.details, &at, &at.mesh.all_refinable()).0;
    }
    let limit = LimitRows::new(surface, &corners, &at.mesh, |_| true);
    let mut positions = vec![DVec3::NAN; at.mesh.vertices.len()];
    for (&v, x) in limit.vertices.iter().zip(limit.apply(&at.state)) {
        positions[v as usize] = x;
    }
    for given in &at.mesh.given {
        positions[given.vertex as usize] = given.sample;
    }
    let n = f64::from(1_u32 << level);
    let mut found = Vec::new();
    for (code, vertices) in at.mesh.codes.iter().zip(&at.mesh.corners) {
        for (&v, (i, j)) in vertices.iter().zip(code.corners(level)) {
            let st = DVec2::new(f64::from(i), f64::from(j)) / n;
            found.push((SurfacePoint { face: code.root_face(level), st }, positions[v as usize]));
        }
    }
    found
}

#[test]
fn positions_agree_with_subdividing_everything() {
    for (name, mut surface) in surfaces() {
        for details in [0, 4] {
            if details > 0 {
                add_details(&mut surface, details, 0.05, 11);
                assert!(surface.details.levels.iter().all(|l| !l.is_empty()), "{name}: no details were drawn");
            }
            for rule in [CornerRule::Lattice, CornerRule::Seed] {
                surface.corner_rule = rule;
                let limit = LimitSurface::new(Arc::new(surface.clone())).expect("a sound surface");
                for (at, expected) in by_force(&surface, 5) {
                    let off = limit.position(at).distance(expected);
                    assert!(off < 1e-12, "{name}, {details} levels of details, {rule:?}, at {at:?}: off by {off:e}");
                }
            }
        }
    }
}

/// A patch tells the same of a lattice at once as of its points one by one: beside every kind of border,
/// corner and irregular vertex.
#[test]
fn a_lattice_of_a_patch_is_its_points() {
    for (name, mut surface) in surfaces() {
        add_details(&mut surface, 1, 0.05, 11);
        for rule in [CornerRule::Lattice, CornerRule::Seed] {
            surface.corner_rule = rule;
            let corners = CornerTable::new(&surface);
            let scheme = Scheme { surface: &surface, corners: &corners };
            let root = chain::root(&surface, &corners, &surface.details);
            let (finer, _) = chain::refine(&surface, &corners, &surface.details, &root, &root.mesh.all_refinable());
            for level in [root, finer] {
                for face in level.mesh.all_refinable() {
                    let patch = Patch::of(scheme, &level.mesh, &level.state, face);
                    for depth in [0, 1, 3] {
                        let (lattice, n) = (PatchLattice::new(&patch, depth), 1 << depth);
                        assert_eq!(lattice.steps(), n);
                        for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                            let weights = [n - i - j, i, j].map(|w| w as f64 / n as f64);
                            let off = lattice.point(i, j).distance(patch.clone().position(weights));
                            assert!(off < 1e-14, "{name}, {rule:?}, face {face}, {weights:?}: off by {off:e}");
                        }
                    }
                }
            }
        }
    }
}

/// By differences of fourth order, which stay inside the face.
fn difference(surface: &LimitSurface, at: SurfacePoint, along: DVec2, h: f64) -> DVec3 {
    let position = |k: f64| surface.position(SurfacePoint { st: at.st + along * (k * h), ..at });
    (8.0 * (position(1.0) - position(-1.0)) - (position(2.0) - position(-2.0))) / (12.0 * h)
}

#[test]
fn derivatives_agree_with_differences() {
    const H: f64 = 1e-4;
    let mut draw = Draw(5);
    for (name, mut surface) in surfaces() {
        add_details(&mut surface, 3, 0.05, 12);
        let limit = LimitSurface::new(Arc::new(surface)).expect("a sound surface");
        let mut worst = (0.0, SurfacePoint::default());
        let (mut count, mut good) = (0, 0);
        for _ in 0..400 {
            let at = draw.place(limit.face_count());
            let st = at.st;
            // Inside one quarter of the finest level, so that no derivative jumps within the steps.
            let inside = |x: f64| (x * 8.0 - (x * 8.0).round()).abs() > 40.0 * H;
            if ![st.x, st.y, st.x + st.y].into_iter().all(inside) {
                continue;
            }
            count += 1;
            let jet = limit.jet(at);
            for (along, derivative) in [(DVec2::X, jet.ds), (DVec2::Y, jet.dt)] {
                let off = difference(&limit, at, along, H).distance(derivative);
                good += usize::from(off < 1e-9);
                if off > worst.0 {
                    worst = (off, at);
                }
            }
        }
        assert!(count > 300, "{name}: too few places");
        // Differences cross no jump, but near irregular vertices the derivatives that bound their own
        // error grow.
        assert!(worst.0 < 1e-5, "{name}: off by {:e} at {:?}", worst.0, worst.1);
        assert!(good > 2 * count * 97 / 100, "{name}: only {good} of {} within 1e-9", 2 * count);
    }
}

/// A surface whose limit is the graph of a cubic: interior points lowered by the detail, borders with
/// it.
fn reproducing(patch: &support::Patch, height: fn(DVec2) -> f64) -> LoopSurface {
    let mut surface = graph(patch, height);
    let mut border = Vec::new();
    for (v, &at) in patch.places.iter().enumerate() {
        let d = DVec3::new(0.0, 0.0, detail(height, at));
        if surface.mesh.is_border(VertexId::new(v)) {
            border.push((Address::Corner(VertexId::new(v)), d));
        } else {
            surface.points[v] -= d;
        }
    }
    surface.details = Details { levels: vec![border] };
    surface
}

fn cubic(at: DVec2) -> f64 {
    let (x, y) = (at.x, at.y);
    0.1 * x * x * x - 0.2 * x * x * y + 0.15 * x * y * y - 0.05 * y * y * y + 0.2 * x * x
}

fn cubic_gradient(at: DVec2) -> DVec2 {
    let (x, y) = (at.x, at.y);
    DVec2::new(0.3 * x * x - 0.4 * x * y + 0.15 * y * y + 0.4 * x, -0.2 * x * x + 0.3 * x * y - 0.15 * y * y)
}

/// Places of every distance from the rim of a face, the rim and the corners among them.
fn rim_places(draw: &mut Draw, face: FaceId) -> Vec<SurfacePoint> {
    let mut places = Vec::new();
    for k in 0..20 {
        let (along, off) = (draw.unit(), if k == 0 { 0.0 } else { 10.0_f64.powi(1 - k) * draw.unit() });
        let rest = 1.0 - off;
        places.push(SurfacePoint::new(face, along * rest, off));
        places.push(SurfacePoint::new(face, off, along * rest));
        places.push(SurfacePoint::new(face, along * rest, (1.0 - along) * rest));
        places.push(SurfacePoint::new(face, off * along, off * (1.0 - along)));
        places.push(SurfacePoint::new(face, rest, off * along));
        places.push(SurfacePoint::new(face, off * along, rest));
    }
    places
}

#[test]
fn a_cubic_has_its_own_values_and_derivatives_everywhere() {
    let mut draw = Draw(9);
    for patch in [parallelogram(1), parallelogram(4), fan(1, 1), fan(2, 1), fan(1, 3), fan(2, 3)] {
        let limit = LimitSurface::new(Arc::new(reproducing(&patch, cubic))).expect("a sound surface");
        for (f, corners) in patch.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| patch.places[v as usize]);
            for at in rim_places(&mut draw, FaceId::new(f)) {
                let (jet, place) = (limit.jet(at), a + (b - a) * at.st.x + (c - a) * at.st.y);
                let off = jet.position.distance(place.extend(cubic(place)));
                assert!(off < 1e-13, "{at:?}: off by {off:e}");
                for (edge, derivative) in [(b - a, jet.ds), (c - a, jet.dt)] {
                    let off = derivative.distance(edge.extend(cubic_gradient(place).dot(edge)));
                    // Of a size of 8.
                    assert!(off < 8e-10, "{at:?}: derivative off by {off:e}");
                }
            }
        }
    }
}

/// Frames at the vertices of a coarse level and of a fine one are the same: the series that makes the
/// coarse one sums what subdivision does.
#[test]
fn tangents_do_not_depend_on_the_level_they_are_read_from() {
    for (name, mut surface) in surfaces() {
        add_details(&mut surface, 1, 0.05, 13);
        for rule in [CornerRule::Lattice, CornerRule::Seed] {
            surface.corner_rule = rule;
            let corners = CornerTable::new(&surface);
            let scheme = Scheme { surface: &surface, corners: &corners };
            let mut at = chain::root(&surface, &corners, &surface.details);
            let frames = |at: &chain::Level, v: u32| limit_frame(scheme, &at.mesh, &at.state, v);
            let coarse: Vec<_> = (0..at.mesh.vertices.len() as u32).filter_map(|v| frames(&at, v)).collect();
            for level in 1..=3 {
                at = chain::refine(&surface, &corners, &surface.details, &at, &at.mesh.all_refinable()).0;
                for (v, frame) in coarse.iter().enumerate() {
                    // Vertices that stand for a vertex come first, in its order.
                    let fine = frames(&at, v as u32).expect("nothing is cut");
                    let off = fine.position.distance(frame.position);
                    assert!(off < 1e-14, "{name}, {rule:?}, vertex {v}: moved by {off:e}");
                    // A vertex whose faces fold over each other has no plane to agree on.
                    let off = fine.normal().distance(frame.normal());
                    let k = at.mesh.vertices[v].valence;
                    let flat =
                        at.mesh.vertices[v].corner == NONE && k > 3 && at.mesh.vertices[v].kind == Kind::PlainCorner;
                    assert!(
                        off < 1e-8 || flat,
                        "{name}, {rule:?}, level {level}, vertex {v} of {k}: turned by {off:e}"
                    );
                }
            }
        }
    }
}

/// The first octahedra of a row are evaluated to the same bits however long the row is.
#[test]
fn a_face_is_evaluated_to_the_same_bits_however_many_there_are_beyond_it() {
    const FACES: [[u32; 3]; 8] =
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    const AXES: [DVec3; 6] = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let row = |count: u32| {
        let points = (0..count).flat_map(|k| AXES.map(|a| 0.3 * a + f64::from(k) * DVec3::new(0.7, 0.1, 0.0)));
        let faces: Vec<[u32; 3]> = (0..count).flat_map(|k| FACES.map(|f| f.map(|v| v + 6 * k))).collect();
        LimitSurface::new(Arc::new(support::plain(points.collect(), &faces))).expect("sound")
    };
    let (short, long) = (row(2), row(5000));
    let mut draw = Draw(5);
    for face in (0..16).map(FaceId::new) {
        for _ in 0..50 {
            let (s, t) = (draw.unit(), draw.unit());
            let at =
                if s + t > 1.0 { SurfacePoint::new(face, 1.0 - s, 1.0 - t) } else { SurfacePoint::new(face, s, t) };
            let [a, b] = [&short, &long].map(|limit| limit.position(at).to_array().map(f64::to_bits));
            assert_eq!(a, b, "{at:?}");
        }
    }
}

/// Weights of the points that divide the edges of a face by twelve, and how far off the triangle of its corners
/// the surface is there.
fn off_triangle(limit: &LimitSurface, level: u32, code: FaceCode) -> ([DVec3; 3], Vec<([f64; 3], DVec3)>) {
    let at = |w: [f64; 3]| limit.position(code.place(level, w));
    let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(at);
    let part = |i: u32| f64::from(i) / 12.0;
    let places = (0..=12).flat_map(|i| (0..=12 - i).map(move |j| [part(12 - i - j), part(i), part(j)]));
    let off = |w: [f64; 3]| (w, at(w) - (0..3).map(|c| corners[c] * w[c]).sum::<DVec3>());
    (corners, places.map(off).collect())
}

/// What fifteen points of a face that is no polynomial tell of how far it stands off its triangle is a bound:
/// no point is farther, in all, up and down, beyond an edge or off it. Whatever is around the face: borders of
/// every kind, corners, and vertices of any valence.
#[test]
fn fifteen_points_bound_what_is_between_them() {
    let discs = (3..=12).flat_map(|k| [1, 2].map(|seed| (format!("{k} sectors"), disc(k, 2, seed, Heading::Along))));
    let mut seen = 0;
    for (name, surface) in surfaces().into_iter().chain(discs) {
        let faces = surface.mesh.face_count();
        let limit = LimitSurface::new(Arc::new(surface)).expect("the surface is sound");
        for root in (0..faces).map(FaceId::new) {
            let mut nest = Nest::new(&limit, root);
            for (level, k) in (0..3).flat_map(|level| (0..1_u64 << (2 * level)).map(move |k| (level, k))) {
                let code = FaceCode((FaceCode::root(root).0 << (2 * level)) + k);
                let spot = nest.spot(level, code);
                if nest.quartic(spot).is_some() {
                    continue;
                }
                seen += 1;
                let ([a, b, c], off) = off_triangle(&limit, level, code);
                let deviation = Deviation::of_points(&nest.quarter_points(spot, k % 2 == 0));
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let slack = 1e-12;
                let (most, high) = (deviation.greatest() + slack, deviation.along(normal) + slack);
                for (w, off) in off {
                    let place = || format!("{name}: {root}, level {level}, {k}, {w:?}");
                    assert!(off.length() <= most, "{}: {} beyond {most}", place(), off.length());
                    assert!(off.dot(normal).abs() <= high, "{}: {} beyond {high}", place(), off.dot(normal));
                    for (e, [from, to, left]) in [[a, b, c], [b, c, a], [c, a, b]].into_iter().enumerate() {
                        let outward = (to - from).cross(normal).normalize_or_zero();
                        let height = outward.dot(from - left);
                        let across = off.dot(outward) - height * w[(e + 2) % 3];
                        if across > slack {
                            let [beyond, high] = deviation.beyond(e, outward, height, normal);
                            assert!(across <= beyond + slack, "{}: {across} beyond {beyond}", place());
                            assert!(off.dot(normal).abs() <= high + slack, "{}: {high}", place());
                        }
                        if w[(e + 2) % 3] == 0.0 {
                            let bound = deviation.off_edge(e, outward) + slack;
                            assert!(off.dot(outward).abs() <= bound, "{}: {} off {bound}", place(), off.dot(outward));
                        }
                    }
                }
            }
        }
    }
    assert!(seen > 1000, "{seen} faces");
}
