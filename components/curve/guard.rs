//! A user's curve, called safely: whatever it does comes back as a typed error.

use core::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::{Curve, CurveError};

/// The position of `curve` at `u`.
///
/// # Errors
/// [`CurveError::NotFinite`], or [`CurveError::Panicked`] (the panic is caught; the host's panic
/// hook still hears of it).
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{CurveError, FnCurve, evaluate};
///
/// let pole = FnCurve::new(|u| DVec3::X / (u - 0.5));
/// assert_eq!(evaluate(&pole, 1.0), Ok(2.0 * DVec3::X));
/// assert!(matches!(evaluate(&pole, 0.5), Err(CurveError::NotFinite { u: 0.5, .. })));
/// ```
pub fn evaluate(curve: &dyn Curve, u: f64) -> Result<DVec3, CurveError> {
    call(u, || curve.position(u))
}

/// What `vector`, a part of some curve at `u`, gives, if it is finite and does not panic.
pub(super) fn call(u: f64, vector: impl FnOnce() -> DVec3) -> Result<DVec3, CurveError> {
    let at = catch(vector).map_err(|message| CurveError::Panicked { u, message })?;
    if at.is_finite() { Ok(at) } else { Err(CurveError::NotFinite { u, at }) }
}

/// What `f` gives, or what its panic says.
///
/// Unwind safety is asserted: a curve is borrowed shared and is not trusted afterwards, and what
/// it shares with its host, the host must guard (a poisoned lock panics again, and is caught again).
pub(super) fn catch<T>(f: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(f)).map_err(|payload| message(&*payload))
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic without a message".into())
}

/// How many evaluations of curves a job may make, counted over all its curves and threads.
///
/// A position counts as one and a derivative as five, which is what a difference takes.
#[derive(Debug)]
pub struct EvaluationBudget {
    limit: u64,
    spent: AtomicU64,
}

impl EvaluationBudget {
    /// A budget of `limit` evaluations, none of them spent.
    pub const fn new(limit: u64) -> Self {
        Self { limit, spent: AtomicU64::new(0) }
    }

    /// How many evaluations there are in all.
    pub const fn limit(&self) -> u64 {
        self.limit
    }

    /// How many have been asked for so far; more than the limit once it has been passed.
    pub fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }

    fn charge(&self, u: f64, evaluations: u64) -> Result<(), CurveError> {
        let before = self.spent.fetch_add(evaluations, Ordering::Relaxed);
        if before.saturating_add(evaluations) > self.limit {
            return Err(CurveError::BudgetSpent { u, limit: self.limit });
        }
        Ok(())
    }
}

/// One revision of a curve under guard, for the length of a job.
///
/// It is used wherever a curve is: where the inner curve fails, it gives NaN, goes on, and keeps
/// the error for [`GuardedCurve::error`]. Of several errors it keeps the one at the smallest
/// parameter, so that threads leave no trace; only which evaluation overdraws a budget depends on
/// them. A curve that never returns cannot be helped.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use selvedge_components::curve::{Curve, CurveError, EvaluationBudget, FnCurve, GuardedCurve};
///
/// let inner = FnCurve::new(|u| if u < 0.7 { DVec3::splat(u) } else { panic!("too far") });
/// let guarded = GuardedCurve::new(Arc::new(inner), Arc::new(EvaluationBudget::new(1000)))?;
/// assert_eq!(guarded.position(0.5), DVec3::splat(0.5));
/// assert!(guarded.position(0.8).is_nan());
/// assert_eq!(guarded.error(), Some(CurveError::Panicked { u: 0.8, message: "too far".into() }));
/// # Ok::<(), CurveError>(())
/// ```
#[derive(Debug)]
pub struct GuardedCurve {
    inner: Arc<dyn Curve>,
    budget: Arc<EvaluationBudget>,
    corners: Vec<f64>,
    closed: bool,
    revision: u64,
    error: Mutex<Option<CurveError>>,
}

/// What a derivative by the default difference costs.
const DERIVATIVE: u64 = 5;

