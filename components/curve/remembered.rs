//! A curve that remembers what it was asked.

use core::hash::{BuildHasherDefault, Hasher};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::Curve;

/// A curve with the points and derivatives that have been asked of it, so that each is computed once.
///
/// Worth it where a point costs much, a root that is sought say, and several that share a border ask
/// for the same ones. It gives the same bits as the curve itself, whoever asks first. It keeps what the
/// curve was when it was first asked: to be dropped before the curve may change.
#[derive(Debug)]
pub struct RememberedCurve {
    curve: Arc<dyn Curve>,
    /// In parts, by parameter, so that threads seldom wait for one another.
    parts: Vec<Mutex<Known>>,
}

/// By the bits of parameters, spread.
type Answers = HashMap<u64, DVec3, BuildHasherDefault<Spread>>;

/// The hash of a key that is spread already.
#[derive(Default)]
struct Spread(u64);

impl Hasher for Spread {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, _: &[u8]) {
        // Keys are whole numbers.
    }

    fn write_u64(&mut self, key: u64) {
        self.0 = key;
    }
}

/// What is known on some parameters: positions, derivatives, and derivatives from the left.
#[derive(Debug, Default)]
struct Known([Answers; 3]);

/// Parts of the memory: several for each of as many threads as a machine is likely to have.
const PARTS: usize = 64;

/// The most answers of one kind that a part keeps, 40 bytes each with their keys: with all parts 16 MB.
/// More are computed again.
const MOST: usize = 1 << 11;

impl RememberedCurve {
    /// Remembers nothing of `curve` yet.
    pub fn new(curve: Arc<dyn Curve>) -> Self {
        Self { curve, parts: (0..PARTS).map(|_| Mutex::default()).collect() }
    }

    fn ask(&self, kind: usize, u: f64, answer: impl FnOnce() -> DVec3) -> DVec3 {
        // Parameters of one hierarchy differ in high bits: a product carries all of them to the top. It is odd,
        // so no two parameters have the same. [Knuth]
        let key = u.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let part = &self.parts[(key >> 58) as usize % PARTS];
        // A table looks at the top bits, which all keys of a part share, and at the lowest.
        let key = key.rotate_left(32);
        // A panic of the curve itself is never under the lock: what is kept is whole.
        let lock = || part.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&known) = lock().0[kind].get(&key) {
            return known;
        }
        let new = answer();
        let answers = &mut lock().0[kind];
        if answers.len() < MOST {
            answers.insert(key, new);
        }
        new
    }
}

impl Curve for RememberedCurve {
    fn position(&self, u: f64) -> DVec3 {
        self.ask(0, u, || self.curve.position(u))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.ask(1, u, || self.curve.derivative(u))
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        // Both are one but at corners and where the curve begins.
        if u > 0.0 && !self.curve.corners().contains(&u) {
            return self.derivative(u);
        }
        self.ask(2, u, || self.curve.derivative_before(u))
    }

    fn corners(&self) -> &[f64] {
        self.curve.corners()
    }

    fn closed(&self) -> bool {
        self.curve.closed()
    }

    fn revision(&self) -> u64 {
        self.curve.revision()
    }
}

#[cfg(test)]
mod tests {
    use core::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::curve::FnCurve;

    /// Each parameter is asked of the curve once, and the answers are the curve's own bits.
    #[test]
    fn a_parameter_is_evaluated_once() {
        let asked = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&asked);
        let helix = move |u: f64| {
            count.fetch_add(1, Ordering::Relaxed);
            DVec3::new((5.0 * u).cos(), (5.0 * u).sin(), u)
        };
        let helix = Arc::new(FnCurve::new(helix));
        let remembered = RememberedCurve::new(helix.clone());
        let all = || (0..=100).map(|k| f64::from(k) / 100.0);
        let expected: Vec<DVec3> = all().map(|u| helix.position(u)).collect();
        asked.store(0, Ordering::Relaxed);
        for _ in 0..3 {
            assert!(all().map(|u| remembered.position(u)).eq(expected.iter().copied()));
        }
        assert_eq!(asked.load(Ordering::Relaxed), expected.len());
        for u in all() {
            assert_eq!(remembered.derivative(u), helix.derivative(u));
            assert_eq!(remembered.derivative_before(u), helix.derivative_before(u));
        }
    }

    /// More parameters than it keeps are answered all the same.
    #[test]
    fn what_is_forgotten_is_computed_again() {
        let line = Arc::new(FnCurve::new(|u| DVec3::X * u));
        let remembered = RememberedCurve::new(line);
        let count = 2 * MOST * PARTS;
        for _ in 0..2 {
            assert!((0..count).all(|k| {
                let u = k as f64 / count as f64;
                remembered.position(u) == DVec3::X * u
            }));
        }
        let kept: usize = remembered.parts.iter().map(|p| p.lock().map_or(0, |p| p.0[0].len())).sum();
        assert!(kept > MOST && kept <= MOST * PARTS, "{kept}");
    }
}
