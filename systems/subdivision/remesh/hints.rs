//! Places at which a curve is said to run: where the search for it begins.

use selvedge_components::curve::Curve;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::Connectivity;
use selvedge_components::trim::PreImagePoint;

use super::error::PreImageError;
use super::path;

/// Places of a surface at which a curve is said to run, by rising parameter; none where nothing is
/// said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hints(Vec<PreImagePoint>);

/// Weights outside [0, 1] by no more than rounding of what a host has computed them with, `f32` even.
const SLACK: f64 = 1e-6;

/// Steps along a curve that is followed from hint to hint, in steps of the trace: four of those are
/// half an edge, from which a search around the last place finds the next one on the same sheet.
const STRIDE: f64 = 4.0;

/// Steps at most, whatever the length.
const MOST: f64 = 8192.0;

impl Hints {
    /// The places, if they are some of `mesh`, and in order.
    ///
    /// # Errors
    /// [`PreImageError::BadGiven`].
    pub fn new(mesh: &Connectivity, given: &[PreImagePoint]) -> Result<Self, PreImageError> {
        for (index, point) in given.iter().enumerate() {
            let bad = |reason| Err(PreImageError::BadGiven { index, reason });
            if !(0.0..=1.0).contains(&point.u) {
                return bad("its parameter is outside [0, 1]");
            }
            if index > 0 && point.u <= given[index - 1].u {
                return bad("its parameter is not above that of the point before");
            }
            if point.at.face.index() >= mesh.face_count() {
                return bad("the surface has no such face");
            }
            if !path::weights(point.at.st).iter().all(|w| (-SLACK..=1.0 + SLACK).contains(w)) {
                return bad("it lies outside its face");
            }
        }
        Ok(Self(given.to_vec()))
    }

    /// Is nothing said?
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The parameters at which a place is given.
    pub fn parameters(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|point| point.u)
    }

    /// The place given at `u` itself.
    pub(super) fn at(&self, u: f64) -> Option<SurfacePoint> {
        self.0.iter().find(|point| point.u == u).map(|point| point.at)
    }

    /// The place given nearest to `u`; its parameter on a closed curve counted on or back to be so.
    pub(super) fn near(&self, u: f64, curve: &dyn Curve) -> Option<PreImagePoint> {
        let rounds = |v: f64| if curve.closed() { (u - v).round() } else { 0.0 };
        let counted = self.0.iter().map(|point| PreImagePoint { u: point.u + rounds(point.u), ..*point });
        counted.min_by(|a, b| (a.u - u).abs().total_cmp(&(b.u - u).abs()))
    }

    /// How often a curve is looked at to begin with: `least` times, and so often that the search
    /// follows it where places are given.
    pub(super) fn looks(&self, curve: &dyn Curve, least: u32, step: f64) -> u32 {
        if self.is_empty() {
            return least;
        }
        let points = (0..=least).map(|k| curve.position(f64::from(k) / f64::from(least)));
        let points: Vec<_> = points.collect();
        let length: f64 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
        // A power of two more, so that the even steps are those of every curve.
        let wanted = (length / (STRIDE * step)).clamp(1.0, MOST);
        if wanted.is_nan() { least } else { least.max((wanted as u32).next_power_of_two()) }
    }
}