impl GuardedCurve {
    /// Puts `inner` under guard. Its corners, closedness and revision are read once, here.
    ///
    /// # Errors
    /// [`CurveError::PanickedAbout`].
    pub fn new(inner: Arc<dyn Curve>, budget: Arc<EvaluationBudget>) -> Result<Self, CurveError> {
        let about = |what| move |message| CurveError::PanickedAbout { what, message };
        let corners = catch(|| inner.corners().to_vec()).map_err(about("corners"))?;
        let closed = catch(|| inner.closed()).map_err(about("closedness"))?;
        let revision = catch(|| inner.revision()).map_err(about("revision"))?;
        Ok(Self { inner, budget, corners, closed, revision, error: Mutex::new(None) })
    }

    /// The position at `u`, charged to the budget.
    ///
    /// # Errors
    /// As [`evaluate`], or [`CurveError::BudgetSpent`]. They are kept for [`GuardedCurve::error`] too.
    pub fn try_position(&self, u: f64) -> Result<DVec3, CurveError> {
        let charged = self.budget.charge(u, 1).and_then(|()| evaluate(&*self.inner, u));
        charged.inspect_err(|error| self.keep(u, error))
    }

    /// Writes the positions at `parameters` into `positions`, as far as the shorter list reaches.
    ///
    /// # Errors
    /// The first error in the order of the list; positions after it are not written.
    pub fn sample_into(&self, parameters: &[f64], positions: &mut [DVec3]) -> Result<(), CurveError> {
        for (at, &u) in positions.iter_mut().zip(parameters) {
            *at = self.try_position(u)?;
        }
        Ok(())
    }

    /// The positions at `parameters`, in their order.
    ///
    /// # Errors
    /// The first error in that order.
    pub fn sample(&self, parameters: impl IntoIterator<Item = f64>) -> Result<Vec<DVec3>, CurveError> {
        parameters.into_iter().map(|u| self.try_position(u)).collect()
    }

    /// The error at the smallest parameter so far.
    pub fn error(&self) -> Option<CurveError> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The curve under guard.
    pub fn inner(&self) -> &Arc<dyn Curve> {
        &self.inner
    }

    fn keep(&self, u: f64, error: &CurveError) {
        let mut kept = self.error.lock().unwrap_or_else(PoisonError::into_inner);
        let is_smallest = kept.as_ref().and_then(parameter).is_none_or(|v| u.total_cmp(&v).is_lt());
        if is_smallest {
            *kept = Some(error.clone());
        }
    }

    fn vector(&self, u: f64, cost: u64, vector: impl FnOnce() -> DVec3) -> DVec3 {
        let charged = self.budget.charge(u, cost).and_then(|()| call(u, vector));
        charged.inspect_err(|error| self.keep(u, error)).unwrap_or(DVec3::NAN)
    }
}

/// Where an error of an evaluation happened.
fn parameter(error: &CurveError) -> Option<f64> {
    match error {
        CurveError::NotFinite { u, .. } | CurveError::Panicked { u, .. } | CurveError::BudgetSpent { u, .. } => {
            Some(*u)
        }
        CurveError::PanickedAbout { .. } | CurveError::Rough { .. } => None,
    }
}

impl Curve for GuardedCurve {
    fn position(&self, u: f64) -> DVec3 {
        self.vector(u, 1, || self.inner.position(u))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.vector(u, DERIVATIVE, || self.inner.derivative(u))
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        self.vector(u, DERIVATIVE, || self.inner.derivative_before(u))
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.closed
    }

    fn revision(&self) -> u64 {
        self.revision
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::testing::bits;
    use crate::curve::{Bezier, FnCurve};

    fn guard(inner: impl Curve + 'static, limit: u64) -> GuardedCurve {
        GuardedCurve::new(Arc::new(inner), Arc::new(EvaluationBudget::new(limit))).expect("nothing panics yet")
    }

    #[test]
    fn a_sound_curve_keeps_its_bits() {
        let inner = Bezier::new(vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::ZERO]).expect("a curve");
        let guarded = guard(inner.clone(), u64::MAX);
        for k in 0..=64 {
            let u = f64::from(k) / 64.0;
            assert_eq!(bits(guarded.position(u)), bits(inner.position(u)));
            assert_eq!(bits(guarded.derivative(u)), bits(inner.derivative(u)));
            assert_eq!(bits(guarded.derivative_before(u)), bits(inner.derivative_before(u)));
        }
        assert_eq!((guarded.corners(), guarded.closed()), (inner.corners(), inner.closed()));
        assert_eq!(guarded.error(), None);
    }

