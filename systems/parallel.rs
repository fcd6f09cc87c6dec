//! Work on all cores, with the same bits on one.

/// Runs `work` on every item. The items share nothing, so the order leaves no trace.
///
/// With feature `parallel` on rayon's current pool; else in order on the calling thread.
pub(crate) fn for_each<T: Send>(items: Vec<T>, work: impl Fn(T) + Sync + Send) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        items.into_par_iter().for_each(work);
    }
    #[cfg(not(feature = "parallel"))]
    items.into_iter().for_each(work);
}
