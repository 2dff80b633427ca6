//! Whether and how a position follows its command: at all, with which lag, sign and unit.

use super::{
    behind,
    correlation::{Correlation, circular_autocorrelation},
    finding::Finding,
    laguerre, spectrum,
    window::Window,
};
use crate::{
    linear_least_squares::dot,
    signal::{play::range, record::without_mean},
};

/// Minimum fraction of the variance explained by a flexible linear model, in the sample, for a position that follows its command.
const LEAST_SHARE: f64 = 0.1;

/// Limits, play and friction leave a linear fraction above this; wide dead zones may leave less.
const LOW_SHARE: f64 = 0.3;

/// A fraction below this, or a position that does not clearly correlate with its command, is compared with the fraction that the same model
/// explains of the position shifted relative to the command.
const DOUBTFUL_SHARE: f64 = 0.7;

/// Maximum ratio of the latter to the former: above it the explanation is due to the smoothness of both signals, not to a response.
const BY_CHANCE: f64 = 0.6;

/// As above for a low fraction, and if several commands are tried.
const LOW_BY_CHANCE: f64 = 0.35;

/// Shifts of the position, as fractions of the record.
const SHIFTS: [f64; 6] = [0.23, 0.34, 0.45, 0.56, 0.67, 0.78];

/// Autocorrelation from which a signal repeats after a shift; a repetition counts within the record length divided by the other one.
const REPEATS: f64 = 0.7;
const REPEATS_WITHIN: usize = 20;

/// A position that correlates this well with its command is a response to it, at any lag.
pub const CLEAR_CORRELATION: f64 = 0.6;

/// Half widths of candidate dead zones, as fractions of the command's peak.
const DEAD_ZONES: [f64; 5] = [0.0, 0.2, 0.4, 0.6, 0.8];

/// Positions at rest between a few motions are partly explained by chance. With the correct play or dead zone the unexplained fraction is
/// at most this part of that by chance.
const LEFT_BEHIND: f64 = 0.15;

/// Minimum fraction explained behind a play or dead zone, for a position that follows its command without doubt.
const CLEARLY_BEHIND: f64 = 0.95;

/// Maximum excursion of an unsigned position to the other side of zero, as a fraction of its range: its noise.
const OF_OTHER_SIGN: f64 = 0.05;

/// Maximum lead between two columns of one logger [samples].
pub const GREATEST_LEAD: f64 = 1.0;

/// Maximum lag in periods of the fastest motion. A second-order servo responds up to about its natural frequency, with a lag of 2 ζ/ω or
/// about a fifth of a period; three whole periods indicate a clock error.
const GREATEST_LAG_PERIODS: f64 = 3.0;

/// As above in widths of the position's autocorrelation: steps are fast at their edges, and play delays them by much of their dwell.
const GREATEST_LAG_WIDTHS: f64 = 4.0;

/// A position that moves this many times as far as its command, without following it, may be self-oscillating.
const SWINGING: f64 = 3.0;

/// Gains that are unit factors rather than actuator gains, with their meaning and tolerance.
const UNIT_FACTORS: [(f64, &str); 4] = [
    (57.295_779_513, "a command in rad against a position in deg"),
    (0.017_453_292_5, "a command in deg against a position in rad"),
    (1000.0, "a command in m against a position in mm"),
    (0.001, "a command in mm against a position in m"),
];
const UNIT_TOLERANCE: f64 = 0.25;

/// Time after which the autocorrelation of the position has fallen to one half [s].
#[allow(clippy::cast_precision_loss)] // counts of samples
fn width_s(window: &Window) -> f64 {
    const MOST_SAMPLES: usize = 20_000;
    let stride = window.position.len().div_ceil(MOST_SAMPLES).max(1);
    let thin: Vec<f64> = window.position.iter().step_by(stride).copied().collect();
    let mean = thin.iter().sum::<f64>() / thin.len().max(1) as f64;
    let about: Vec<f64> = thin.iter().map(|value| value - mean).collect();
    let product = |lag: usize| dot(&about, &about[lag..]);
    let whole = product(0);
    let width = (1..about.len()).find(|lag| product(*lag) < 0.5 * whole).unwrap_or(about.len());
    (width * stride) as f64 * window.interval_s
}

