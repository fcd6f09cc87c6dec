//! Which part of a source a trim can touch, and that part as a surface of its own.

use std::sync::Arc;

use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Address, Border, Details, Ends, FaceCode, LoopSurface, NONE, Side};

use super::rename::{Names, rename_details};
use crate::subdivision::region;
use crate::subdivision::remesh::{Beyond, PreImage};

/// How far a trim is thought to change its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Rings of faces around those that the curves run through.
    pub rings: u32,
    /// Of them, the outer ones, which are not divided: what changes there is what the fit adds.
    pub outer: u32,
    /// Which sides of the border are taken in.
    pub sides: SidesMet,
}

/// Which sides of the border a trim takes in: all along, for a side is one curve and is worked on as a
/// whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SidesMet {
    /// Those with an edge where faces are divided.
    Divided,
    /// Those that are met at all, and those that these meet.
    All,
}

/// The root faces that trims with these pre-images may change.
pub fn reserve<'a>(
    surface: &LoopSurface,
    images: impl IntoIterator<Item = &'a PreImage>,
    Extent { rings, outer, sides }: Extent,
) -> Vec<FaceCode> {
    let crossed = images.into_iter().flat_map(|image| &image.points).map(|p| FaceCode::root(p.at.face));
    let divided = grown(&surface.mesh, region::ascending(crossed.collect()), rings.saturating_sub(outer));
    let mut reserved = grown(&surface.mesh, divided.clone(), outer.min(rings));
    let mut met = vec![false; surface.sides.len()];
    let next = |met: &[bool], reserved: &[FaceCode]| {
        let near = if sides == SidesMet::All { reserved } else { &divided };
        (0..met.len()).find(|&s| !met[s] && meets(&surface.mesh, &surface.sides[s], near))
    };
    while let Some(s) = next(&met, &reserved) {
        met[s] = true;
        let along = side_edges(&surface.mesh, &surface.sides[s]).map(|h| FaceCode::root(h.face()));
        reserved.extend(grown(&surface.mesh, region::ascending(along.collect()), 2));
        reserved = region::ascending(reserved);
    }
    reserved
}

fn grown(mesh: &Connectivity, faces: Vec<FaceCode>, rings: u32) -> Vec<FaceCode> {
    (0..rings).fold(faces, |faces, _| region::neighbourhood(mesh, 0, &faces))
}

fn meets(mesh: &Connectivity, side: &Side, faces: &[FaceCode]) -> bool {
    side_edges(mesh, side).any(|h| faces.binary_search(&FaceCode::root(h.face())).is_ok())
}

/// Is a mesh of one part a disc or a sphere?
fn is_simple(mesh: &Connectivity) -> bool {
    let loops = mesh.border_loops().len() as i64;
    loops <= 1 && mesh.euler() == 2 - loops
}

/// By face of `mesh`, which of the parts that the `wanted` faces hang together in it is of, or [`NONE`]; and
/// how many there are.
fn parts(mesh: &Connectivity, wanted: impl Fn(FaceId) -> bool) -> (Vec<u32>, usize) {
    let mut part_of = vec![NONE; mesh.face_count()];
    let (mut count, mut stack) = (0, Vec::new());
    for seed in (0..mesh.face_count()).map(FaceId::new) {
        if part_of[seed.index()] != NONE || !wanted(seed) {
            continue;
        }
        part_of[seed.index()] = count;
        stack.push(seed);
        while let Some(face) = stack.pop() {
            for next in (0..3).filter_map(|c| mesh.twin(HalfedgeId::of(face, c))).map(HalfedgeId::face) {
                if part_of[next.index()] == NONE && wanted(next) {
                    part_of[next.index()] = count;
                    stack.push(next);
                }
            }
        }
        count += 1;
    }
    (part_of, count as usize)
}

/// The border half-edges of a side, in its direction.
fn side_edges<'a>(mesh: &'a Connectivity, side: &'a Side) -> impl Iterator<Item = HalfedgeId> + 'a {
    side.vertices[..side.edge_count()].iter().map(|&v| mesh.outgoing(v))
}

/// Some faces of a source, as a mesh of their own: vertices and faces keep their order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zone {
    /// Its faces in the source, ascending.
    pub faces: Vec<FaceId>,
    /// Its vertices in the source, ascending.
    pub vertices: Vec<VertexId>,
}

/// What a side of a zone is of a side of the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneSide {
    /// All of this one.
    Whole(usize),
    /// A part of one, beyond what a trim in the zone can touch.
    Part,
    /// Nothing: the zone ends there, and the source goes on.
    Inside,
}

