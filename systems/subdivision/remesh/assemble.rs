//! The surface that remeshing leaves: faces, control points, sides, details, and where each came from.
//!
//! What the curves did not touch keeps its order: vertices and faces of the root mesh come first, in
//! the order they had, with the bits they had.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Address, CornerTable, Details, FaceCode, LoopSurface, NONE};
use selvedge_components::trim::{BorderLine, Junction, Omega};

use super::super::region;
use super::super::relax::Relaxed;
use super::attach::Strip;
use super::closure::{Part, Piece, at_level};
use super::remove::{Fate, Trouble};
use super::{Work, cleanup, manifold, sides};

/// Where a vertex of the new cage came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VertexOrigin {
    /// It is this vertex of the source, with its control point.
    Root(VertexId),
    /// It is the vertex at this address of a level of the source, with that level's control point.
    Lattice {
        /// The level.
        level: u32,
        /// The address at that level.
        address: Address,
    },
    /// It lies on a curve.
    OnCurve {
        /// The curve, by index.
        curve: u32,
        /// Its index among the parameters of its side.
        index: u32,
    },
    /// It is this junction, by index.
    Junction(u32),
}

/// Where a face of the new cage came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceOrigin {
    /// It is this whole face of a level of the source.
    Leaf {
        /// The level.
        level: u32,
        /// The face.
        code: FaceCode,
    },
    /// It is a part of this face of the source, next to a finer one, or was flipped with one.
    Closure {
        /// The level.
        level: u32,
        /// The face.
        code: FaceCode,
    },
    /// It joins the rest to this curve.
    Strip {
        /// The curve, by index.
        curve: u32,
    },
}

/// What a side of the new surface runs along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideOrigin {
    /// The line.
    pub line: BorderLine,
    /// The parameters of its first and last vertex on the line, in the direction of the side, with
    /// the surface on the left: of a curve the curve's own, of a plain side the share of it. On a
    /// closed line they are wrapped, so the second may be the smaller; they agree where the side is
    /// all of it.
    pub range: [f64; 2],
}

/// A remeshed surface.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// The new surface.
    pub surface: LoopSurface,
    /// By vertex.
    pub vertex_origin: Vec<VertexOrigin>,
    /// By face.
    pub face_origin: Vec<FaceOrigin>,
    /// The place of the source that stands for each vertex: the natural correspondence.
    pub natural: Vec<SurfacePoint>,
    /// The source's limit point there; the curve's point for a vertex on a curve.
    pub limit: Vec<DVec3>,
    /// The vertices around which the limit surface is not what it was, ascending: their ring is not the
    /// one they had, or their border is another, or they are next to a vertex with a rule of its own
    /// that is.
    pub changed: Vec<VertexId>,
    /// The faces whose limit patch may differ from the source's, ascending. Beyond them it has the same
    /// bits; where the whole cage was refined for a small reach, it is the same up to rounding.
    pub omega: Vec<FaceCode>,
    /// What became of the faces of the source: leaves that tile it, each with its fate. By root face.
    pub fates: Vec<(u32, FaceCode, Fate)>,
    /// What relaxation did, by contour: a loop of border that the curves make together, or a
    /// stretch of one from border to border.
    pub relaxed: Vec<Relaxed>,
    /// Where curves cross each other, or leave the source across its border.
    pub junctions: Vec<Junction>,
    /// The curves no part of which is a border, because they lie within what others take away;
    /// ascending.
    pub unused: Vec<usize>,
    /// By side of the new surface, what it runs along.
    pub side_origin: Vec<SideOrigin>,
    /// How many faces the valence clean-up changed.
    pub flipped: usize,
}

impl Remeshed {
    /// The places of the source that stand for the corners of a face, where that is a whole face of some
    /// level of it.
    pub fn on_one_face(&self, face: usize) -> Option<[SurfacePoint; 3]> {
        let FaceOrigin::Leaf { level, code } = self.face_origin[face] else { return None };
        Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|weights| code.place(level, weights)))
    }
}

