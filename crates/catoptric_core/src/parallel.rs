//! Loops over independent pieces of work: on all cores with the feature `parallel`, in order without it.
//!
//! Results never depend on the number of threads: every piece writes only its own output. The loops named `*_stage`
//! report a step a piece, and stop between pieces where they are cancelled.
//!
//! Loops hand whole ranges of pieces to a `dyn` closure: rayon's code, which is large, is compiled once a type of data
//! and not once a loop.

use crate::progress::{Cancelled, Progress, Stage};
use std::ops::Range;
#[cfg(feature = "parallel")]
use std::sync::{Mutex, PoisonError};

/// Calls `work(index, piece)` for every piece, on all cores where there are several.
pub fn for_each_mut<T: Send>(pieces: &mut [T], work: impl Fn(usize, &mut T) + Sync + Send) {
    for_each_run(pieces, 1, &|first, run| {
        for (offset, piece) in run.iter_mut().enumerate() {
            work(first + offset, piece);
        }
    });
}

/// Calls `work(index, chunk)` for every chunk of `size` elements (the last may be shorter).
pub fn for_each_chunk_mut<T: Send>(data: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync + Send) {
    for_each_run(data, size, &|first, run| {
        for (offset, chunk) in run.chunks_mut(size).enumerate() {
            work(first + offset, chunk);
        }
    });
}

/// Whole chunks and the index of the first.
#[cfg(feature = "parallel")]
type Run<'a, T> = (usize, &'a mut [T]);

/// Calls `work` with runs of whole chunks of `size` elements, and the index of the first chunk of each.
fn for_each_run<T: Send>(data: &mut [T], size: usize, work: &(dyn Fn(usize, &mut [T]) + Sync)) {
    assert!(size > 0, "chunks have elements");
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        fn halved<'a, T>((first, run): Run<'a, T>, size: usize) -> (Run<'a, T>, Option<Run<'a, T>>) {
            match run.len().div_ceil(size) / 2 {
                0 => ((first, run), None),
                chunks => {
                    let (left, right) = run.split_at_mut(chunks * size);
                    ((first, left), Some((first + chunks, right)))
                }
            }
        }
        rayon::iter::split((0, data), |run| halved(run, size)).for_each(|(first, run)| work(first, run));
    }
    #[cfg(not(feature = "parallel"))]
    work(0, data);
}

/// The values `work(0)` to `work(count - 1)`, in order, computed on all cores.
pub fn map_collect<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    map_init_collect(count, || (), |(), index| work(index))
}

/// Like [`map_collect`], with a scratch value a worker that is made by `init` and reused from piece to piece.
pub fn map_init_collect<S, R: Send>(
    count: usize,
    init: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize) -> R + Sync + Send,
) -> Vec<R> {
    let map = |range: Range<usize>, results: &mut Vec<R>| {
        let mut scratch = init();
        results.extend(range.map(|index| work(&mut scratch, index)));
    };
    #[cfg(feature = "parallel")]
    return collect_runs(count, &map);
    #[cfg(not(feature = "parallel"))]
    {
        let mut results = Vec::with_capacity(count);
        map(0..count, &mut results);
        results
    }
}

/// [`for_each_mut`] as a stage of work.
///
/// # Errors
/// [`Cancelled`]; some pieces are then as they were.
pub fn for_each_mut_stage<T: Send>(
    progress: &dyn Progress,
    name: &str,
    pieces: &mut [T],
    work: impl Fn(usize, &mut T) + Sync + Send,
) -> Result<(), Cancelled> {
    let stage = Stage::begin(progress, name, pieces.len())?;
    for_each_mut_within(&stage, pieces, |index, piece| {
        work(index, piece);
        // An error is kept by the stage.
        let _ = stage.advance(1);
    })
}

/// [`for_each_mut`] as a part of a step of a stage.
///
/// # Errors
/// [`Cancelled`]; some pieces are then as they were.
pub fn for_each_mut_within<T: Send>(
    stage: &Stage<'_>,
    pieces: &mut [T],
    work: impl Fn(usize, &mut T) + Sync + Send,
) -> Result<(), Cancelled> {
    for_each_mut(pieces, |index, piece| {
        if stage.check().is_ok() {
            work(index, piece);
        }
    });
    stage.check()
}

/// [`map_collect`] as a stage of work.
///
/// # Errors
/// [`Cancelled`].
pub fn map_stage<R: Send>(
    progress: &dyn Progress,
    name: &str,
    count: usize,
    work: impl Fn(usize) -> R + Sync + Send,
) -> Result<Vec<R>, Cancelled> {
    map_init_stage(progress, name, count, || (), |(), index| work(index))
}

/// [`map_collect`] as a part of one step of a stage.
///
/// # Errors
/// [`Cancelled`].
pub fn map_within<R: Send>(
    stage: &Stage<'_>,
    count: usize,
    work: impl Fn(usize) -> R + Sync + Send,
) -> Result<Vec<R>, Cancelled> {
    map_collect(count, |index| stage.advance(0).map(|()| work(index))).into_iter().collect()
}

/// [`map_init_collect`] as a stage of work.
///
/// # Errors
/// [`Cancelled`].
pub fn map_init_stage<S, R: Send>(
    progress: &dyn Progress,
    name: &str,
    count: usize,
    init: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize) -> R + Sync + Send,
) -> Result<Vec<R>, Cancelled> {
    let stage = Stage::begin(progress, name, count)?;
    let results = map_init_collect(count, init, |scratch, index| {
        stage.check()?;
        let result = work(scratch, index);
        stage.advance(1)?;
        Ok(result)
    });
    results.into_iter().collect()
}

/// The results that `map` appends for ranges that are together `0..count`, in order.
#[cfg(feature = "parallel")]
fn collect_runs<R: Send>(count: usize, map: &(dyn Fn(Range<usize>, &mut Vec<R>) + Sync)) -> Vec<R> {
    let runs = Mutex::new(Vec::new());
    for_each_range(count, &|range| {
        let first = range.start;
        // The first run takes in all others.
        let mut run = Vec::with_capacity(if first == 0 { count } else { range.len() });
        map(range, &mut run);
        runs.lock().unwrap_or_else(PoisonError::into_inner).push((first, run));
    });
    let mut runs = runs.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut order: Vec<(usize, usize)> = runs.iter().enumerate().map(|(place, (first, _))| (*first, place)).collect();
    order.sort_unstable();
    let mut all = Vec::new();
    for (_, place) in order {
        let run = &mut runs[place].1;
        if all.is_empty() {
            all = std::mem::take(run);
        } else {
            all.append(run);
        }
    }
    all
}

/// Calls `work` for ranges that are together `0..count`; as many as keep all cores busy.
#[cfg(feature = "parallel")]
fn for_each_range(count: usize, work: &(dyn Fn(Range<usize>) + Sync)) {
    use rayon::prelude::*;
    let halved = |range: Range<usize>| match range.len() / 2 {
        0 => (range, None),
        half => (range.start..range.start + half, Some(range.start + half..range.end)),
    };
    rayon::iter::split(0..count, halved).for_each(work);
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
