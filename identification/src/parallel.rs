//! Work on all cores, results in order. Each parallel iterator of rayon compiles its own copy of rayon's joins, a tenth of the build time;
//! here there is one.

use std::{
    ops::Range,
    sync::{Mutex, MutexGuard, PoisonError},
};

use rayon::prelude::*;

/// Results of a function for all numbers below a count.
pub fn indexed<R: Send>(count: usize, one: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let places: Vec<Mutex<Option<R>>> = (0..count).map(|_| Mutex::new(None)).collect();
    for_each(count, &|index| {
        let result = one(index);
        *locked(&places[index]) = Some(result);
    });
    places.iter().filter_map(|place| locked(place).take()).collect()
}

/// Results of a function for references to all items.
pub fn map<T: Sync, R: Send>(items: &[T], one: impl Fn(&T) -> R + Sync) -> Vec<R> {
    indexed(items.len(), |index| one(&items[index]))
}

/// Results of a function for all items.
pub fn map_owned<T: Send, R: Send>(items: Vec<T>, one: impl Fn(T) -> R + Sync) -> Vec<R> {
    let places: Vec<Mutex<Option<T>>> = items.into_iter().map(|item| Mutex::new(Some(item))).collect();
    let result = |index: usize| locked(&places[index]).take();
    indexed(places.len(), |index| result(index).map(&one)).into_iter().flatten().collect()
}

/// Results of a function for the ranges into which the numbers below a count are divided, concatenated: for many short pieces of work.
pub fn ranges<R: Send>(count: usize, one: impl Fn(Range<usize>) -> Vec<R> + Sync) -> Vec<R> {
    const LENGTH: usize = 1024;
    let part = |index: usize| one(index * LENGTH..((index + 1) * LENGTH).min(count));
    indexed(count.div_ceil(LENGTH), part).into_iter().flatten().collect()
}

fn for_each(count: usize, one: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(one);
}

/// Its content is valid even after a panic elsewhere: each entry is written in one operation.
pub fn locked<T>(place: &Mutex<T>) -> MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_what_they_come_from() {
        let words: Vec<String> = (0..3000).map(|n: usize| n.to_string()).collect();
        let lengths: Vec<usize> = words.iter().map(String::len).collect();
        assert_eq!(indexed(3000, |n| n.to_string()), words);
        assert_eq!(map(&words, String::len), lengths);
        assert_eq!(map_owned(words.clone(), |word| word.len()), lengths);
        assert_eq!(ranges(3000, |range| range.map(|n| n.to_string()).collect()), words);
        assert!(ranges(0, |range| range.collect()).is_empty());
    }
}
