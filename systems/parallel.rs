//! Work on all cores, with the same bits on one.

/// Fewer items than this are mapped on the calling thread: waking a thread costs some
/// microseconds, as much as this many cheap items.
const ALONE: usize = 256;

/// Maps `0..count`, on all cores where the feature `parallel` is on; results stand in order.
///
/// Sums are folded over the returned list, never reduced in parallel: floating-point addition is
/// not associative, and the tree that a parallel reduction takes depends on the thread count.
pub fn map_in_order<R: Send>(count: usize, f: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "parallel")]
    if count >= ALONE {
        use rayon::prelude::*;
        return (0..count).into_par_iter().with_min_len(ALONE / 4).map(f).collect();
    }
    let _ = ALONE;
    (0..count).map(f).collect()
}

/// As [`map_in_order`], for items of some ten microseconds or more each: a few are worth a thread.
pub fn map_dear_in_order<R: Send>(count: usize, f: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().with_min_len(DEAR).map(f).collect()
    }
    #[cfg(not(feature = "parallel"))]
    (0..count).map(f).collect()
}

/// How many dear items a thread takes at once.
#[cfg(feature = "parallel")]
const DEAR: usize = 4;

/// Runs `work` on every item, on all cores where the feature `parallel` is on.
///
/// The items share nothing, so the order in which they happen to run leaves no trace.
pub fn for_each<T: Send>(items: Vec<T>, work: impl Fn(T) + Sync + Send) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        items.into_par_iter().for_each(work);
    }
    #[cfg(not(feature = "parallel"))]
    items.into_iter().for_each(work);
}

/// Does both, at once if there is a thread for it.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    #[cfg(feature = "parallel")]
    return rayon::join(a, b);
    #[cfg(not(feature = "parallel"))]
    (a(), b())
}

/// How many threads [`for_each`] may use.
pub fn threads() -> usize {
    #[cfg(feature = "parallel")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    1
}