/// Whether and how the position, without the contribution of a load, follows.
pub fn findings(window: &Window, share: f64, gain: f64, correlation: Correlation) -> Vec<Finding> {
    let lag_s = correlation.lag_samples * window.interval_s;
    let mut findings = vec![Finding::note(
        "response",
        format!(
            "a flexible linear model of the command explains {:.1} % of the position; ratio {gain:.4}, lag {:.4} s",
            100.0 * share,
            lag_s
        ),
    )];
    let clear = correlation.coefficient.abs() >= CLEAR_CORRELATION;
    // Noise may be faster than the command, and a command faster than its response.
    let fastest = [&window.command, &window.position]
        .map(|signal| spectrum::band(signal, window.interval_s).highest_hz)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    if clear && correlation.lag_samples < -GREATEST_LEAD && !is_rather_play(window, -correlation.lag_samples) {
        findings.push(Finding::refusal(
            "lead",
            format!("the position leads its command by {:.4} s", -lag_s),
            "check whether the columns are exchanged (--columns command=...,position=...) or have different clocks",
        ));
    } else if clear && lag_s * fastest > GREATEST_LAG_PERIODS && lag_s > GREATEST_LAG_WIDTHS * width_s(window) {
        findings.push(Finding::refusal(
            "late",
            format!(
                "the position follows its command {lag_s:.3} s late, {:.0} periods of its fastest motion: the columns have different clocks",
                lag_s * fastest
            ),
            "shift one of the columns, or record both with one clock",
        ));
    } else if share < DOUBTFUL_SHARE && changes_sign(window) && swinging(window).is_none() {
        findings.push(Finding::refusal(
            "sign_changes",
            "the position follows its command at one end of the record and moves against it at the other",
            "check that these are parts of one record with one sign",
        ));
    } else if (share < DOUBTFUL_SHARE || !clear) && !follows(window, share, clear) {
        findings.push(if follows_magnitude(window) {
            Finding::refusal(
                "unsigned",
                "the position follows the magnitude of its command, not its sign: the sensor does not measure the sign",
                "provide a signed position",
            )
        } else {
            Finding::refusal(
                "no_response",
                format!(
                    "the position does not follow the command: a flexible linear model of it explains {:.1} % of the position",
                    100.0 * share
                ),
                what_to_do(window),
            )
        });
    }
    if gain < 0.0 && clear {
        findings.push(Finding::warning(
            "sign",
            "the position moves against its command: opposite sign",
            "change the sign of one of the columns",
        ));
    }
    let factor = UNIT_FACTORS.iter().find(|(factor, _)| (gain.abs() / factor).ln().abs() < UNIT_TOLERANCE);
    if let Some((_, words)) = factor.filter(|_| share >= LOW_SHARE) {
        findings.push(Finding::warning(
            "unit",
            format!("the position is {:.4} times the command, as with {words}", gain.abs()),
            "give both columns in one unit",
        ));
    }
    findings
}

/// Whether the last quarter of a position is the opposite of the response predicted from the first quarter.
fn changes_sign(window: &Window) -> bool {
    /// Minimum explained variance of the first quarter.
    const EXPLAINED: f64 = 0.8;
    /// Minimum correlation with the opposite.
    const OPPOSITE: f64 = -0.9;
    let count = window.position.len();
    let (command, position) = (&window.command, &window.position);
    let first = laguerre::fit(&command[..count / 4], &position[..count / 4]);
    if first.share < EXPLAINED {
        return false;
    }
    let last = count - count / 4;
    let [expected, found] =
        [first.response_to(&command[last..]), position[last..].to_vec()].map(|part| without_mean(&part));
    dot(&expected, &found) < OPPOSITE * (dot(&expected, &expected) * dot(&found, &found)).sqrt()
}

/// How many times as far as its command a position moves, where it may oscillate by itself.
fn swinging(window: &Window) -> Option<f64> {
    let [command, position] = [&window.command, &without_load(window)].map(|signal| {
        let (low, high) = range(signal);
        high - low
    });
    Some(position / command).filter(|times| command > 0.0 && *times > SWINGING)
}

