//! Loops over independent pieces of work: on all cores with the feature `parallel`, in order without it.
//!
//! Results never depend on the number of threads: every piece writes only its own output.

/// Calls `work(index, piece)` for every piece, on all cores where there are several.
pub fn for_each_mut<T: Send>(pieces: &mut [T], work: impl Fn(usize, &mut T) + Sync + Send) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        pieces.par_iter_mut().enumerate().for_each(|(index, piece)| work(index, piece));
    }
    #[cfg(not(feature = "parallel"))]
    for (index, piece) in pieces.iter_mut().enumerate() {
        work(index, piece);
    }
}

/// Calls `work(index, chunk)` for every chunk of `size` elements (the last may be shorter).
pub fn for_each_chunk_mut<T: Send>(data: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync + Send) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        data.par_chunks_mut(size).enumerate().for_each(|(index, chunk)| work(index, chunk));
    }
    #[cfg(not(feature = "parallel"))]
    for (index, chunk) in data.chunks_mut(size).enumerate() {
        work(index, chunk);
    }
}

/// The values `work(0)` to `work(count - 1)`, in order, computed on all cores.
pub fn map_collect<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        (0..count).map(work).collect()
    }
}

/// Like [`map_collect`], with a scratch value a worker that is made by `init` and reused from piece to piece.
pub fn map_init_collect<S, R: Send>(
    count: usize,
    init: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map_init(init, work).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        let mut scratch = init();
        (0..count).map(|index| work(&mut scratch, index)).collect()
    }
}

/// The values of two pieces of work, done at once where that is `worthwhile`.
pub fn join<A: Send, B: Send>(
    worthwhile: bool,
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "parallel")]
    if worthwhile {
        return rayon::join(first, second);
    }
    #[cfg(not(feature = "parallel"))]
    let _ = worthwhile;
    (first(), second())
}

/// The number of threads that the loops of this module use.
pub fn thread_count() -> usize {
    #[cfg(feature = "parallel")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "parallel"))]
    {
        1
    }
}
