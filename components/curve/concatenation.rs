//! Several curves end to end.

use std::sync::Arc;

use glam::DVec3;

use super::guard::{call, catch};
use super::{Branch, CORNER_TURN, Curve, CurveError, Extent, ShapeError, angle, canonical, length, tangent};

/// Curves end to end, each over a share of the parameter that is its share of the length.
///
/// So pieces of constant speed, such as segments and arcs, give a curve of constant speed, and a
/// smooth join is smooth in the parameter too. At a join the later piece gives the point, to the
/// bit; a corner of a piece is met to the bit as well. A join is a corner if the tangent turns by
/// [`CORNER_TURN`] or more, or is missing.
///
/// Corners are found once; the revision is the sum of those of the pieces.
///
/// ```
/// use core::f64::consts::PI;
/// use std::sync::Arc;
/// use glam::DVec3;
/// use selvedge_components::curve::{CircularArc, Concatenation, Curve, Extent, Segment};
///
/// // A half disc: its round side meets the straight one at two corners.
/// let round = CircularArc::from_axes(DVec3::ZERO, DVec3::X, DVec3::Y, 1.0, 0.0, PI)?;
/// let straight = Segment { start: -DVec3::X, end: DVec3::X };
/// let half = Concatenation::new(vec![Arc::new(round), Arc::new(straight)], Extent::Closed, 1e-12)?;
/// assert_eq!(half.corners().len(), 2);
/// assert!((half.corners()[1] - PI / (PI + 2.0)).abs() < 1e-15);
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Concatenation {
    pieces: Vec<Arc<dyn Curve>>,
    /// Where each piece begins, and 1.
    breaks: Vec<f64>,
    corners: Vec<f64>,
    /// What each of `corners` is on its piece, of which `local` may be a rounding off.
    places: Vec<Place>,
    extent: Extent,
}

/// A parameter of one piece.
#[derive(Clone, Copy, Debug)]
struct Place {
    piece: usize,
    u: f64,
}

impl Concatenation {
    /// The curve through `pieces` in their order; closed, the last one leads back to the first.
    /// `gap` is the greatest distance, in model units, between the end of a piece and the
    /// beginning of the next.
    ///
    /// # Errors
    /// [`ShapeError::TooFew`] for no pieces, [`ShapeError::Gap`], [`ShapeError::PieceLength`], or
    /// [`ShapeError::Piece`] for one that cannot be evaluated.
    pub fn new(pieces: Vec<Arc<dyn Curve>>, extent: Extent, gap: f64) -> Result<Self, ShapeError> {
        if pieces.is_empty() {
            return Err(ShapeError::TooFew { what: "pieces", count: 0, needed: 1 });
        }
        let breaks = breaks(&pieces)?;
        check_gaps(&pieces, extent, gap)?;
        let mut built = Self { pieces, breaks, corners: Vec::new(), places: Vec::new(), extent };
        built.find_corners()?;
        Ok(built)
    }

    /// The pieces, in order.
    pub fn pieces(&self) -> &[Arc<dyn Curve>] {
        &self.pieces
    }

    /// The parameter at which each piece begins, and 1.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    fn find_corners(&mut self) -> Result<(), ShapeError> {
        for (piece, curve) in self.pieces.iter().enumerate() {
            let (from, to) = (self.breaks[piece], self.breaks[piece + 1]);
            let failed = |message| piece_error(piece, CurveError::PanickedAbout { what: "tangent", message });
            let is_corner = match (piece, self.extent) {
                (0, Extent::Open) => false,
                _ => catch(|| self.turns_before(piece)).map_err(failed)?,
            };
            if is_corner {
                self.corners.push(from);
                self.places.push(Place { piece, u: 0.0 });
            }
            for &u in curve.corners().iter().filter(|&&u| u > 0.0 && u < 1.0) {
                // Rounding must not push a corner onto the join, which is a place of its own.
                let corner = from + u * (to - from);
                if corner > from && corner < to {
                    self.corners.push(corner);
                    self.places.push(Place { piece, u });
                }
            }
        }
        Ok(())
    }

    /// Is the join at which `piece` begins a corner?
    fn turns_before(&self, piece: usize) -> bool {
        let before = tangent(&*self.pieces[self.before(piece)], 1.0, Branch::Before);
        let after = tangent(&*self.pieces[piece], 0.0, Branch::After);
        before.zip(after).is_none_or(|(a, b)| angle::between(a, b) >= CORNER_TURN)
    }

    fn before(&self, piece: usize) -> usize {
        piece.checked_sub(1).unwrap_or(self.pieces.len() - 1)
    }

    /// Where `u` in [0, 1] lies; at a join, on the piece of the given side.
    fn place(&self, u: f64, branch: Branch) -> Place {
        let corner = self.corners.binary_search_by(|c| c.total_cmp(&u)).map(|i| self.places[i]);
        match (corner, branch) {
            (Ok(place), Branch::After) => return place,
            (Ok(place), Branch::Before) if place.u > 0.0 => return place,
            _ => {}
        }
        let begun = self.breaks.partition_point(|&b| if branch == Branch::After { b <= u } else { b < u });
        let piece = begun.clamp(1, self.pieces.len()) - 1;
        let (from, to) = (self.breaks[piece], self.breaks[piece + 1]);
        Place { piece, u: (u - from) / (to - from) }
    }

    /// The derivative of a piece, by the parameter of the whole.
    fn scaled(&self, piece: usize, derivative: DVec3) -> DVec3 {
        derivative / (self.breaks[piece + 1] - self.breaks[piece])
    }
}

