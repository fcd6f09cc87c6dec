//! What can go wrong when a curve is made, when it is evaluated, and when it is given parameters.

use glam::DVec3;
use thiserror::Error;

/// A curve could not be evaluated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// The point or derivative is NaN or infinite.
    #[error("the curve is not finite at u = {u}: {at}")]
    NotFinite {
        /// The parameter.
        u: f64,
        /// What the curve gave.
        at: DVec3,
    },
    /// The curve's own code panicked.
    #[error("the curve panicked at u = {u}: {message}")]
    Panicked {
        /// The parameter.
        u: f64,
        /// What the panic said.
        message: String,
    },
    /// The curve's own code panicked when it was asked about itself.
    #[error("the curve panicked when asked for its {what}: {message}")]
    PanickedAbout {
        /// What it was asked for: corners, closedness, revision or tangent.
        what: &'static str,
        /// What the panic said.
        message: String,
    },
    /// The curve has been evaluated as often as it may.
    #[error("the curve was asked for u = {u} after its budget of {limit} evaluations was spent")]
    BudgetSpent {
        /// The first parameter that was refused; on several threads, one of the first.
        u: f64,
        /// How many evaluations the budget allows.
        limit: u64,
    },
    /// The tangent turns in too many places for a piecewise smooth curve.
    #[error(
        "the curve is not piecewise smooth near u = {u}: after {windows} windows its tangent still turns by more than {turn} rad in each"
    )]
    Rough {
        /// Where the search stopped.
        u: f64,
        /// How many windows were looked at.
        windows: u32,
        /// The angle that makes a corner, in radians.
        turn: f64,
    },
}

/// The data given do not make a curve.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// There are not enough points, pieces or knots.
    #[error("{count} {what} are too few: it takes {needed}")]
    TooFew {
        /// What there are too few of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many it takes at least.
        needed: usize,
    },
    /// The number of knots or weights does not fit the number of points.
    #[error("{count} {what} do not fit: it takes {needed}")]
    WrongCount {
        /// What is miscounted.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many it takes.
        needed: usize,
    },
    /// The degree is 0 or more than [`MAX_DEGREE`](super::MAX_DEGREE).
    #[error("degree {degree} is outside 1..={limit}")]
    Degree {
        /// The degree asked for.
        degree: usize,
        /// The greatest degree.
        limit: usize,
    },
    /// A point is NaN or infinite, or so far out that the curve's length is.
    #[error("point {index} is not finite, or too far out: {at}")]
    PointNotFinite {
        /// The point.
        index: usize,
        /// Where it is.
        at: DVec3,
    },
    /// A number is outside what it may be.
    #[error("{what} is {value}, outside {from} to {to}")]
    OutOfRange {
        /// What the number stands for.
        what: &'static str,
        /// The number.
        value: f64,
        /// The least it may be; 0 itself is excluded where it would make nothing.
        from: f64,
        /// The most it may be.
        to: f64,
    },
    /// A weight is not positive and finite.
    #[error("weight {index} is {weight}: weights are positive and finite")]
    Weight {
        /// The weight.
        index: usize,
        /// Its value.
        weight: f64,
    },
    /// A vector gives no direction: it vanishes, is not finite, or is parallel to another.
    #[error("{what} gives no direction: {vector}")]
    NoDirection {
        /// What the vector stands for.
        what: &'static str,
        /// The vector.
        vector: DVec3,
    },
    /// A knot is smaller than the one before, or not finite.
    #[error("knot {index} is {knot}, after {before}: knots are finite and do not descend")]
    KnotOrder {
        /// The knot.
        index: usize,
        /// Its value.
        knot: f64,
        /// The value before it.
        before: f64,
    },
    /// A knot inside the domain is repeated so often that the curve falls apart there.
    #[error("knot {index} at u = {u} is {multiplicity}-fold: inside, more than {degree} tear the curve apart")]
    KnotMultiplicity {
        /// The first of the equal knots.
        index: usize,
        /// The parameter in [0, 1].
        u: f64,
        /// How many knots are equal there.
        multiplicity: usize,
        /// The most there may be: the degree.
        degree: usize,
    },
    /// A segment of a polyline is too short to be told apart from a point.
    #[error("segment {index} of length {length} vanishes in a total of {total}")]
    ShortSegment {
        /// The segment; it starts at the point of the same index.
        index: usize,
        /// Its length, in model units.
        length: f64,
        /// The length of the whole, in model units.
        total: f64,
    },
    /// A piece of a concatenation has no length, or none that is finite.
    #[error("piece {piece} has length {length}: it must be finite and not vanish")]
    PieceLength {
        /// The piece.
        piece: usize,
        /// Its length, in model units.
        length: f64,
    },
    /// Two pieces do not meet.
    #[error("piece {piece} ends {gap} before the next begins, at {at}: more than {limit}")]
    Gap {
        /// The piece that ends there; the next is the first again after the last.
        piece: usize,
        /// The distance, in model units.
        gap: f64,
        /// The greatest distance, in model units.
        limit: f64,
        /// Where the piece ends.
        at: DVec3,
    },
    /// A piece could not be evaluated.
    #[error("piece {piece} cannot be evaluated")]
    Piece {
        /// The piece.
        piece: usize,
        /// Why.
        source: CurveError,
    },
}

/// A list of parameters is not one to trim along.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// There are too few parameters.
    #[error("{count} parameters are too few: it takes {needed}")]
    TooFew {
        /// How many there are.
        count: usize,
        /// How many it takes: 2, or 3 for a closed list.
        needed: usize,
    },
    /// A parameter lies outside [0, 1], or at 1 in a closed list.
    #[error("parameter {index} is {u}, which is not on the curve")]
    OutOfRange {
        /// Its index.
        index: usize,
        /// Its value.
        u: f64,
    },
    /// A parameter does not follow the one before in the direction of the curve; on a closed curve
    /// the list goes round once at most.
    #[error("parameter {index} is {u}, not after {before}")]
    NotAscending {
        /// Its index.
        index: usize,
        /// Its value.
        u: f64,
        /// The value before.
        before: f64,
    },
    /// A closed list is given along an open curve.
    #[error("the list is closed but the curve is open")]
    OpenCurve,
    /// A corner is named that the list does not have.
    #[error("corner {index} is named, but there are {count} parameters")]
    CornerIndex {
        /// The index named.
        index: usize,
        /// How many parameters there are.
        count: usize,
    },
    /// The list passes over a corner of the curve.
    #[error("the curve has a corner at u = {u}, which is not among the parameters")]
    MissedCorner {
        /// The corner's parameter.
        u: f64,
    },
}

/// The first of `points` that is not finite.
pub(super) fn finite(points: &[DVec3]) -> Result<(), ShapeError> {
    match points.iter().position(|p| !p.is_finite()) {
        Some(index) => Err(ShapeError::PointNotFinite { index, at: points[index] }),
        None => Ok(()),
    }
}
