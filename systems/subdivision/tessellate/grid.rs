//! Lattice points of one triangle, as the arrays that batched evaluation reads.

/// Which points of a triangle's lattice are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All.
    Closed,
    /// All but those on the edge from the second to the third corner.
    BelowFar,
    /// Those on no edge.
    Inside,
    /// Those on neither edge of the first corner.
    Beyond,
}

/// Lattice points `(a, b)` of a triangle with `steps` steps along an edge, rising with `a`, then `b`.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    /// `(a, b)` in steps.
    pub lattice: Vec<(u32, u32)>,
    /// `a / steps`.
    pub s: Vec<f64>,
    /// `b / steps`.
    pub t: Vec<f64>,
}

impl Grid {
    pub fn new(steps: usize, part: Part) -> Self {
        let n = steps as u32;
        let (low, high) = match part {
            Part::Closed => (0, n + 1),
            Part::BelowFar => (0, n),
            Part::Inside => (1, n),
            Part::Beyond => (1, n + 1),
        };
        Self::of(n, (low..high).flat_map(|a| (low..high - a).map(move |b| (a, b))))
    }

    /// The points inside edge `edge`, from corner `edge` to the next.
    pub fn edge(steps: usize, edge: usize) -> Self {
        let n = steps as u32;
        Self::of(n, (1..n).map(|i| [(i, 0), (n - i, i), (0, n - i)][edge]))
    }

    fn of(n: u32, lattice: impl Iterator<Item = (u32, u32)>) -> Self {
        let lattice: Vec<_> = lattice.collect();
        let share = |i: u32| f64::from(i) / f64::from(n);
        let (s, t) = lattice.iter().map(|&(a, b)| (share(a), share(b))).unzip();
        Self { lattice, s, t }
    }
}