fn piece_error(piece: usize, source: CurveError) -> ShapeError {
    ShapeError::Piece { piece, source }
}

/// Where each piece begins: the share of the length before it.
fn breaks(pieces: &[Arc<dyn Curve>]) -> Result<Vec<f64>, ShapeError> {
    let mut run = vec![0.0];
    let mut total = 0.0;
    for (piece, curve) in pieces.iter().enumerate() {
        let own = length(&**curve).map_err(|source| piece_error(piece, source))?;
        if !(own > 0.0 && own.is_finite()) {
            return Err(ShapeError::PieceLength { piece, length: own });
        }
        total += own;
        run.push(total);
    }
    run.iter_mut().for_each(|u| *u /= total);
    // A piece whose share does not move the parameter has no length among the others.
    match run.windows(2).position(|pair| pair[0] >= pair[1] || pair[1].is_nan()) {
        Some(piece) => Err(ShapeError::PieceLength { piece, length: (run[piece + 1] - run[piece]) * total }),
        None => Ok(run),
    }
}

fn check_gaps(pieces: &[Arc<dyn Curve>], extent: Extent, limit: f64) -> Result<(), ShapeError> {
    let joins = if extent == Extent::Closed { pieces.len() } else { pieces.len() - 1 };
    for piece in 0..joins {
        let next = (piece + 1) % pieces.len();
        let at = call(1.0, || pieces[piece].position(1.0)).map_err(|source| piece_error(piece, source))?;
        let on = call(0.0, || pieces[next].position(0.0)).map_err(|source| piece_error(next, source))?;
        let gap = at.distance(on);
        if gap.is_nan() || gap > limit {
            return Err(ShapeError::Gap { piece, gap, limit, at });
        }
    }
    Ok(())
}

impl Curve for Concatenation {
    fn position(&self, u: f64) -> DVec3 {
        let place = self.place(canonical(u, self.extent), Branch::After);
        self.pieces[place.piece].position(place.u)
    }

    fn derivative(&self, u: f64) -> DVec3 {
        let Place { piece, u } = self.place(canonical(u, Extent::Open), Branch::After);
        self.scaled(piece, self.pieces[piece].derivative(u))
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        match (u <= 0.0, self.closed()) {
            (true, true) => self.derivative(1.0),
            (true, false) => self.derivative(0.0),
            (false, _) => {
                let Place { piece, u } = self.place(canonical(u, Extent::Open), Branch::Before);
                self.scaled(piece, self.pieces[piece].derivative_before(u))
            }
        }
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.extent == Extent::Closed
    }

