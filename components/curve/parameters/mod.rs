//! The parameters along a curve, which the curve's chain owns and every surface along it shares.

mod spline;
mod traversal;

use std::sync::Arc;

use glam::DVec3;

use self::spline::Span;
pub use self::traversal::{Heading, Traversal};
use super::{Branch, Curve, Extent, ParameterError, wrap};

/// A hierarchy of parameters along a curve: level 0 is a list, level `j` has each of its edges cut
/// into `2^j`. What surfaces along the curve take as samples, they take from here.
///
/// **Meaning.** The list `u_i` holds the coefficients of a uniform cubic B-spline `u(t)`, with `t`
/// counting edges of level 0. Refinement makes of them the coefficients of the same spline at half
/// the distance: `((u_{i-1} + u_{i+1}) + 6 u_i) / 8` at vertices, `(u_i + u_{i+1}) / 2` on edges.
/// The limit of a vertex, `((u_{i-1} + u_{i+1}) + 4 u_i) / 6`, is the spline itself at `t = i / 2^j`, and
/// the border of a surface runs through the curve's points there: however unevenly the `u_i` are
/// spaced, the border moves on smoothly. At the ends of an open list and at corners, `u` is fixed
/// and the spline runs in straight. [Litke, Levin, Schroeder 2001, Section 2.1]
///
/// **Same bits.** Nothing is refined step by step: a vertex is read at its `t`, reduced to the level at
/// which it was born, straight from level 0. So its sample is the same bits at every finer level,
/// costs the same at each, and is the same from whichever surface asks. The list has the curve's
/// direction; closed, it begins at its smallest parameter, whichever the caller began with
/// ([`CurveParameters::rotation`]). Surfaces that walk otherwise map their indices by [`Traversal`].
///
/// Indices past the end of an open list are read as its last; closed lists are counted round.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use selvedge_components::curve::{Circle, Curve, CurveParameters, Extent};
///
/// let circle = Arc::new(Circle::new(DVec3::ZERO, DVec3::Z, 1.0)?);
/// let border = CurveParameters::new(circle.clone(), Extent::Closed, vec![0.5, 0.7, 0.9, 0.1, 0.3], &[])?;
/// assert_eq!(border.coefficient(0, 0), 0.1);
/// assert_eq!(border.rotation(), 2);
/// // Vertex 1 of level 0 is vertex 2 of level 1, 1024 of level 10: one sample.
/// assert_eq!(border.sample(0, 1), border.sample(10, 1024));
/// assert_eq!(border.sample(10, 7), circle.position(border.parameter(10, 7)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CurveParameters {
    curve: Arc<dyn Curve>,
    extent: Extent,
    /// Is the curve closed, so that parameters are counted round?
    wraps: bool,
    /// In the direction of the curve, each as it was given.
    base: Vec<f64>,
    /// Of an open list across the place where a closed curve begins, the first index after it.
    next_turn: usize,
    corner: Vec<bool>,
    rotation: usize,
}

impl CurveParameters {
    /// The hierarchy over `parameters` of `curve`, which ascend in its direction: all of a closed
    /// curve from wherever, or a part of a curve from end to end, which may pass the place where a
    /// closed curve begins. `corners` are indices of parameters to be kept where they are; those
    /// at corners of the curve are so without being named.
    ///
    /// # Errors
    /// Every variant of [`ParameterError`].
    pub fn new(
        curve: Arc<dyn Curve>,
        extent: Extent,
        parameters: Vec<f64>,
        corners: &[usize],
    ) -> Result<Self, ParameterError> {
        let count = parameters.len();
        let needed = if extent == Extent::Closed { 3 } else { 2 };
        if count < needed {
            return Err(ParameterError::TooFew { count, needed });
        }
        if extent == Extent::Closed && !curve.closed() {
            return Err(ParameterError::OpenCurve);
        }
        let mut corner = vec![false; count];
        for &index in corners {
            *corner.get_mut(index).ok_or(ParameterError::CornerIndex { index, count })? = true;
        }
        let wraps = curve.closed();
        let next_turn = next_turn(&parameters, extent, wraps)?;
        let mut built = Self { curve, extent, wraps, base: parameters, next_turn, corner, rotation: 0 };
        if extent == Extent::Closed {
            built.begin_at_smallest();
        }
        built.mark_corners()?;
        Ok(built)
    }