/// The faces that may be fitted: those around changed vertices, with their neighbours or without.
pub(super) fn omega(mesh: &Connectivity, changed: &[VertexId], which: Omega) -> Vec<FaceCode> {
    let around = changed.iter().flat_map(|&v| mesh.ring(v)).map(|h| FaceCode::root(h.face()));
    let around = region::ascending(around.collect());
    match which {
        Omega::Changed => around,
        Omega::Neighbourhood => region::neighbourhood(mesh, 0, &around),
    }
}

/// Makes a surface of what is left and the strips.
pub(super) fn assemble(work: &Work<'_>, relaxed: Vec<Relaxed>) -> Result<Remeshed, Trouble> {
    let mut parts = Parts::gather(work);
    let names = parts.name_vertices(work);
    let vertex_count = parts.vertices.len();
    let mesh = manifold(vertex_count, &parts.triangles)?;
    // Only among vertices that are not as they were: the clean-up takes nothing else along.
    let mut may = vec![false; vertex_count];
    changed(work, &parts, &mesh).into_iter().for_each(|v| may[v.index()] = true);
    // The strips come last and are not flipped: the vertices on their curves are border vertices.
    let flipped = cleanup::clean_up(mesh, &mut parts.triangles, &parts.limit, |v| may[v as usize]);
    for &f in &flipped {
        if let FaceOrigin::Leaf { level, code } = parts.origins[f as usize] {
            parts.origins[f as usize] = FaceOrigin::Closure { level, code };
        }
    }
    let mesh = Arc::new(manifold(vertex_count, &parts.triangles)?);
    let sides = sides::sides(work, &parts, &mesh)?;
    let mut changed = changed(work, &parts, &mesh);
    changed.extend(sides.touched.iter().flat_map(|&v| with_border_neighbours(&mesh, v)));
    let surface = LoopSurface {
        points: parts.points(work),
        corner_rule: work.surface.corner_rule,
        details: details(work, &parts, &names, &mesh, sides.details),
        sides: sides.sides,
        mesh,
    };
    let changed = with_neighbours_of_special(work, &parts, &surface, changed);
    Ok(Remeshed {
        natural: parts.vertices.iter().map(|&v| natural(work, v)).collect(),
        vertex_origin: parts.vertices.iter().map(|&v| origin(work, v)).collect(),
        face_origin: parts.origins,
        limit: parts.limit,
        omega: omega(&surface.mesh, &changed, work.options.omega),
        changed,
        fates: fates(work),
        relaxed,
        junctions: work.plan.junctions.clone(),
        unused: work.plan.unused.clone(),
        side_origin: sides.origins,
        flipped: flipped.len(),
        surface,
    })
}

/// A vertex of the new cage, before it has its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vertex {
    /// A vertex of the adapted cage.
    Lattice(u32),
    /// A knot of a strip.
    Knot(u32, u32),
}

/// The new cage on its way.
pub(super) struct Parts {
    triangles: Vec<[u32; 3]>,
    origins: Vec<FaceOrigin>,
    pub vertices: Vec<Vertex>,
    pub limit: Vec<DVec3>,
}

/// The number of the adapted cage's vertices in the new one, or [`NONE`].
struct Names {
    lattice: Vec<u32>,
    /// The first knot of each strip.
    knots: Vec<u32>,
}

impl Parts {
    /// Kept whole root faces, then the other kept ones, in their order. Vertices still have the
    /// numbers of the adapted cage.
    fn gather(work: &Work<'_>) -> Self {
        let is_root = |p: &Piece| p.level == 0 && p.part == Part::Whole;
        let kept = || (0..work.adapted.triangles.len()).filter(|&f| work.remains.fates[f] == Fate::Kept);
        let roots = kept().filter(|&f| is_root(&work.adapted.sources[f]));
        let order: Vec<usize> = roots.chain(kept().filter(|&f| !is_root(&work.adapted.sources[f]))).collect();
        let origin = |p: &Piece| match p.part {
            Part::Whole => FaceOrigin::Leaf { level: p.level, code: p.leaf },
            Part::Closure => FaceOrigin::Closure { level: p.level, code: p.leaf },
        };
        Self {
            triangles: order.iter().map(|&f| work.adapted.triangles[f]).collect(),
            origins: order.iter().map(|&f| origin(&work.adapted.sources[f])).collect(),
            vertices: Vec::new(),
            limit: Vec::new(),
        }
    }