impl Zone {
    /// A zone of `reserved` faces with two rings around them, which shape what lies inside; or of all
    /// faces, where that would be most of them.
    pub fn around(mesh: &Connectivity, reserved: &[FaceCode]) -> Option<Self> {
        let faces = close_pinches(mesh, grown(mesh, reserved.to_vec(), 2));
        // A zone costs a copy: it is worth it where much is left out.
        (4 * faces.len() <= 3 * mesh.face_count()).then(|| Self::of(mesh, &faces))
    }

    /// All of a mesh.
    pub fn whole(mesh: &Connectivity) -> Self {
        let faces = (0..mesh.face_count()).map(FaceId::new).collect();
        Self { faces, vertices: (0..mesh.vertex_count()).map(VertexId::new).collect() }
    }

    fn of(mesh: &Connectivity, faces: &[FaceCode]) -> Self {
        let faces: Vec<FaceId> = faces.iter().map(|f| f.root_face(0)).collect();
        let mut vertices: Vec<VertexId> = faces.iter().flat_map(|&f| mesh.face(f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Self { faces, vertices }
    }

    /// The zone's own name of a face of the source.
    pub fn face(&self, of_source: FaceId) -> Option<FaceId> {
        self.faces.binary_search(&of_source).ok().map(FaceId::new)
    }

    /// The zone's own name of a vertex of the source.
    pub fn vertex(&self, of_source: VertexId) -> Option<VertexId> {
        self.vertices.binary_search(&of_source).ok().map(VertexId::new)
    }

    /// The pre-image as it runs on the zone; `None` if it leaves it.
    pub fn narrow(&self, image: &PreImage) -> Option<PreImage> {
        let mut image = image.clone();
        for point in &mut image.points {
            point.at = SurfacePoint { face: self.face(point.at.face)?, ..point.at };
        }
        Some(image)
    }

    /// How faces at the zone's rim hang together beyond it, by the zone's names; `own` is its mesh.
    ///
    /// None where that cannot matter: on a disc or a sphere every curve separates, and of a zone of one part
    /// nothing beyond it has a number that the zone does not have.
    pub fn beyond(&self, source: &Connectivity, own: &Connectivity) -> Beyond {
        if is_simple(source) && parts(own, |_| true).1 == 1 {
            return Beyond::default();
        }
        let mut inside = vec![false; source.face_count()];
        self.faces.iter().for_each(|f| inside[f.index()] = true);
        let (part_of, count) = parts(source, |f| !inside[f.index()]);
        // By part beyond, the last face that was found at its rim: each hangs together with the next.
        let (mut last, mut pairs) = (vec![None; count], Vec::new());
        for (f, face) in self.faces.iter().enumerate() {
            let next = (0..3).filter_map(|c| source.twin(HalfedgeId::of(*face, c)));
            for part in next.map(|twin| part_of[twin.face().index()]).filter(|&part| part != NONE) {
                let here = FaceId::new(f);
                let before = last[part as usize].replace(here).filter(|&before| before != here);
                pairs.extend(before.map(|before| [before, here]));
            }
        }
        Beyond(pairs)
    }

    /// The zone as a surface, and what its sides are of the source's. `None` if its faces make no
    /// manifold, which those of [`Self::around`] do.
    pub fn extract(&self, source: &LoopSurface) -> Option<(LoopSurface, Vec<ZoneSide>)> {
        let name = |v: VertexId| self.vertex(v).map(|v| v.0);
        let faces = self.faces.iter().map(|&f| {
            let [a, b, c] = source.mesh.face(f).map(name);
            Some([a?, b?, c?])
        });
        let faces: Vec<[u32; 3]> = faces.collect::<Option<_>>()?;
        let mesh = Arc::new(Connectivity::new(self.vertices.len(), &faces).ok()?);
        let (sides, kinds) = self.sides(source, &mesh);
        let points = self.vertices.iter().map(|v| source.points[v.index()]).collect();
        let details = self.details(source, &mesh);
        Some((LoopSurface { mesh, points, sides, corner_rule: source.corner_rule, details }, kinds))
    }

    fn details(&self, source: &LoopSurface, mesh: &Connectivity) -> Details {
        struct Into<'a>(&'a Zone);
        impl Names for Into<'_> {
            fn vertex(&self, v: VertexId) -> Option<VertexId> {
                self.0.vertex(v)
            }
            fn face(&self, f: FaceId) -> Option<FaceId> {
                self.0.face(f)
            }
        }
        let renamed = |level: &Vec<(Address, glam::DVec3)>| rename_details(level, &source.mesh, mesh, &Into(self));
        Details { levels: source.details.levels.iter().map(renamed).collect() }
    }