    /// About `edges` edges evenly over all of `curve`: each smooth piece between corners gets its
    /// share of them, at least one, and a closed curve at least three in all.
    ///
    /// # Errors
    /// [`ParameterError`] if the curve's own corners are not sound.
    pub fn even(curve: Arc<dyn Curve>, edges: u32) -> Result<Self, ParameterError> {
        let extent = Extent::of(&*curve);
        let mut ends: Vec<f64> = curve.corners().to_vec();
        if let Some(index) = ends.iter().position(|u| !(0.0..1.0).contains(u)) {
            return Err(ParameterError::OutOfRange { index, u: ends[index] });
        }
        match extent {
            Extent::Open => {
                ends.insert(0, 0.0);
                ends.push(1.0);
            }
            Extent::Closed => {
                let first = ends.first().copied().unwrap_or(0.0);
                if ends.is_empty() {
                    ends.push(first);
                }
                ends.push(first + 1.0);
            }
        }
        let least = if extent == Extent::Closed { 3 } else { 1 };
        let pieces = ends.len() as u32 - 1;
        let wanted = edges.max(least);
        let mut parameters = Vec::new();
        for pair in ends.windows(2) {
            let share = ((pair[1] - pair[0]) * f64::from(wanted)).round() as u32;
            let share = share.max(least.div_ceil(pieces)).max(1);
            let inside = (0..share).map(|k| pair[0] + (pair[1] - pair[0]) * (f64::from(k) / f64::from(share)));
            parameters.extend(inside.map(|u| if extent == Extent::Closed { wrap(u) } else { u }));
        }
        if extent == Extent::Open {
            parameters.push(1.0);
        }
        Self::new(curve, extent, parameters, &[])
    }

    /// The same hierarchy over `curve`, which is the same curve in all but how it is evaluated.
    #[must_use]
    pub fn over(&self, curve: Arc<dyn Curve>) -> Self {
        Self { curve, ..self.clone() }
    }

    /// The curve that is sampled.
    pub fn curve(&self) -> &Arc<dyn Curve> {
        &self.curve
    }

    /// Whether the list goes all round a closed curve.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// The list of level 0, to the bit as it was given: ascending, but for a fall where an open list
    /// passes the place where a closed curve begins.
    pub fn base(&self) -> &[f64] {
        &self.base
    }

    /// The index, in [`CurveParameters::base`], of the first parameter that the caller gave.
    pub fn rotation(&self) -> usize {
        self.rotation
    }

    /// How many edges there are at `level`.
    pub fn edge_count(&self, level: u32) -> u64 {
        let base = match self.extent {
            Extent::Open => self.base.len() - 1,
            Extent::Closed => self.base.len(),
        };
        (base as u64).saturating_mul(1_u64.checked_shl(level).unwrap_or(u64::MAX))
    }

    /// How many vertices there are at `level`.
    pub fn vertex_count(&self, level: u32) -> u64 {
        match self.extent {
            Extent::Open => self.edge_count(level).saturating_add(1),
            Extent::Closed => self.edge_count(level),
        }
    }

    /// Is this vertex kept where it is: a corner, or an end of an open list?
    pub fn is_fixed(&self, level: u32, vertex: u64) -> bool {
        self.vertex_at(self.place(level, vertex)).is_some_and(|i| self.is_fixed_at(i))
    }

    /// The coefficient `u_i` of `vertex` at `level`, as the refinement rules make it of level 0: to
    /// the bit at level 0, to rounding beyond. It may lie outside [0, 1] by a part of the first or
    /// last edge of a closed list.
    pub fn coefficient(&self, level: u32, vertex: u64) -> f64 {
        let Place { edge, share } = self.place(level, vertex);
        self.span(edge).value(share, power(level))
    }

    /// The parameter at which the curve is sampled for `vertex` at `level`: the limit of its
    /// coefficient. In [0, 1); 1 itself only at the end of an open curve.
    pub fn parameter(&self, level: u32, vertex: u64) -> f64 {
        let place = self.place(level, vertex);
        self.read(&self.span(place.edge), place)
    }

    /// The sample for `vertex` at `level`: the curve at [`CurveParameters::parameter`].
    pub fn sample(&self, level: u32, vertex: u64) -> DVec3 {
        self.curve.position(self.parameter(level, vertex))
    }

