//! Frequent errors of single positions by sensor or logger: an angle that wraps after a turn, a placeholder for missing values.

use std::collections::BTreeMap;

use super::{finding::Finding, laguerre, values, window::Window};
use crate::{
    digits::{significant, with_unit},
    signal::record::rms,
    sorting::sort_by_number,
};

/// Minimum size of a wrap as a fraction of the range, and maximum relative difference of the wraps.
const LEAST_WRAP: f64 = 0.7;
const SAME_WRAP: f64 = 0.15;

/// Minimum fraction of the unwrapped position explained by a flexible linear model, and maximum ratio of its residual to that for the
/// wrapped position.
const FOLLOWS: f64 = 0.8;
const LEFT_UNWRAPPED: f64 = 0.5;

/// Maximum ratio of the model's residual where the angle is beyond its end to that elsewhere.
const MORE_BEYOND: f64 = 2.0;

/// Parts with at most this many samples may be constant.
const SHORT: usize = 20;

/// Fraction of the samples from which a placeholder is not a spike excluded from fits.
const MANY: f64 = 0.005;

/// Number of neighbours on either side with which a placeholder is compared, minimum distance from them relative to usual differences, and
/// as a fraction of the range of all positions: steps of a fine sensor are many times the differences of a position at rest.
const NEIGHBOURS: usize = 2;
const OFF: f64 = 12.0;
const LEAST_OFF: f64 = 0.05;

/// An angle that wraps at the end of its range.
#[allow(clippy::cast_precision_loss)] // a count of two
pub fn wraps(window: &Window, explained: f64, unit: &str, time: &[f64]) -> Option<Finding> {
    let position = &window.position;
    let (low, high) = values::extremes(position);
    let mut steps: Vec<(usize, f64)> = position.windows(2).map(|pair| pair[1] - pair[0]).enumerate().collect();
    steps.retain(|(_, step)| step.abs() > LEAST_WRAP * (high - low));
    let (first, _) = *steps.first()?;
    // Without the motion from sample to sample around the jump.
    let moved = |place: usize| {
        let around = [place.checked_sub(1), Some(place + 1)].into_iter().flatten().filter(|n| n + 1 < position.len());
        let moves =
            around.map(|n| position[n + 1] - position[n]).filter(|step| step.abs() <= LEAST_WRAP * (high - low));
        let moves: Vec<f64> = moves.collect();
        moves.iter().sum::<f64>() / moves.len().max(1) as f64
    };
    let mut sizes: Vec<f64> = steps.iter().map(|(place, step)| (step - moved(*place)).abs()).collect();
    sort_by_number(&mut sizes, |size| *size);
    let turn = sizes[sizes.len() / 2];
    if steps.len() < 2 || steps.iter().any(|(_, step)| (step.abs() / turn - 1.0).abs() > SAME_WRAP) {
        return None;
    }
    // The position of an unplugged sensor is constant between its jumps.
    let between = steps.windows(2).map(|pair| &position[pair[0].0 + 1..=pair[1].0]);
    if between.filter(|part| part.len() > SHORT).any(|part| part.iter().all(|value| *value == part[0])) {
        return None;
    }
    let mut turns = 0.0;
    let unwrapped = position.windows(2).map(|pair| {
        let step = pair[1] - pair[0];
        if step.abs() > LEAST_WRAP * (high - low) {
            turns -= step.signum() * turn;
        }
        pair[1] + turns
    });
    let unwrapped: Vec<f64> = position.first().copied().into_iter().chain(unwrapped).collect();
    let linear = laguerre::fit(&window.command, &unwrapped);
    let is_beyond = |n: &usize| (unwrapped[*n] - position[*n]).abs() > 0.5 * turn;
    let (beyond, within): (Vec<usize>, Vec<usize>) = (0..position.len()).partition(is_beyond);
    let left = |places: &[usize]| rms(&places.iter().map(|n| linear.residual[*n]).collect::<Vec<f64>>());
    let is_one = linear.share > FOLLOWS
        && 1.0 - linear.share < LEFT_UNWRAPPED * (1.0 - explained)
        && left(&beyond) < MORE_BEYOND * left(&within);
    is_one.then(|| {
        let times = steps.len();
        let turn = with_unit(turn, 3, unit);
        Finding::refusal(
            "wraps",
            format!("the position jumps by {turn} from one sample to the next, {times} times, and follows its command without these jumps: an angle that wraps around"),
            "unwrap the angle",
        )
        .at(window.start + first + 1, time)
    })
}