    #[test]
    fn what_is_not_finite_is_named_with_parameter_and_point() {
        let guarded = guard(FnCurve::new(|u| DVec3::new(1.0, u, 1.0 / u)), 10);
        assert_eq!(guarded.try_position(0.5), Ok(DVec3::new(1.0, 0.5, 2.0)));
        let wanted = CurveError::NotFinite { u: 0.0, at: DVec3::new(1.0, 0.0, f64::INFINITY) };
        assert_eq!(guarded.try_position(0.0), Err(wanted.clone()));
        assert_eq!(guarded.sample([0.3, 0.0, 0.1]), Err(wanted));
    }

    #[test]
    fn a_budget_allows_its_limit_and_no_more() {
        let guarded = guard(FnCurve::new(DVec3::splat), 8);
        let mut points = [DVec3::ZERO; 4];
        assert_eq!(guarded.sample_into(&[0.1, 0.2, 0.3], &mut points), Ok(()));
        assert!(guarded.derivative(0.5).is_finite());
        assert_eq!(guarded.error(), None);
        assert_eq!(guarded.try_position(0.9), Err(CurveError::BudgetSpent { u: 0.9, limit: 8 }));
        assert!(guarded.position(0.4).is_nan());
        assert_eq!(guarded.error(), Some(CurveError::BudgetSpent { u: 0.4, limit: 8 }));
        assert_eq!(points[..3], [0.1, 0.2, 0.3].map(DVec3::splat));
    }

    #[test]
    fn a_budget_is_counted_over_all_curves_and_threads() {
        let budget = Arc::new(EvaluationBudget::new(100));
        let curves: Vec<_> = (0..4)
            .map(|_| GuardedCurve::new(Arc::new(FnCurve::new(DVec3::splat)), budget.clone()).expect("a curve"))
            .collect();
        let failed: usize = std::thread::scope(|scope| {
            let asked = |curve: &GuardedCurve| (0..50).filter(|k| curve.position(f64::from(*k)).is_nan()).count();
            let threads: Vec<_> = curves.iter().map(|curve| scope.spawn(move || asked(curve))).collect();
            threads.into_iter().map(|t| t.join().expect("guarded")).sum()
        });
        assert_eq!((failed, budget.spent()), (100, 200));
    }

    #[test]
    fn of_several_errors_the_one_at_the_smallest_parameter_is_kept() {
        for order in [[0.7, 0.2, 0.5], [0.2, 0.5, 0.7], [0.5, 0.7, 0.2]] {
            let guarded = guard(FnCurve::new(|_| DVec3::INFINITY), 100);
            assert!(order.iter().all(|&u| guarded.position(u).is_nan()));
            assert!(matches!(guarded.error(), Some(CurveError::NotFinite { u: 0.2, .. })));
        }
    }

    #[test]
    fn a_curve_that_panics_about_itself_is_refused() {
        #[derive(Debug)]
        struct Touchy;
        impl Curve for Touchy {
            fn position(&self, _: f64) -> DVec3 {
                std::panic::panic_any(7)
            }
            fn corners(&self) -> &[f64] {
                panic!("no {}", "corners")
            }
        }
        let refused = GuardedCurve::new(Arc::new(Touchy), Arc::new(EvaluationBudget::new(1))).map(|_| ());
        assert_eq!(refused, Err(CurveError::PanickedAbout { what: "corners", message: "no corners".into() }));
        let message = "a panic without a message".into();
        assert_eq!(evaluate(&Touchy, 0.1), Err(CurveError::Panicked { u: 0.1, message }));
    }
}