    /// All parameters of a level, in the order of the curve.
    pub fn parameters(&self, level: u32) -> impl Iterator<Item = f64> + '_ {
        let cuts = 1_u64.checked_shl(level).unwrap_or(u64::MAX);
        let edges = (0..self.edge_count(0) as usize).flat_map(move |edge| {
            // One span for all its vertices: the bits are those of each asked for alone.
            let span = self.span(edge);
            (0..cuts).map(move |k| self.read(&span, Place { edge, share: k as f64 * power(level) }))
        });
        let end = (self.extent == Extent::Open).then(|| self.parameter(0, self.edge_count(0)));
        edges.chain(end)
    }

    /// All samples of a level, in the order of the curve.
    pub fn samples(&self, level: u32) -> impl Iterator<Item = DVec3> + '_ {
        self.parameters(level).map(|u| self.curve.position(u))
    }

    /// The parameter at the share `s` in [0, 1] of an edge of level 0: the spline `u(t)` itself.
    pub fn parameter_on(&self, edge: u64, s: f64) -> f64 {
        let place = self.place_on(edge, s);
        self.read(&self.span(place.edge), place)
    }

    /// The place at the share `s` of an edge; the end of an edge is the beginning of the next, so
    /// that a vertex has the same bits from both.
    fn place_on(&self, edge: u64, s: f64) -> Place {
        let (edge, count) = (self.wrapped(edge), self.edge_count(0) as usize);
        match self.extent {
            _ if s < 1.0 || s.is_nan() => Place { edge, share: s.clamp(0.0, 1.0) },
            Extent::Open if edge + 1 == count => Place { edge, share: 1.0 },
            _ => Place { edge: (edge + 1) % count, share: 0.0 },
        }
    }

    /// The point of the border at the share `s` in [0, 1] of an edge of level 0.
    pub fn point_on(&self, edge: u64, s: f64) -> DVec3 {
        self.curve.position(self.parameter_on(edge, s))
    }

    /// The derivative of [`CurveParameters::point_on`] by `s`, in model units per edge of level 0;
    /// at both ends of the edge from inside the edge.
    pub fn velocity_on(&self, edge: u64, s: f64) -> DVec3 {
        let (u, s) = (self.parameter_on(edge, s), s.clamp(0.0, 1.0));
        let derivative = if s < 1.0 { self.curve.derivative(u) } else { self.curve.derivative_before(u) };
        derivative * self.span(self.wrapped(edge)).rate(s)
    }

    /// The derivative of the border at `vertex` of `level`, on one branch; at the ends of an open
    /// list on the branch there is. In model units per edge of level 0, whatever the level.
    pub fn velocity(&self, level: u32, vertex: u64, branch: Branch) -> DVec3 {
        let Place { edge, share } = self.place(level, vertex);
        let edge = edge as u64;
        match (branch, self.extent) {
            (Branch::Before, Extent::Closed) if share == 0.0 => self.velocity_on(edge + self.edge_count(0) - 1, 1.0),
            (Branch::Before, Extent::Open) if share == 0.0 && edge > 0 => self.velocity_on(edge - 1, 1.0),
            _ => self.velocity_on(edge, share),
        }
    }

    /// Turns a closed list so that it begins at its smallest parameter.
    fn begin_at_smallest(&mut self) {
        let count = self.base.len();
        let first = self.next_turn % count;
        self.base.rotate_left(first);
        self.corner.rotate_left(first);
        self.rotation = (count - first) % count;
        self.next_turn = count;
    }

    /// Marks the corners of the curve; none may lie between the parameters.
    fn mark_corners(&mut self) -> Result<(), ParameterError> {
        let (first, last) = (self.base[0], self.lift(self.base.len() as isize - 1));
        for &u in self.curve.corners() {
            let is_passed = match self.extent {
                Extent::Closed => true,
                Extent::Open => [u, u + 1.0].iter().any(|&lift| first < lift && lift < last),
            };
            match self.base.iter().position(|&v| v == u) {
                Some(index) => self.corner[index] = true,
                None if is_passed => return Err(ParameterError::MissedCorner { u }),
                None => {}
            }
        }
        Ok(())
    }

    /// The parameter at a place on the edge of `span`.
    fn read(&self, span: &Span, place: Place) -> f64 {
        let u = match self.vertex_at(place) {
            // Kept as given: a turn added and taken away would cost the last digits.
            Some(i) if self.is_fixed_at(i) => self.base[i],
            _ => span.value(place.share, 0.0),
        };
        if self.wraps { wrap(u) } else { u }
    }

    /// The span of an edge of level 0: its coefficients, and beyond a fixed vertex the reflection.
    fn span(&self, edge: usize) -> Span {
        // In the turn of the edge itself: what lies beyond a place where the curve begins has the bits
        // that it has in a list that does not pass it.
        let lift = |i: isize| self.lift_from(edge, edge as isize + i);
        let (b, c) = (lift(0), lift(1));
        let gap = c - b;
        let before = if self.is_fixed_at(edge) { gap } else { b - lift(-1) };
        let after = if self.is_fixed_at(edge + 1) { gap } else { lift(2) - c };
        Span { b, c, before, gap, after }
    }

    /// A parameter of level 0, ascending: a whole turn on after the place where a closed curve
    /// begins. Those of a closed list go on beyond both ends.
    fn lift(&self, i: isize) -> f64 {
        let (i, turns) = self.turned(i);
        self.base[i] + turns
    }

    /// The same, counted from the turn in which vertex `from` lies.
    fn lift_from(&self, from: usize, i: isize) -> f64 {
        let (i, turns) = self.turned(i);
        self.base[i] + (turns - self.turned(from as isize).1)
    }

    /// The vertex that `i` stands for, and in which turn.
    fn turned(&self, i: isize) -> (usize, f64) {
        let count = self.base.len() as isize;
        // One turn at most on either side, of which only closed lists have more than one vertex.
        match i {
            _ if i < 0 => ((i + count) as usize, -1.0),
            _ if i >= count => ((i - count) as usize, 1.0),
            _ if i >= self.next_turn as isize => (i as usize, 1.0),
            _ => (i as usize, 0.0),
        }
    }

    /// The vertex of level 0 at a place, if there is one.
    fn vertex_at(&self, place: Place) -> Option<usize> {
        match place.share {
            0.0 => Some(place.edge),
            1.0 if place.edge + 1 < self.base.len() => Some(place.edge + 1),
            1.0 => Some(0),
            _ => None,
        }
    }

    fn is_fixed_at(&self, i: usize) -> bool {
        let count = self.base.len();
        let is_end = self.extent == Extent::Open && (i == 0 || i == count - 1);
        is_end || self.corner[if i < count { i } else { i - count }]
    }

    /// Where a vertex lies among the edges of level 0. The share is a dyadic number, the same at
    /// every level that has the vertex.
    fn place(&self, level: u32, vertex: u64) -> Place {
        let count = self.vertex_count(level);
        let vertex = match self.extent {
            Extent::Open => vertex.min(count - 1),
            Extent::Closed if vertex < count => vertex,
            Extent::Closed => vertex % count,
        };
        let edge = vertex.checked_shr(level).unwrap_or(0);
        let rest = vertex - edge.checked_shl(level).unwrap_or(0);
        match self.extent {
            // The last vertex is the end of the last edge.
            Extent::Open if edge as usize == self.base.len() - 1 => Place { edge: edge as usize - 1, share: 1.0 },
            _ => Place { edge: edge as usize, share: rest as f64 * power(level) },
        }
    }

    fn wrapped(&self, edge: u64) -> usize {
        let count = self.edge_count(0);
        let edge = if self.extent == Extent::Closed { edge % count } else { edge.min(count - 1) };
        edge as usize
    }
}