/// A placeholder for missing values: always exactly the same value, far from its neighbours.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn dropouts(window: &Window, time: &[f64]) -> Option<Finding> {
    let position = &window.position;
    let count = position.len();
    if count <= 2 * NEIGHBOURS {
        return None;
    }
    let about = |n: usize| {
        let mut others: Vec<f64> =
            position[n - NEIGHBOURS..n].iter().chain(&position[n + 1..=n + NEIGHBOURS]).copied().collect();
        sort_by_number(&mut others, |other| *other);
        0.5 * (others[NEIGHBOURS - 1] + others[NEIGHBOURS])
    };
    let off: Vec<f64> = (NEIGHBOURS..count - NEIGHBOURS).map(|n| (position[n] - about(n)).abs()).collect();
    let mut sizes = off.clone();
    sort_by_number(&mut sizes, |size| *size);
    // At rest or with rounding half of the differences are zero.
    let usual = sizes[sizes.len() * 3 / 4];
    let (low, high) = values::extremes(position);
    let far = (OFF * usual).max(LEAST_OFF * (high - low));
    // At an edge the neighbours on one side are close.
    let is_far = |n: usize, side: &[f64]| side.iter().any(|other| (position[n] - other).abs() > far);
    let stands_apart =
        |n: usize| is_far(n, &position[n - NEIGHBOURS..n]) && is_far(n, &position[n + 1..=n + NEIGHBOURS]);
    let mut places: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    let are_far = off.iter().enumerate().filter(|(_, off)| usual > 0.0 && **off > far).map(|(n, _)| n + NEIGHBOURS);
    for n in are_far.filter(|n| stands_apart(*n)) {
        places.entry(position[n].to_bits()).or_default().push(n);
    }
    let (value, places) = places.into_iter().max_by_key(|(_, places)| places.len())?;
    if (places.len() as f64) < MANY * count as f64 {
        return None;
    }
    let share = 100.0 * places.len() as f64 / count as f64;
    let sentence = format!(
        "{} % of the positions are exactly {}, far from their neighbours: a placeholder for missing samples",
        significant(share, 2),
        f64::from_bits(value)
    );
    Some(Finding::refusal("dropouts", sentence, "leave these rows out").at(window.start + places[0], time))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::inspect::window::NoiseLeft;

    const INTERVAL_S: f64 = 0.01;

    /// The response of a lag of 50 ms to a sum of sines or to a square wave, with some noise.
    fn window(amplitude: f64, is_square: bool) -> Window {
        let time = (0..3000).map(|n| INTERVAL_S * f64::from(n));
        let command = |t: f64| {
            let wave = (TAU * 0.4 * t).sin() + 0.6 * (TAU * 0.13 * t + 1.0).sin();
            amplitude * if is_square { wave.signum() } else { wave }
        };
        let command: Vec<f64> = time.map(command).collect();
        let lag = if is_square { 1.0 } else { 1.0 - (-INTERVAL_S / 0.05_f64).exp() };
        let position = command.iter().scan(0.0, |moved, command| {
            *moved += lag * (command - *moved);
            Some(*moved)
        });
        let position =
            position.enumerate().map(|(n, value)| value + 2e-3 * amplitude * (1e4 * n as f64).sin()).collect();
        Window { start: 0, interval_s: INTERVAL_S, command, position, load: None, noise_left: NoiseLeft::ALL }
    }

    fn time(window: &Window) -> Vec<f64> {
        (0..window.position.len()).map(|n| INTERVAL_S * n as f64).collect()
    }

    fn is_wrapped(window: &Window) -> bool {
        let share = laguerre::fit(&window.command, &window.position).share;
        wraps(window, share, "deg", &time(window)).is_some()
    }

    #[test]
    fn an_angle_that_begins_anew_is_said_and_a_square_wave_is_none() {
        let mut turned = window(200.0, false);
        assert!(!is_wrapped(&turned));
        turned.position.iter_mut().for_each(|position| *position = position.rem_euclid(360.0));
        assert!(is_wrapped(&turned));
        assert!(!is_wrapped(&window(200.0, true)));
    }

    #[test]
    fn values_written_for_none_are_said_and_few_spikes_a_coarse_step_and_a_square_wave_are_none() {
        let dropped = |mut window: Window, every: usize| {
            window.position.iter_mut().skip(every / 2).step_by(every).for_each(|position| *position = 0.0);
            dropouts(&window, &time(&window)).map(|finding| finding.sentence)
        };
        let plain = || window(5.0, false);
        assert!(dropped(plain(), 20).is_some_and(|sentence| sentence.contains("exactly 0,")));
        assert!(dropped(plain(), 60).is_some());
        assert_eq!(dropped(plain(), 1000), None);
        assert_eq!(dropouts(&plain(), &time(&plain())), None);
        assert_eq!(dropouts(&window(5.0, true), &time(&plain())), None);
        let mut coarse = plain();
        coarse.position.iter_mut().for_each(|position| *position = (*position / 0.5).round() * 0.5);
        assert_eq!(dropouts(&coarse, &time(&coarse)), None);
    }

    #[test]
    fn a_step_of_an_encoder_back_and_forth_where_the_position_rests_is_no_value_written_for_none() {
        let mut steady = window(5.0, true);
        let step = 0.004;
        for (n, position) in steady.position.iter_mut().enumerate() {
            // Noise moves every ninth position by one more step; a last digit varies.
            let counts = (steady.command[n] / step).round() + f64::from(u8::from(n % 9 == 4));
            *position = counts * step + if n % 3 == 0 { 1e-4 } else { 0.0 };
        }
        assert_eq!(dropouts(&steady, &time(&steady)), None);
    }
}
