//! What comes out, measured by nothing that made it.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Address, Border, CornerTable, Ends, FaceCode, LoopSurface};
use selvedge_components::target::Target;
use selvedge_components::triangles::Triangles;
use selvedge_systems::closest::Search;
use selvedge_systems::parallel::map_in_order;
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::{chain, region};

use super::TrimSceneError;
use super::run::Trimmed;

/// The bits of a point; minus zero has those of zero.
fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// Edges of one triangle only that do not run along a border of the control mesh; vertices in one
/// place, to the bit, count as one.
pub fn open_edges(triangles: &Triangles, mesh: &Connectivity) -> usize {
    let edges = directed_edges(triangles);
    let inside = |&(from, to, [a, b]): &(Bits, Bits, [u32; 2])| {
        edges.binary_search_by_key(&(to, from), |e| (e.0, e.1)).is_err() && !on_border(triangles, mesh, [a, b])
    };
    edges.iter().filter(|e| inside(e)).count()
}

type Bits = [u64; 3];

/// The edges of all triangles by the places of their ends, ascending, and the vertices.
fn directed_edges(triangles: &Triangles) -> Vec<(Bits, Bits, [u32; 2])> {
    let at = |v: u32| bits(triangles.positions[v as usize]);
    let of = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let mut edges: Vec<_> = triangles.triangles.iter().flat_map(of).map(|[a, b]| (at(a), at(b), [a, b])).collect();
    edges.sort_unstable();
    edges
}

/// Do two vertices lie on one border edge of the control mesh?
fn on_border(triangles: &Triangles, mesh: &Connectivity, ends: [u32; 2]) -> bool {
    let [a, b] = ends.map(|v| border_edges(mesh, triangles.origins[v as usize]));
    a.iter().any(|e| b.contains(e))
}

/// The border half-edges of the control mesh that a place lies on.
fn border_edges(mesh: &Connectivity, at: SurfacePoint) -> Vec<HalfedgeId> {
    let weights = [1.0 - at.st.x - at.st.y, at.st.x, at.st.y];
    if let Some(corner) = weights.iter().position(|&w| w == 1.0) {
        let v = mesh.face(at.face)[corner];
        let around = mesh.ring(v).flat_map(|h| [h, h.previous()]);
        return around.filter(|&h| mesh.twin(h).is_none()).collect();
    }
    let edges = (0..3).filter(|&c| weights[(c + 2) % 3] == 0.0).map(|c| HalfedgeId::of(at.face, c));
    edges.filter(|&h| mesh.twin(h).is_none()).collect()
}

/// Are the border vertices of `triangles`, which are those of `level`, the curves' own values? Each
/// curve is called anew at each parameter, and its bits are sought among the border vertices; on given
/// sides there are no others.
pub fn curve_samples_exact(surface: &LoopSurface, triangles: &Triangles, level: u32) -> bool {
    let edges = directed_edges(triangles);
    let is_open = |e: &&(Bits, Bits, [u32; 2])| edges.binary_search_by_key(&(e.1, e.0), |e| (e.0, e.1)).is_err();
    let open: HashSet<Bits> = edges.iter().filter(is_open).flat_map(|e| [e.0, e.1]).collect();
    let (mut curves, mut inner): (HashSet<Bits>, HashSet<Bits>) = Default::default();
    let mut plain = 0;
    for side in &surface.sides {
        let steps = (side.edge_count() as u64) << level;
        let Border::Given { curve, .. } = &side.border else {
            plain += steps as usize + 1;
            continue;
        };
        let value =
            |step| side.curve_index(level, step).map(|i| bits(curve.curve().position(curve.parameter(level, i))));
        // Where two sides meet, one of their curves gives the bits.
        let ends = if side.ends == Ends::Corners { [Some(0), Some(steps)] } else { [None, None] };
        let own = (0..=steps).filter(|&s| s < steps || ends[1].is_some());
        for (step, bits) in own.filter_map(|step| Some((step, value(step)?))) {
            curves.insert(bits);
            if !ends.contains(&Some(step)) {
                inner.insert(bits);
            }
        }
    }
    inner.is_subset(&open) && open.difference(&curves).count() <= plain
}