/// A place on an edge of level 0.
#[derive(Clone, Copy, Debug)]
struct Place {
    edge: usize,
    share: f64,
}

/// `2^-level`, exactly; the least there is beyond all levels.
fn power(level: u32) -> f64 {
    f64::from_bits(u64::from(1023 - level.min(1022)) << 52)
}

/// Checks one walk along a curve, and finds the first index after the place where a closed curve
/// begins: all of them, if it is not passed.
fn next_turn(parameters: &[f64], extent: Extent, closed: bool) -> Result<usize, ParameterError> {
    let is_on = |u: f64| (0.0..1.0).contains(&u) || (u == 1.0 && extent == Extent::Open);
    if let Some(index) = parameters.iter().position(|&u| !is_on(u)) {
        return Err(ParameterError::OutOfRange { index, u: parameters[index] });
    }
    let mut next_turn = parameters.len();
    for (index, pair) in (1..).zip(parameters.windows(2)) {
        let [before, u] = [pair[0], pair[1]];
        let begins_turn = u <= before && closed && next_turn == parameters.len();
        if begins_turn {
            next_turn = index;
        }
        // A second time round, the list would pass itself; only an open one may end where it began.
        let is_round =
            next_turn < parameters.len() && (u > parameters[0] || (u == parameters[0] && extent == Extent::Closed));
        if is_round || (u <= before && !begins_turn) || (begins_turn && before == 1.0 && u == 0.0) {
            return Err(ParameterError::NotAscending { index, u, before });
        }
    }
    Ok(next_turn)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