    /// Numbers the vertices: those of the root mesh in their order, then those of its lattices, then
    /// the knots; renames the triangles and adds those of the strips.
    fn name_vertices(&mut self, work: &Work<'_>) -> Names {
        let lattice = &work.adapted.vertices;
        let mut used = vec![false; lattice.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let mut order: Vec<u32> = (0..lattice.len() as u32).filter(|&v| used[v as usize]).collect();
        order.sort_by_key(|&v| match lattice[v as usize].address {
            Address::Corner(root) => (0, root.0),
            _ => (1, v),
        });
        let mut names = Names { lattice: vec![NONE; lattice.len()], knots: Vec::new() };
        for (name, &v) in order.iter().enumerate() {
            names.lattice[v as usize] = name as u32;
        }
        self.vertices = order.into_iter().map(Vertex::Lattice).collect();
        self.triangles.iter_mut().flatten().for_each(|v| *v = names.lattice[*v as usize]);
        for (s, strip) in work.strips.iter().enumerate() {
            let begin = self.vertices.len() as u32;
            names.knots.push(begin);
            self.vertices.extend((0..strip.knots.len() as u32).map(|k| Vertex::Knot(s as u32, k)));
            let renamed =
                Strip { rim: strip.rim.iter().map(|&v| names.lattice[v as usize]).collect(), ..strip.clone() };
            let triangles = renamed.triangles(|k| begin + k as u32);
            // A triangle belongs to the first of its knots.
            let curve = |t: &[u32; 3]| {
                let knot = t.iter().find(|&&v| v >= begin).map_or(0, |v| v - begin);
                work.curve_of(s as u32, knot)
            };
            self.origins.extend(triangles.iter().map(|t| FaceOrigin::Strip { curve: curve(t) }));
            self.triangles.extend(triangles);
        }
        self.limit = self.vertices.iter().map(|&v| limit(work, v)).collect();
        names
    }

    /// Control points. Those of kept root vertices are the source's own; finer ones have the details
    /// of the levels up to theirs in them.
    fn points(&self, work: &Work<'_>) -> Vec<DVec3> {
        let point = |(v, vertex): (usize, &Vertex)| match *vertex {
            Vertex::Knot(..) => self.limit[v],
            Vertex::Lattice(l) => {
                let lattice = &work.adapted.vertices[l as usize];
                match lattice.address {
                    Address::Corner(root) if lattice.level == 0 => work.surface.points[root.index()],
                    _ => lattice.point,
                }
            }
        };
        self.vertices.iter().enumerate().map(point).collect()
    }
}

fn limit(work: &Work<'_>, vertex: Vertex) -> DVec3 {
    match vertex {
        Vertex::Lattice(l) => work.adapted.vertices[l as usize].limit,
        Vertex::Knot(s, k) => {
            let spot = work.parameters[s as usize].spots[k as usize];
            let on_curve = || work.cuts[work.curve_of(s, k) as usize].curve.position(spot.u);
            spot.junction.map_or_else(on_curve, |j| work.plan.junctions[j as usize].point)
        }
    }
}

fn origin(work: &Work<'_>, vertex: Vertex) -> VertexOrigin {
    match vertex {
        Vertex::Lattice(l) => {
            let v = &work.adapted.vertices[l as usize];
            match v.address {
                Address::Corner(root) if v.level == 0 => VertexOrigin::Root(root),
                _ => VertexOrigin::Lattice { level: v.level, address: at_level(v.address, v.birth, v.level) },
            }
        }
        Vertex::Knot(s, k) => {
            let parameters = &work.parameters[s as usize];
            let index = parameters.indices[k as usize] as u32;
            let on_curve = VertexOrigin::OnCurve { curve: work.curve_of(s, k), index };
            parameters.spots[k as usize].junction.map_or(on_curve, VertexOrigin::Junction)
        }
    }
}

fn natural(work: &Work<'_>, vertex: Vertex) -> SurfacePoint {
    match vertex {
        Vertex::Lattice(l) => {
            let v = &work.adapted.vertices[l as usize];
            place_of(&work.surface.mesh, v.birth, v.address)
        }
        Vertex::Knot(s, k) => {
            let (strip, track) = (&work.strips[s as usize], &work.plan.track);
            track.source(track.place_of_parameter(strip.cut, strip.knots[k as usize].t))
        }
    }
}

/// The place of the vertex at `address` of `level`.
pub fn place_of(mesh: &Connectivity, level: u32, address: Address) -> SurfacePoint {
    let n = f64::from(1_u32 << level);
    let on = |h: HalfedgeId, w: f64| {
        let mut weights = [0.0; 3];
        weights[h.corner()] = 1.0 - w;
        weights[h.next().corner()] = w;
        SurfacePoint::new(h.face(), weights[1], weights[2])
    };
    match address {
        Address::Corner(v) => on(mesh.outgoing(v), 0.0),
        Address::Edge(e, steps) => {
            let h = mesh.halfedge(e);
            let w = f64::from(steps) / n;
            on(h, if mesh.from(h) < mesh.to(h) { w } else { 1.0 - w })
        }
        Address::Face(f, i, j) => SurfacePoint::new(f, f64::from(i) / n, f64::from(j) / n),
    }
}

/// What became of each leaf: kept if all of it is, cut if a part of it is cut.
fn fates(work: &Work<'_>) -> Vec<(u32, FaceCode, Fate)> {
    let mut fates: Vec<(u32, FaceCode, Fate)> = Vec::new();
    for (piece, &fate) in work.adapted.sources.iter().zip(&work.remains.fates) {
        match fates.last_mut() {
            Some(last) if (last.0, last.1) == (piece.level, piece.leaf) => {
                if last.2 != fate {
                    last.2 = Fate::Cut;
                }
            }
            _ => fates.push((piece.level, piece.leaf, fate)),
        }
    }
    debug_assert!(fates.iter().all(|&(level, code, _)| work.leaves.is_leaf(level, code)));
    fates
}

/// The new number of every vertex of the source, or [`NONE`].
fn root_names(work: &Work<'_>, parts: &Parts) -> Vec<u32> {
    let mut of_root = vec![NONE; work.surface.mesh.vertex_count()];
    for (name, vertex) in parts.vertices.iter().enumerate() {
        if let Vertex::Lattice(l) = *vertex
            && let Address::Corner(root) = work.adapted.vertices[l as usize].address
        {
            of_root[root.index()] = name as u32;
        }
    }
    of_root
}

/// The details that still have their place: at root vertices, edges and faces that are here as they
/// were; and the boundary details of finer vertices on given borders.
fn details(
    work: &Work<'_>,
    parts: &Parts,
    names: &Names,
    mesh: &Connectivity,
    on_sides: Vec<(VertexId, DVec3)>,
) -> Details {
    let source = work.surface;
    let of_root = root_names(work, parts);
    let mut face_of = vec![NONE; source.mesh.face_count()];
    for (f, origin) in parts.origins.iter().enumerate() {
        if let FaceOrigin::Leaf { level: 0, code } = origin {
            face_of[code.root_face(0).index()] = f as u32;
        }
    }
    let unrefined = |v: VertexId| {
        let name = of_root[v.index()];
        name != NONE
            && matches!(parts.vertices[name as usize], Vertex::Lattice(l) if work.adapted.vertices[l as usize].level == 0)
    };
    let moved = |address: Address| match address {
        Address::Corner(v) => unrefined(v).then(|| Address::Corner(VertexId(of_root[v.index()]))),
        Address::Edge(e, steps) => {
            let h = source.mesh.halfedge(e);
            let here =
                [Some(h), source.mesh.twin(h)].into_iter().flatten().find(|h| face_of[h.face().index()] != NONE)?;
            // A kept face has its corners in the order it had, and the order of the vertices is kept.
            let now = HalfedgeId::of(FaceId(face_of[here.face().index()]), here.corner());
            Some(Address::Edge(mesh.edge(now), steps))
        }
        Address::Face(f, i, j) => (face_of[f.index()] != NONE).then(|| Address::Face(FaceId(face_of[f.index()]), i, j)),
    };
    let mut levels: Vec<Vec<(Address, DVec3)>> = source
        .details
        .levels
        .iter()
        .map(|level| level.iter().filter_map(|&(address, d)| Some((moved(address)?, d))).collect())
        .collect();
    let boundary = work.adapted.vertices.iter().zip(&names.lattice);
    let boundary: Vec<_> = boundary
        .filter(|(v, name)| **name != NONE && v.level > 0 && v.detail != DVec3::ZERO)
        .filter(|(_, name)| !on_sides.iter().any(|(v, _)| v.0 == **name))
        .map(|(v, &name)| (Address::Corner(VertexId(name)), v.detail))
        .collect();
    if !boundary.is_empty() || !on_sides.is_empty() {
        if levels.is_empty() {
            levels.push(Vec::new());
        }
        // A vertex whose border has become another has no other detail.
        levels[0].retain(|d| !on_sides.iter().any(|(v, _)| d.0 == Address::Corner(*v)));
        levels[0].extend(boundary);
        levels[0].extend(on_sides.into_iter().map(|(v, d)| (Address::Corner(v), d)));
    }
    levels.iter_mut().for_each(|level| level.sort_unstable_by_key(|d| d.0));
    Details { levels }
}

/// A vertex whose boundary sample or detail is another, and the border vertices next to it: new points
/// on the edges between them are others, too.
fn with_border_neighbours(mesh: &Connectivity, v: VertexId) -> impl Iterator<Item = VertexId> + '_ {
    let leaving = mesh.ring(v).filter(|&h| mesh.twin(h).is_none()).map(|h| mesh.to(h));
    let arriving = mesh.ring(v).map(HalfedgeId::previous).filter(|&h| mesh.twin(h).is_none()).map(|h| mesh.from(h));
    leaving.chain(arriving).chain([v])
}