/// Finding for a position that does not follow its command.
fn what_to_do(window: &Window) -> String {
    if let Some(times) = swinging(window) {
        return format!(
            "the position moves {times:.0} times as far as its command: if its loop oscillates by itself, record smaller or slower motion; \
             otherwise check that both columns are from one record, in the same time order and unit"
        );
    }
    "check that both columns are from one record and in the same time order, and that the actuator was on".to_owned()
}

/// Whether a position follows its command, a load, or its command behind a wide dead zone, a wide play or a stop.
fn follows(window: &Window, share: f64, clear: bool) -> bool {
    let by_chance = if share < LOW_SHARE { LOW_BY_CHANCE } else { BY_CHANCE };
    if share >= LEAST_SHARE
        && ((share >= DOUBTFUL_SHARE && clear) || by_shift(&window.command, &window.position) <= by_chance * share)
    {
        return true;
    }
    let position = without_load(window);
    let peak = behind::peak(&window.command);
    let responds = |(command, share): (Vec<f64>, f64)| leaves_little(share, by_shift(&command, &position));
    // One of several candidates may succeed by chance.
    DEAD_ZONES.iter().any(|part| {
        let command = behind::dead_zone(&window.command, part * peak);
        let share = laguerre::fit(&command, &position).share;
        share >= LOW_SHARE && by_shift(&command, &position) <= LOW_BY_CHANCE * share
    }) || responds(behind::best_play(&window.command, &position))
        || responds(behind::best_dead_zone(&window.command, &position))
        || responds(behind::best_stop(&window.command, &position))
}

/// Whether the command behind a play or dead zone explains nearly all of a position, without the contribution of a load.
pub fn follows_behind_play_or_dead_zone(window: &Window) -> bool {
    let (command, position) = (&window.command, without_load(window));
    [behind::best_play, behind::best_dead_zone].iter().any(|best| best(command, &position).1 >= CLEARLY_BEHIND)
}

/// Whether the command behind a play explains far more of the position than the command with this lead: for few motions between two levels
/// the later one may correlate best with the earlier response.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
fn is_rather_play(window: &Window, lead_samples: f64) -> bool {
    let (position, lead) = (without_load(window), lead_samples.round() as usize);
    let ahead = laguerre::fit(&window.command[lead..], &position[..position.len() - lead]).share;
    let (_, behind) = behind::best_play(&window.command, &position);
    leaves_little(behind, ahead)
}

/// Whether the explanation with this fraction leaves far less than that with the other one.
fn leaves_little(share: f64, other: f64) -> bool {
    1.0 - share <= LEFT_BEHIND * (1.0 - other)
}

/// Whether a position of one sign follows the magnitude of its command.
fn follows_magnitude(window: &Window) -> bool {
    let (low, high) = range(&window.position);
    let magnitude: Vec<f64> = window.command.iter().map(|value| value.abs()).collect();
    let share = laguerre::fit(&magnitude, &window.position).share;
    let responds = || {
        let by_shift = by_shift(&magnitude, &window.position);
        by_shift <= LOW_BY_CHANCE * share || leaves_little(share, by_shift)
    };
    low.max(-high) > -OF_OTHER_SIGN * (high - low) && share >= DOUBTFUL_SHARE && responds()
}

fn without_load(window: &Window) -> Vec<f64> {
    match &window.load {
        Some(load) => laguerre::fit(load, &window.position).residual,
        None => window.position.clone(),
    }
}