    fn sides(&self, source: &LoopSurface, mesh: &Connectivity) -> (Vec<Side>, Vec<ZoneSide>) {
        let (mut sides, mut kinds) = (Vec::new(), Vec::new());
        let mut named = vec![false; mesh.edge_count()];
        for (s, side) in source.sides.iter().enumerate() {
            for (run, kind) in self.runs(source, s, side) {
                for h in side_edges(mesh, &run) {
                    named[mesh.edge(h).index()] = true;
                }
                sides.push(run);
                kinds.push(kind);
            }
        }
        for walk in mesh.border_loops() {
            let inside = |i: usize| !named[mesh.edge(mesh.outgoing(walk[i])).index()];
            for (vertices, ends) in runs_of(&walk, inside) {
                sides.push(Side { vertices, ends, border: Border::Plain });
                kinds.push(ZoneSide::Inside);
            }
        }
        (sides, kinds)
    }

    /// The parts of a side of the source that lie in the zone.
    fn runs(&self, source: &LoopSurface, s: usize, side: &Side) -> Vec<(Side, ZoneSide)> {
        let walk = &side.vertices[..side.edge_count()];
        let here = |i: usize| self.face(source.mesh.outgoing(walk[i]).face()).is_some();
        let name = |v: VertexId| self.vertex(v).unwrap_or(v);
        if (0..walk.len()).all(here) {
            let vertices = side.vertices.iter().map(|&v| name(v)).collect();
            return vec![(Side { vertices, ..side.clone() }, ZoneSide::Whole(s))];
        }
        let mut runs = Vec::new();
        let closed = side.ends == Ends::Closed;
        let begins = |&i: &usize| here(i) && !(if i > 0 { here(i - 1) } else { closed && here(walk.len() - 1) });
        for begin in (0..walk.len()).filter(begins) {
            let count = (0..walk.len()).take_while(|k| {
                let i = begin + k;
                (closed || i < walk.len()) && here(i % walk.len())
            });
            let count = count.count();
            let at = |i: usize| name(side.vertices[if closed { i % walk.len() } else { i }]);
            let vertices = (begin..=begin + count).map(at).collect();
            let border = match &side.border {
                Border::Plain => Border::Plain,
                Border::Given { curve, first, heading } => Border::Given {
                    curve: Arc::clone(curve),
                    first: side.curve_index(0, begin as u64).unwrap_or(*first),
                    heading: *heading,
                },
            };
            runs.push((Side { vertices, ends: Ends::Corners, border }, ZoneSide::Part));
        }
        runs
    }
}

/// The stretches of a closed walk whose edges are `wanted`, each with its last vertex.
fn runs_of(walk: &[VertexId], wanted: impl Fn(usize) -> bool) -> Vec<(Vec<VertexId>, Ends)> {
    let n = walk.len();
    if (0..n).all(&wanted) {
        return vec![(walk.to_vec(), Ends::Closed)];
    }
    let begins = (0..n).filter(|&i| wanted(i) && !wanted((i + n - 1) % n));
    let run = |begin: usize| {
        let count = (0..n).take_while(|k| wanted((begin + k) % n)).count();
        ((begin..=begin + count).map(|i| walk[i % n]).collect(), Ends::Corners)
    };
    begins.map(run).collect()
}

/// Adds what is missing around vertices where `faces` meet in a point only.
fn close_pinches(mesh: &Connectivity, mut faces: Vec<FaceCode>) -> Vec<FaceCode> {
    loop {
        let zone = Zone::of(mesh, &faces);
        let pinched = zone.vertices.iter().filter(|&&v| fans(mesh, v, &faces) > 1);
        let more: Vec<FaceCode> = pinched.flat_map(|&v| mesh.ring(v)).map(|h| FaceCode::root(h.face())).collect();
        if more.is_empty() {
            return faces;
        }
        faces.extend(more);
        faces = region::ascending(faces);
    }
}

/// In how many fans do `faces` stand around `v`?
fn fans(mesh: &Connectivity, v: VertexId, faces: &[FaceCode]) -> usize {
    let here: Vec<bool> = mesh.ring(v).map(|h| faces.binary_search(&FaceCode::root(h.face())).is_ok()).collect();
    let before = |i: usize| if i > 0 { here[i - 1] } else { !mesh.is_border(v) && here[here.len() - 1] };
    let begins = (0..here.len()).filter(|&i| here[i] && !before(i)).count();
    if begins == 0 && here.first() == Some(&true) { 1 } else { begins }
}

/// The edge of `to` that stands for an edge of `from`.
pub(super) fn edge_of(from: &Connectivity, to: &Connectivity, names: &dyn Names, edge: EdgeId) -> Option<EdgeId> {
    let h = from.halfedge(edge);
    let sides = [Some(h), from.twin(h)];
    let face = sides.into_iter().flatten().find_map(|h| Some((names.face(h.face())?, h.corner())));
    face.map(|(face, corner)| to.edge(HalfedgeId::of(face, corner)))
}