/// Compares both limit surfaces where nothing should have changed: does every such face, evaluated by
/// itself on either surface, have the same points, bit for bit, at the corners of its quarters' quarters
/// and as many places within? Where the whole cage was refined first, so that none of them is a face of the
/// given cage any more: have their corners the effective control points that subdividing the given cage
/// makes?
///
/// # Errors
/// If one of them cannot be evaluated.
pub fn outside_is_identical(trimmed: &Trimmed) -> Result<bool, TrimSceneError> {
    // Where the whole cage was refined first, all leaves beyond are of that level.
    let base = trimmed.untouched().next().map_or(0, |f| f.1);
    if base > 0 {
        return Ok(outside_is_subdivided(trimmed, base));
    }
    const STEPS: u32 = 4;
    let limit = LimitSurface::new(Arc::clone(&trimmed.surface))?;
    let given = trimmed.ground.limit();
    let mut draw = Draw(0x0b17_5e7a);
    let mut places: Vec<DVec2> = (0..=STEPS)
        .flat_map(|i| (0..=STEPS - i).map(move |j| DVec2::new(f64::from(i), f64::from(j)) / f64::from(STEPS)))
        .collect();
    places.extend((0..places.len()).map(|_| draw.place()).collect::<Vec<_>>());
    let same = |now: FaceId, code: FaceCode| {
        let then = code.root_face(0);
        let at = |face, st| SurfacePoint { face, st };
        places.iter().all(|&st| bits(limit.position(at(now, st))) == bits(given.position(at(then, st))))
    };
    Ok(trimmed.untouched().all(|(face, level, code)| level == 0 && same(face, code)))
}

/// Are the corners of all faces beyond the control points of a level of the given cage, bit for bit?
fn outside_is_subdivided(trimmed: &Trimmed, level: u32) -> bool {
    let (given, left) = (&trimmed.ground.surface, &trimmed.surface);
    let whole = region::whole(&given.mesh, level);
    let then = chain::build(given, &CornerTable::new(given), &given.details, level, &whole);
    let now = chain::root(left, &CornerTable::new(left), &left.details);
    let same = |face: FaceId, code: FaceCode| {
        let Some(there) = then.mesh.find(code) else { return false };
        let corners = now.mesh.corners[face.index()].into_iter().zip(then.mesh.corners[there as usize]);
        corners
            .into_iter()
            .all(|(a, b)| bits(now.state.effective[a as usize]) == bits(then.state.effective[b as usize]))
    };
    trimmed.untouched().all(|(face, of, code)| of == level && same(face, code))
}

/// Patches that are measured, at most: some seconds.
const MOST_PATCHES: usize = 1 << 14;

