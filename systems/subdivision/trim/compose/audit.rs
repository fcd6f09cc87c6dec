//! Is a result, near the places where pieces meet, what its pieces are?
//!
//! Pieces are audited before they are put together. What that may change is where a vertex has faces of a
//! piece beside others, and at corners of the border: there limit points of the result are compared with the
//! piece's own, which were computed from other meshes.

use glam::DVec3;
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::subdivision::{CornerTable, Ends, FaceCode, LoopSurface, NONE};
use selvedge_components::trim::{TrimAuditFault, TrimFault};

use super::roster::Face;
use super::{Assembly, Composer, Misfit, Piece};
use crate::parallel::map_dear_in_order;
use crate::subdivision::region;
use crate::subdivision::remesh::field::Field;

/// Places looked at for each piece, at most, spread evenly over those where it meets others: what goes wrong
/// there goes wrong by a rule, and so at many.
const PLACES: usize = 12;

/// The level at whose vertices limit points are compared: six points of each face.
const LEVEL: u32 = 1;

/// Sums of a dozen products, whose order may differ, are the same up to this part of a surface's size.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Compares a result with its pieces.
///
/// # Errors
/// The first piece that is not what it was, with [`TrimFault::Audit`].
pub(super) fn audit(composer: &Composer<'_>, assembly: &Assembly, surface: &LoopSurface) -> Result<(), Misfit> {
    let pairs = pairs(composer, assembly, surface);
    let all = region::ascending(pairs.iter().flatten().map(|pair| FaceCode::root(pair[0])).collect());
    if all.is_empty() {
        return Ok(());
    }
    let whole = field(surface, &all);
    let size = surface.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let faults = map_dear_in_order(pairs.len(), |p| {
        let piece = composer.pieces[p].surface;
        let own = region::ascending(pairs[p].iter().map(|pair| FaceCode::root(pair[1])).collect());
        let part = field(piece, &own);
        pairs[p].iter().find_map(|&[face, of_piece]| {
            let turn = turn(assembly, composer, p as u32, [face, of_piece], [surface, piece])?;
            let (now, then) = (points(&whole, face)?, points(&part, of_piece)?);
            (0..6).find_map(|k| {
                let (at, was) = (now[k], then[k / 3 * 3 + (k + turn) % 3]);
                let distance = at.distance(was);
                // Neither has a limit point where its ring is not whole.
                let same = distance <= ROUNDING * size || (at.is_nan() && was.is_nan());
                (!same).then_some(TrimAuditFault::Composed { face: face.0, distance, at })
            })
        })
    });
    let first = faults.into_iter().enumerate().find_map(|(piece, fault)| Some((piece, fault?)));
    first.map_or(Ok(()), |(piece, fault)| Err(Misfit { piece, why: TrimFault::Audit { faults: vec![fault] } }))
}