/// The changed vertices, ascending, with the neighbours of those that have a rule of their own now or had
/// one: it makes the new points on all edges that lead there.
fn with_neighbours_of_special(
    work: &Work<'_>,
    parts: &Parts,
    surface: &LoopSurface,
    mut changed: Vec<VertexId>,
) -> Vec<VertexId> {
    let (then, now) = (CornerTable::new(work.surface), CornerTable::new(surface));
    let was_special = |v: VertexId| match parts.vertices[v.index()] {
        Vertex::Lattice(l) => match work.adapted.vertices[l as usize].address {
            Address::Corner(root) => then.of(root) != NONE,
            _ => false,
        },
        Vertex::Knot(..) => false,
    };
    let special: Vec<VertexId> = changed.iter().copied().filter(|&v| now.of(v) != NONE || was_special(v)).collect();
    for v in special {
        // Beyond the last edge that a ring's half-edges lead along there is the border's other neighbour.
        changed.extend(surface.mesh.ring(v).flat_map(|h| [surface.mesh.to(h), surface.mesh.opposite(h)]));
    }
    changed.sort_unstable();
    changed.dedup();
    changed
}

/// The vertices whose ring is not the one they had in the source, at the level that the whole cage
/// was brought to.
fn changed(work: &Work<'_>, parts: &Parts, mesh: &Connectivity) -> Vec<VertexId> {
    let source = &work.surface.mesh;
    let faces_then = |address: Address| match address {
        Address::Corner(root) => source.ring(root).count(),
        Address::Edge(e, _) if source.twin(source.halfedge(e)).is_none() => 3,
        Address::Edge(..) | Address::Face(..) => 6,
    };
    let is_whole = |h: HalfedgeId| matches!(parts.origins[h.face().index()], FaceOrigin::Leaf { level, .. } if level == work.options.adapt.base);
    let same = |v: VertexId| {
        let Vertex::Lattice(l) = parts.vertices[v.index()] else { return false };
        let then = faces_then(work.adapted.vertices[l as usize].address);
        mesh.ring(v).all(is_whole) && mesh.ring(v).count() == then
    };
    (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| !same(v)).collect()
}