    fn revision(&self) -> u64 {
        self.pieces.iter().fold(0, |sum, piece| sum.wrapping_add(piece.revision()))
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::{bits, config, point};
    use crate::curve::{Circle, CircularArc, FnCurve, Polyline, Segment, turn};

    fn segments(points: &[DVec3]) -> Vec<Arc<dyn Curve>> {
        points.windows(2).map(|p| Arc::new(Segment { start: p[0], end: p[1] }) as Arc<dyn Curve>).collect()
    }

    /// Two half circles of radius `r` and two segments between them: a racetrack.
    fn racetrack(r: f64) -> Concatenation {
        let arc = |x: f64, from: f64| {
            let arc = CircularArc::from_axes(DVec3::X * x, DVec3::X, DVec3::Y, r, from, PI);
            Arc::new(arc.expect("an arc")) as Arc<dyn Curve>
        };
        let line = |x: f64, y: f64| {
            Arc::new(Segment { start: DVec3::new(x, y, 0.0), end: DVec3::new(-x, y, 0.0) }) as Arc<dyn Curve>
        };
        let pieces = vec![arc(1.0, -FRAC_PI_2), line(1.0, r), arc(-1.0, FRAC_PI_2), line(-1.0, -r)];
        Concatenation::new(pieces, Extent::Closed, 1e-14).expect("the pieces meet")
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn segments_end_to_end_are_a_polyline(points in prop::collection::vec(point(), 3..20), u in 0.0..=1.0) {
            let line = Polyline::open(points.clone()).expect("distinct");
            let joined = Concatenation::new(segments(&points), Extent::Open, 0.0).expect("they meet");
            prop_assert!(joined.position(u).distance(line.position(u)) < 1e-12);
            for (&b, p) in joined.breaks().iter().zip(&points) {
                prop_assert_eq!(bits(joined.position(b)), bits(*p));
            }
            for &c in joined.corners() {
                let i = joined.breaks().iter().position(|&b| b == c).expect("corners are at joins");
                let directions = [points[i] - points[i - 1], points[i + 1] - points[i]].map(DVec3::normalize);
                prop_assert!(joined.derivative_before(c).normalize().distance(directions[0]) < 1e-14);
                prop_assert!(joined.derivative(c).normalize().distance(directions[1]) < 1e-14);
            }
        }

        #[test]
        fn corners_of_pieces_are_met_to_the_bit(points in prop::collection::vec(point(), 6..20), split in 2_usize..4) {
            let lines = [points[..=split].to_vec(), points[split..].to_vec()].map(|p| Polyline::open(p).expect("distinct"));
            let pieces = lines.iter().map(|l| Arc::new(l.clone()) as Arc<dyn Curve>).collect();
            let joined = Concatenation::new(pieces, Extent::Open, 0.0).expect("they meet");
            prop_assert!(joined.corners().is_sorted());
            let inner: Vec<_> = joined.corners().iter().map(|&c| bits(joined.position(c))).collect();
            let wanted: Vec<_> = points[1..points.len() - 1].iter().map(|p| bits(*p)).collect();
            prop_assert_eq!(inner, wanted);
        }
    }

    #[test]
    fn pieces_of_constant_speed_join_to_constant_speed() {
        let track = racetrack(0.7);
        let speed = 4.0 + 2.0 * PI * 0.7;
        for k in 0..=1000 {
            let u = f64::from(k) / 1000.0;
            assert!((track.derivative(u).length() - speed).abs() < 1e-13 * speed, "{u}");
        }
    }

    #[test]
    fn smooth_joins_are_no_corners() {
        let track = racetrack(0.3);
        assert!(track.closed() && track.corners().is_empty());
        assert!(track.breaks().iter().all(|&b| turn(&track, b).is_some_and(|by| by < 1e-14)));
        assert!(track.position(0.0).distance(track.position(1.0 - 1e-15)) < 1e-14);
    }

    #[test]
    fn a_join_turns_into_a_corner_at_the_stated_angle() {
        for (angle, corners) in [(0.9 * CORNER_TURN, 0), (1.1 * CORNER_TURN, 1), (PI, 1)] {
            let end = DVec3::X + DVec3::new(f64::cos(angle), f64::sin(angle), 0.0);
            let joined = Concatenation::new(segments(&[DVec3::ZERO, DVec3::X, end]), Extent::Open, 0.0);
            assert_eq!(joined.expect("they meet").corners().len(), corners, "{angle}");
        }
    }

    #[test]
    fn a_single_closed_piece_is_itself() {
        let circle = Circle::new(DVec3::ZERO, DVec3::Z, 2.0).expect("a circle");
        let joined = Concatenation::new(vec![Arc::new(circle)], Extent::Closed, 0.0).expect("it closes");
        assert!(joined.corners().is_empty());
        for k in 0..=64 {
            let u = f64::from(k) / 64.0;
            assert_eq!(bits(joined.position(u)), bits(circle.position(u)));
        }
    }

    #[test]
    fn revisions_of_pieces_add_up() {
        let piece = Arc::new(FnCurve::new(|u| DVec3::X * u));
        let pieces: Vec<Arc<dyn Curve>> = vec![piece.clone(), Arc::new(Segment { start: DVec3::X, end: DVec3::Y })];
        let joined = Concatenation::new(pieces, Extent::Open, 0.0).expect("they meet");
        assert_eq!(joined.revision(), 0);
        piece.set_revision(5);
        assert_eq!(joined.revision(), 5);
    }

    #[test]
    fn what_does_not_join_is_refused_and_placed() {
        let joined = |pieces, extent| Concatenation::new(pieces, extent, 1e-3).map(|_| ());
        assert!(matches!(joined(vec![], Extent::Open), Err(ShapeError::TooFew { .. })));
        let mut apart = segments(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(joined(apart.clone(), Extent::Open), Ok(()));
        let open = Err(ShapeError::Gap { piece: 1, gap: 1.0, limit: 1e-3, at: DVec3::Y });
        assert_eq!(joined(apart.clone(), Extent::Closed), open);
        apart.swap(0, 1);
        assert!(matches!(joined(apart, Extent::Open), Err(ShapeError::Gap { piece: 0, .. })));
        let still = segments(&[DVec3::ZERO, DVec3::X, DVec3::X]);
        assert!(matches!(joined(still, Extent::Open), Err(ShapeError::PieceLength { piece: 1, .. })));
        let panics: Arc<dyn Curve> = Arc::new(FnCurve::new(|_| panic!("no")));
        assert!(matches!(joined(vec![panics], Extent::Open), Err(ShapeError::Piece { piece: 0, .. })));
        let nan: Arc<dyn Curve> = Arc::new(FnCurve::new(|_| DVec3::NAN));
        assert!(matches!(joined(vec![nan], Extent::Open), Err(ShapeError::Piece { piece: 0, .. })));
    }
}