/// Maximum fraction that the model explains of a position shifted relative to its command, by shifts after which neither signal repeats, or
/// repeats with opposite sign: a periodic command also explains a response to it one period later.
fn by_shift(command: &[f64], position: &[f64]) -> f64 {
    let count = command.len();
    let alike = [command, position].map(circular_autocorrelation);
    let is_no_period = |shift: &usize| {
        let near = shift.saturating_sub(count / REPEATS_WITHIN)..=(shift + count / REPEATS_WITHIN).min(count - 1);
        let repeated = near.max_by(|one, other| alike[0][*one].abs().total_cmp(&alike[0][*other].abs()));
        let [command, position] = repeated.map_or([0.0; 2], |shift| [alike[0][shift], alike[1][shift]]);
        command.abs() < REPEATS || position * command.signum() < REPEATS
    };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
    let shifts = SHIFTS.map(|part| (part * count as f64) as usize);
    let shifted = shifts.into_iter().filter(is_no_period).map(|shift| {
        let mut position = position.to_vec();
        position.rotate_left(shift);
        laguerre::fit(command, &position).share
    });
    shifted.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::inspect::{correlation::correlate, window::NoiseLeft};

    /// A staircase that goes mostly far beyond a stop, at which the position then rests.
    #[test]
    fn a_position_between_stops_follows_its_command() {
        let held = |levels: &[(f64, usize)]| -> Vec<f64> {
            levels.iter().flat_map(|(level, count)| std::iter::repeat_n(*level, 40 * count)).collect()
        };
        let command = held(&[(0.0, 4), (-3.3, 6), (6.0, 5), (16.0, 4), (60.0, 12), (16.0, 5), (6.0, 4)]);
        let measured = |command: &[f64]| -> Vec<f64> {
            let lagged = command.iter().scan(0.0, |moved, command| {
                *moved += 0.1 * (0.8 * command - *moved);
                Some(*moved)
            });
            lagged.enumerate().map(|(n, value)| value.clamp(-5.6, 4.8) + 0.05 * (1e4 * n as f64).sin()).collect()
        };
        assert!(!is_no_response(&command, measured(&command)));
        let of_another = measured(&held(&[(6.0, 7), (-8.0, 5), (3.0, 6), (-20.0, 4), (1.0, 9), (25.0, 3), (-2.0, 6)]));
        assert!(is_no_response(&command, of_another));
    }

    /// With a wide dead zone, three periods of a motion whose second half is the opposite of its first.
    #[test]
    fn a_response_that_repeats_itself_with_its_command_is_no_chance() {
        let multisine = |start: f64| -> Vec<f64> {
            let line = |t: f64, n: f64| (TAU * (2.0 * n + 1.0) * t / 3.93 + start * n * n).sin();
            (0..1179).map(|n| (0..40).map(|k| line(0.01 * f64::from(n), f64::from(k))).sum()).collect()
        };
        let measured = |command: &[f64]| -> Vec<f64> {
            let lagged = command.iter().scan(0.0, |moved, command| {
                *moved += 0.1 * (command - command.clamp(-6.0, 6.0) - *moved);
                Some(*moved)
            });
            lagged.collect()
        };
        let command = multisine(0.7);
        let position = measured(&command);
        let share = laguerre::fit(&command, &position).share;
        assert!(by_shift(&command, &position) < 0.75 * share);
        assert!(!is_no_response(&command, position));
        let of_another = measured(&multisine(1.9));
        assert!(is_no_response(&command, of_another));
        let never_again: Vec<f64> = (0..1179).map(|n| (1e-4 * f64::from(n * n)).sin()).collect();
        assert!(by_shift(&command, &never_again) > 0.0);
    }

    /// A position that follows for a quarter of a record, and moves against it, as far or many times as far, in the last one.
    #[test]
    fn a_position_that_swings_far_beyond_its_command_changes_no_sign() {
        let command: Vec<f64> = (0..2000).map(|n| (5e-5 * f64::from(n * n)).sin()).collect();
        let against = |times: f64| -> Vec<&'static str> {
            let of = |(n, command): (usize, &f64)| match n / 500 {
                0 => *command,
                3 => -times * command,
                _ => times * (0.37 * n as f64).sin(),
            };
            kinds(&command, command.iter().enumerate().map(of).collect())
        };
        assert!(against(1.0).contains(&"sign_changes"));
        assert!(!against(4.0).contains(&"sign_changes"), "{:?}", against(4.0));
    }

    fn is_no_response(command: &[f64], position: Vec<f64>) -> bool {
        kinds(command, position).contains(&"no_response")
    }

    fn kinds(command: &[f64], position: Vec<f64>) -> Vec<&'static str> {
        let (start, interval_s, command) = (0, 0.01, command.to_vec());
        let window = Window { start, interval_s, command, position, load: None, noise_left: NoiseLeft::ALL };
        let linear = laguerre::fit(&window.command, &window.position);
        let correlation = correlate(&window.command, &window.position);
        findings(&window, linear.share, linear.gain, correlation).iter().map(|finding| finding.kind).collect()
    }
}