/// The greatest distance from the trimmed limit surface to the given one: 45 random places of every
/// patch of the finest details around it, by another seed than anything else uses. Where that were too
/// many patches, coarser ones are taken, and of root faces that are too many an even share.
///
/// # Errors
/// If the result cannot be evaluated.
pub fn achieved(trimmed: &Trimmed) -> Result<f64, TrimSceneError> {
    const PLACES: u64 = 45;
    let limit = LimitSurface::new(trimmed.surface.clone())?;
    let target = trimmed.ground.target(Search::AroundHint);
    let finest = trimmed.surface.details.depth();
    let patches = (0..=finest).rev().map(|finest| patches(trimmed, finest)).find(|p| p.len() <= MOST_PATCHES);
    let patches = patches.unwrap_or_else(|| {
        let all = patches_at_root(trimmed);
        let share = all.len().div_ceil(MOST_PATCHES);
        all.into_iter().step_by(share).collect()
    });
    let worst = map_in_order(patches.len(), |p| {
        let (level, code) = patches[p];
        let mut draw = Draw(0x5eed_7a11 ^ (p as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        // Neighbours' feet are near, so only the first is sought everywhere.
        let mut hint = None;
        let mut worst = 0.0_f64;
        for _ in 0..PLACES {
            let x = limit.position(inside(level, code, draw.place()));
            let Ok(foot) = target.closest(x, hint) else { return f64::INFINITY };
            hint = foot.at;
            worst = worst.max(foot.position.distance(x));
        }
        worst
    });
    Ok(worst.into_iter().fold(0.0, f64::max))
}

/// The faces that a trim may have changed.
fn patches_at_root(trimmed: &Trimmed) -> Vec<(u32, FaceCode)> {
    trimmed.remeshed.omega.iter().map(|&code| (0, code)).collect()
}

/// The faces that a trim may have changed, as the patches of the finest details on them, none finer than
/// level `finest`.
fn patches(trimmed: &Trimmed, finest: u32) -> Vec<(u32, FaceCode)> {
    let mesh = &trimmed.surface.mesh;
    let stored = (0_u32..finest).zip(&trimmed.surface.details.levels);
    let finer: Vec<HashSet<FaceCode>> = stored.map(|(level, stored)| faces_around(mesh, level, stored)).collect();
    let mut open = patches_at_root(trimmed);
    let mut done = Vec::new();
    while let Some((level, code)) = open.pop() {
        if finer.get(level as usize).is_some_and(|faces| faces.contains(&code)) {
            open.extend((0..4).map(|c| (level + 1, code.child(c))));
        } else {
            done.push((level, code));
        }
    }
    done
}

/// The faces of `level` that have a detail at a corner.
fn faces_around(mesh: &Connectivity, level: u32, stored: &[(Address, DVec3)]) -> HashSet<FaceCode> {
    let mut faces = Vec::new();
    for (face, corner) in stored.iter().filter_map(|&(address, _)| region::corner_at(mesh, level, address)) {
        faces.push(face);
        region::fan(mesh, level, face, corner, &mut faces);
    }
    faces.into_iter().collect()
}

/// A place of a patch as one of its root face.
fn inside(level: u32, code: FaceCode, st: DVec2) -> SurfacePoint {
    let [a, b, c] = code.corners(level).map(|(i, j)| DVec2::new(f64::from(i), f64::from(j)));
    let p = (a + (b - a) * st.x + (c - a) * st.y) / f64::from(1_u32 << level);
    SurfacePoint { face: code.root_face(level), st: p }
}

/// How far from the curves the limit surface may have changed: the farthest corner of a face that is
/// not as it was, in metres.
///
/// # Errors
/// If the result cannot be evaluated.
pub fn changed_radius(trimmed: &Trimmed) -> Result<f64, TrimSceneError> {
    let limit = LimitSurface::new(trimmed.surface.clone())?;
    let curves: Vec<DVec3> = trimmed.images.iter().flat_map(|i| &i.points).map(|p| p.position).collect();
    let changed: Vec<FaceId> = trimmed.remeshed.omega.iter().map(|code| code.root_face(0)).collect();
    let far = map_in_order(changed.len(), |i| {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|st| limit.position(SurfacePoint { face: changed[i], st }));
        let nearest = |x: DVec3| curves.iter().map(|c| c.distance_squared(x)).fold(f64::INFINITY, f64::min);
        corners.map(nearest).into_iter().fold(0.0, f64::max)
    });
    Ok(far.into_iter().fold(0.0, f64::max).sqrt())
}

/// The greatest number of edges at an interior vertex.
pub fn most_valence(mesh: &Connectivity) -> u32 {
    let inside = (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| !mesh.is_border(v));
    inside.map(|v| mesh.valence(v)).max().unwrap_or(0)
}

/// Numbers that look random: the same on every run.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        // [Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators"]
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A place of a triangle, all as likely.
    fn place(&mut self) -> DVec2 {
        let p = DVec2::new(self.next(), self.next());
        if p.x + p.y > 1.0 { DVec2::ONE - p } else { p }
    }
}