/// By piece, faces of the result next to a place where it meets others, each with the piece's own.
fn pairs(composer: &Composer<'_>, assembly: &Assembly, surface: &LoopSurface) -> Vec<Vec<[FaceId; 2]>> {
    let mesh = &*assembly.mesh;
    let owner = |f: usize| if let Face::Piece(p, _) = assembly.roster.faces[f] { p } else { NONE };
    // By piece, the vertices with faces of others too, and the corners of the border.
    let mut places: Vec<Vec<VertexId>> = vec![Vec::new(); composer.pieces.len()];
    let mut first = vec![None; mesh.vertex_count()];
    let mut offer = |v: VertexId, p: u32| {
        if p != NONE {
            places[p as usize].push(v);
        }
    };
    for f in 0..mesh.face_count() {
        let own = owner(f);
        for v in mesh.face(FaceId::new(f)) {
            match first[v.index()] {
                None => first[v.index()] = Some(own),
                Some(other) if other != own => {
                    offer(v, own);
                    offer(v, other);
                }
                Some(_) => {}
            }
        }
    }
    let ends = surface.sides.iter().filter(|side| side.ends == Ends::Corners).map(|side| side.vertices[0]);
    ends.for_each(|v| offer(v, first[v.index()].unwrap_or(NONE)));
    let of_piece = |(p, mut places): (usize, Vec<VertexId>)| {
        let piece = &composer.pieces[p];
        places.sort_unstable();
        places.dedup();
        let stride = places.len().div_ceil(PLACES).max(1);
        let around = places.into_iter().step_by(stride).flat_map(|v| mesh.ring(v).map(|h| h.face()));
        let mut faces: Vec<FaceId> = around.collect();
        faces.sort_unstable();
        faces.dedup();
        let still = still(piece);
        let own = |face: FaceId| match assembly.roster.faces[face.index()] {
            Face::Piece(q, f) => (q as usize == p).then_some(FaceId(f)),
            Face::Source(f) => still.binary_search_by_key(&f, |pair| pair.0).ok().map(|i| FaceId(still[i].1)),
        };
        let pairs = faces.into_iter().filter_map(|face| Some([face, own(face)?]));
        pairs.filter(|pair| is_inside(composer, assembly, p as u32, pair[1])).collect()
    };
    places.into_iter().enumerate().map(of_piece).collect()
}

/// The faces of the source that a piece still has, ascending, with its own.
fn still(piece: &Piece<'_>) -> Vec<(u32, u32)> {
    let mut still: Vec<(u32, u32)> =
        (0_u32..).zip(&piece.still).filter(|(_, still)| **still != NONE).map(|(own, &still)| (still, own)).collect();
    still.sort_unstable();
    still
}

/// Does the piece have all around one of its faces? At the rim of its zone it ends where the result goes on.
fn is_inside(composer: &Composer<'_>, assembly: &Assembly, p: u32, face: FaceId) -> bool {
    let mesh = &composer.pieces[p as usize].surface.mesh;
    let near = mesh.face(face).into_iter().flat_map(|v| mesh.ring(v)).flat_map(|h| mesh.face(h.face()));
    near.into_iter().all(|v| {
        !mesh.is_border(v) || assembly.roster.of_piece(composer, p, v).is_some_and(|v| assembly.mesh.is_border(v))
    })
}

fn field(surface: &LoopSurface, faces: &[FaceCode]) -> Field {
    let corners = CornerTable::new(surface);
    Field::new(surface, &corners, LEVEL, &region::children(faces))
}

/// The limit points at the corners of a face, and in the middles of its edges.
fn points(field: &Field, face: FaceId) -> Option<[DVec3; 6]> {
    let mut points = [DVec3::NAN; 6];
    for i in 0..3 {
        let child = field.level.mesh.find(FaceCode::root(face).child(i))?;
        let corners = field.triangle(child);
        (points[i], points[3 + i]) = (corners[i], corners[(i + 1) % 3]);
    }
    Some(points)
}

