//! # Contours: borders made of stretches of curves
//!
//! Curves that cross each other make borders together, which run round or from border to border of the
//! source ([`arrange`](super::arrange)). Everything after works contour by contour: each is one curve
//! of one parameter, with a corner at each junction.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{Curve, Heading, wrap};

use super::super::relax::curve_parameter;
use super::Cut;

/// A stretch of one curve between two junctions, or all of it.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The curve, by index.
    pub cut: u32,
    /// The travel parameters of its ends, ascending; unwrapped.
    pub t: [f64; 2],
    /// The curve's own parameters there, to the bit.
    pub u: [f64; 2],
    /// The junctions it runs between; where it is all of a closed curve, none.
    pub junctions: [Option<u32>; 2],
}

/// A border made of stretches of curves.
#[derive(Clone, Debug)]
pub struct Contour {
    /// The stretches, in order; the end of each is the beginning of the next.
    pub spans: Vec<Span>,
    /// All of it as one curve: a single stretch is its curve itself.
    pub curve: Arc<dyn Curve>,
    /// Which way that is walked.
    pub heading: Heading,
}

/// A place of a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The stretch, by index.
    pub span: u32,
    /// The parameter of its curve.
    pub u: f64,
    /// The junction there, where the stretch begins.
    pub junction: Option<u32>,
}

impl Contour {
    /// A contour that is one curve, or a part of one between two borders.
    pub(super) fn single(cut: &Cut, span: Span) -> Self {
        Self { spans: vec![span], curve: Arc::clone(&cut.curve), heading: cut.heading }
    }

    /// Is it made of one curve alone?
    pub fn is_single(&self) -> bool {
        self.spans.len() == 1
    }

    /// The place at travel parameter `t`.
    pub fn spot(&self, cuts: &[Cut], t: f64) -> Spot {
        if self.is_single() {
            return Spot { span: 0, u: curve_parameter(&*self.curve, self.heading, t), junction: None };
        }
        let t = if self.curve.closed() { wrap(t) } else { t.clamp(0.0, 1.0) };
        let (span, share) = part_of(self.spans.len(), t);
        self.spot_on(cuts, span, share)
    }

    /// The place at travel parameter `t`, where the contour has a corner, to the bit.
    pub fn corner(&self, cuts: &[Cut], t: f64) -> Spot {
        let near = self.spot(cuts, t);
        let apart = |v: f64| (near.u - v - (near.u - v).round()).abs();
        if !self.is_single() {
            // A few sums and products of numbers of the size of one lie between.
            let x = t * self.spans.len() as f64;
            if (x - x.round()).abs() < 1e-9 {
                let span = (x.round() as i64).rem_euclid(self.spans.len() as i64);
                return self.spot_on(cuts, span as usize, 0.0);
            }
        }
        let corners = cuts[self.spans[near.span as usize].cut as usize].curve.corners().iter().copied();
        let nearest = corners.min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
        Spot { u: nearest.unwrap_or(near.u), ..near }
    }

    /// Where it begins (0) or ends (1) on a border.
    pub fn end(&self, which: usize) -> Spot {
        let span = if which == 0 { 0 } else { self.spans.len() - 1 };
        let own = &self.spans[span];
        Spot { span: span as u32, u: own.u[which], junction: own.junctions[which] }
    }

    /// How far on its travel parameter comes in `way` of the travel along a stretch's curve.
    pub(super) fn travel(&self, span: &Span, way: f64) -> f64 {
        if self.is_single() { way } else { way / ((span.t[1] - span.t[0]) * self.spans.len() as f64) }
    }

    fn spot_on(&self, cuts: &[Cut], span: usize, share: f64) -> Spot {
        let own = &self.spans[span];
        let cut = &cuts[own.cut as usize];
        let u = own.parameter(cut, share);
        let junction = own.junctions[0].filter(|_| share == 0.0);
        Spot { span: span as u32, u, junction }
    }
}

impl Span {
    /// The curve's parameter at a share of the way: both ends to the bit.
    fn parameter(&self, cut: &Cut, share: f64) -> f64 {
        match share {
            0.0 => self.u[0],
            1.0 => self.u[1],
            _ => curve_parameter(&*cut.curve, cut.heading, self.t[0] + (self.t[1] - self.t[0]) * share),
        }
    }

    pub(super) fn share(&self, t: f64) -> f64 {
        (t - self.t[0]) / (self.t[1] - self.t[0])
    }
}

/// Of `n` parts of [0, 1], the one that holds `t`, and the share of it.
fn part_of(n: usize, t: f64) -> (usize, f64) {
    let x = t * n as f64;
    let part = (x.floor().max(0.0) as usize).min(n - 1);
    (part, (x - part as f64).clamp(0.0, 1.0))
}

/// Several stretches as one curve, each with the same share of the parameter.
#[derive(Debug)]
pub(super) struct Joined {
    pub pieces: Vec<Piece>,
    pub closed: bool,
}

#[derive(Debug)]
pub(super) struct Piece {
    pub cut: Cut,
    pub span: Span,
    /// The junction that it begins with.
    pub start: Option<DVec3>,
}

impl Curve for Joined {
    fn position(&self, u: f64) -> DVec3 {
        let (part, share) = part_of(self.pieces.len(), if self.closed { wrap(u) } else { u });
        let piece = &self.pieces[part];
        let on_curve = || piece.cut.curve.position(piece.span.parameter(&piece.cut, share));
        piece.start.filter(|_| share == 0.0).unwrap_or_else(on_curve)
    }

    fn derivative(&self, u: f64) -> DVec3 {
        let n = self.pieces.len();
        let (part, share) = part_of(n, if self.closed { wrap(u) } else { u });
        let piece = &self.pieces[part];
        let sign = if piece.cut.heading == Heading::Along { 1.0 } else { -1.0 };
        let rate = sign * n as f64 * (piece.span.t[1] - piece.span.t[0]);
        piece.cut.curve.derivative(piece.span.parameter(&piece.cut, share)) * rate
    }

    fn closed(&self) -> bool {
        self.closed
    }
}