/// Which corner of the piece's face the first of the result's is.
fn turn(
    assembly: &Assembly,
    composer: &Composer<'_>,
    p: u32,
    [face, own]: [FaceId; 2],
    [surface, piece]: [&LoopSurface; 2],
) -> Option<usize> {
    let first = surface.mesh.face(face)[0];
    piece.mesh.face(own).iter().position(|&v| assembly.roster.of_piece(composer, p, v) == Some(first))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use selvedge_components::budget::Budgets;
    use selvedge_components::curve::{Circle, Heading};
    use selvedge_components::mesh::Connectivity;
    use selvedge_components::tolerance::Tolerance;
    use selvedge_components::trim::TrimOptions;

    use super::super::Solved;
    use super::*;
    use crate::projected_curve::{Pick, ProjectedCurve};
    use crate::subdivision::remesh::Cut;
    use crate::subdivision::trim::{Ground, LocateWork, TrimWork};

    /// A wavy plate of 20 by 20 squares of unit size.
    fn plate() -> LoopSurface {
        let at = |i: u32| f64::from(i) - 10.0;
        let points = (0..=20).flat_map(|i| (0..=20).map(move |j| (at(i), at(j))));
        let points: Vec<DVec3> =
            points.map(|(x, y)| DVec3::new(x, y, 0.1 * (0.6 * x).sin() * (0.5 * y).cos())).collect();
        let squares = (0..20).flat_map(|i| (0..20).map(move |j| i * 21 + j));
        let faces: Vec<[u32; 3]> = squares.flat_map(|a| [[a, a + 21, a + 22], [a, a + 22, a + 1]]).collect();
        let mesh = Connectivity::new(points.len(), &faces).expect("sound");
        LoopSurface::plain(Arc::new(mesh), points, &[])
    }

    /// What is left by a bore.
    fn bored(ground: &Arc<Ground>, x: f64, y: f64, radius: f64) -> Solved {
        let circle = Circle::new(DVec3::new(x, y, 0.0), DVec3::Z, radius).expect("a circle");
        let index = Arc::clone(&ground.index);
        let curve = ProjectedCurve::new(Arc::new(circle), DVec3::Z, index, Pick::Nearest).expect("a direction");
        let cut = Cut::new(Arc::new(curve), Heading::Against);
        let (options, tolerance) = (TrimOptions::default(), Some(Tolerance::total(1e-4)));
        let mut locate = LocateWork::new(Arc::clone(ground), vec![cut], options, tolerance).expect("sound");
        let located = locate.run().expect("on the plate");
        let mut work = TrimWork::new(Arc::clone(ground), vec![located], locate.reserved().to_vec());
        work.run(&Budgets::default()).map_err(|blamed| blamed.why).expect("made");
        Solved {
            together: Vec::new(),
            number: 0,
            zone: work.zone().cloned(),
            remeshed: Arc::clone(work.remeshed().expect("a cage")),
            surface: Arc::clone(work.result().expect("a result")),
            others: Vec::new(),
        }
    }

    /// A result is compared with pieces that were computed from meshes of their own; whatever is moved next to
    /// where they meet the rest is found, and placed.
    #[test]
    fn a_result_that_is_not_what_its_pieces_were_is_refused_where_it_is_not() {
        let ground = Arc::new(Ground::new(Arc::new(plate()), 0).expect("sound"));
        let solved = [bored(&ground, -5.0, -5.0, 0.8), bored(&ground, 5.0, 5.0, 0.7)];
        let pieces = solved.iter().map(|solved| Piece::new(solved, solved.zone.as_deref().expect("a part of it")));
        let composer = Composer::new(&ground.surface, pieces.collect());
        let surface = composer.compose().expect("they go together");
        let faces = composer.faces().into_iter().filter(|&face| {
            let (own, root) = composer.root_of(face);
            let gone = |p: usize| composer.gone(p).expect("they separate")[root.index()];
            (0..2).all(|p| Some(p) == own || !gone(p))
        });
        let assembly = Assembly::of(&composer, faces.collect()).expect("a mesh");
        assert_eq!(audit(&composer, &assembly, &surface), Ok(()));
        let pairs = pairs(&composer, &assembly, &surface);
        assert!(pairs.iter().all(|pairs| pairs.len() > 20), "both are looked at");
        for (p, pairs) in pairs.iter().enumerate() {
            let v = surface.mesh.face(pairs[0][0])[0];
            let mut moved = surface.clone();
            moved.points[v.index()].z += 1e-9;
            let Err(Misfit { piece, why: TrimFault::Audit { faults } }) = audit(&composer, &assembly, &moved) else {
                panic!("{p}: what was moved is found");
            };
            let [TrimAuditFault::Composed { distance, at, .. }] = faults[..] else { panic!("{faults:?}") };
            assert!(piece == p && distance > 1e-11 && distance < 1e-9, "{piece}: {distance:e}");
            assert!(at.distance(surface.points[v.index()]) < 3.0, "{at}");
        }
    }
}
