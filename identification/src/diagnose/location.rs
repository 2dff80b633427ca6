//! Location of the difference: its share over frequency, amplitude, rate, direction, time since a reversal, position, time and load, compared with
//! the share of the record there, with a permutation test.
//!
//! Under the null hypothesis the difference is independent of the axis: circular shifts along the record keep its colour and give the distribution of
//! its shares. Over frequency it is white noise.

use std::ops::Range;

pub use super::located::Location;
use super::{
    located::{BINS, SHIFTS, SIGNIFICANCE_LEVEL, TOO_MANY, densest, evaluated, located},
    location_over_frequency::of_frequency,
    regressors::since_reversal_s,
    trace::{Motion, Trace},
};
use crate::{
    digits::{significant, with_unit},
    signal::record::Record,
    sorting::sort_by_number,
};
use actuator_fmu::parameters::Model;

/// Samples of all records on one axis.
struct Samples {
    axis: &'static str,
    unit: &'static str,
    values: Vec<Vec<f64>>,
    phrase: Phrase,
}

/// A range in words.
type Phrase = Box<dyn Fn(f64, f64) -> String>;

/// Locates the difference on records, the axis on which it exceeds the record most first. `gaps` are measured minus simulated positions of the
/// evaluated samples.
#[must_use]
pub fn locate(model: &Model, records: &[Record], gaps: &[Vec<f64>]) -> Vec<Location> {
    let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &model.base)).collect();
    let sums: Vec<Vec<f64>> = gaps.iter().map(|gap| sums_of_squares(gap)).collect();
    let on_axes = axes(model, &traces, gaps).into_iter().filter_map(|axis| of_axis(&axis, &sums));
    let mut found: Vec<Location> = on_axes.chain(of_frequency(&traces, gaps)).collect();
    found.retain(|location| location.p_value <= SIGNIFICANCE_LEVEL && location.share_of_gap > location.share_of_record);
    let excess = |location: &Location| location.share_of_gap - location.share_of_record;
    sort_by_number(&mut found, |location| -excess(location));
    found
}

fn axes(model: &Model, traces: &[Trace<'_>], gaps: &[Vec<f64>]) -> Vec<Samples> {
    let Some(motions) = traces.iter().map(|trace| trace.motion(model)).collect::<Option<Vec<Motion>>>() else {
        return Vec::new();
    };
    let of = |function: &dyn Fn(&Trace<'_>, &Motion) -> Vec<f64>| -> Vec<Vec<f64>> {
        let evaluated = |(trace, motion), gap| evaluated(&function(trace, motion), gap).to_vec();
        traces.iter().zip(&motions).zip(gaps).map(|(of_record, gap)| evaluated(of_record, gap)).collect()
    };
    let position = model.unit();
    let (unit, rate_unit) = (position.name(), position.of_rate());
    let mut axes = vec![
        Samples {
            axis: "amplitude",
            unit,
            values: of(&|trace, motion| envelope(trace.record.time(), &motion.position)),
            phrase: Box::new(move |low, high| format!("where the amplitude is {}", between(low, high, unit))),
        },
        Samples {
            axis: "rate",
            unit: rate_unit,
            values: of(&|_, motion| motion.rate.iter().map(|rate| rate.abs()).collect()),
            phrase: Box::new(move |low, high| format!("at rates of {}", between(low, high, rate_unit))),
        },
        Samples {
            axis: "direction",
            unit: "1",
            values: of(&|_, motion| motion.rate.iter().map(|rate| rate.signum()).collect()),
            phrase: Box::new(|low, _| if low < 0.0 { "in downward motion".into() } else { "in upward motion".into() }),
        },
        Samples {
            axis: "reversal",
            unit: "s",
            values: of(&|trace, motion| since_reversal_s(trace.record.time(), &motion.rate)),
            phrase: Box::new(|low, high| match low {
                0.0 => format!("within {:.0} ms of a reversal", 1e3 * high),
                _ => format!("{:.0} to {:.0} ms after a reversal", 1e3 * low, 1e3 * high),
            }),
        },
        Samples {
            axis: "position",
            unit,
            values: of(&|_, motion| motion.position.clone()),
            phrase: Box::new(move |low, high| format!("at positions of {}", between(low, high, unit))),
        },
        Samples {
            axis: "time",
            unit: "s",
            values: of(&|trace, _| {
                let time = trace.record.time();
                time.iter().map(|t| t - time[0]).collect()
            }),
            phrase: Box::new(|low, high| format!("between {low:.2} and {high:.2} s of the records")),
        },
    ];
    if traces.iter().all(|trace| trace.record.load().is_some()) {
        axes.push(Samples {
            axis: "load",
            unit,
            values: of(&|trace, _| trace.record.load().map(<[f64]>::to_vec).unwrap_or_default()),
            phrase: Box::new(move |low, high| format!("under loads of {}", between(low, high, unit))),
        });
    }
    axes
}

/// A range in words, to three digits of its larger end.
fn between(low: f64, high: f64, unit: &str) -> String {
    const NOTHING: f64 = 1e-3;
    let [low, high] =
        [[low, high], [high, low]].map(|[end, other]| if end.abs() < NOTHING * other.abs() { 0.0 } else { end });
    format!("{} to {}", significant(low, 3), with_unit(high, 3, unit))
}

/// Largest |position| within half a second.
fn envelope(time: &[f64], position: &[f64]) -> Vec<f64> {
    const HALF_WINDOW_S: f64 = 0.25;
    let (mut first, mut last) = (0, 0);
    (0..time.len())
        .map(|index| {
            while time[first] < time[index] - HALF_WINDOW_S {
                first += 1;
            }
            while last + 1 < time.len() && time[last + 1] <= time[index] + HALF_WINDOW_S {
                last += 1;
            }
            position[first..=last].iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
        })
        .collect()
}

/// Σ e² before each sample of a difference that is repeated once.
fn sums_of_squares(gap: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let squares = gap.iter().chain(gap).map(|value| value * value);
    let sums = squares.map(|square| {
        sum += square;
        sum
    });
    std::iter::once(0.0).chain(sums).collect()
}

/// Samples of a record, one after another, in one bin.
struct Run {
    bin: usize,
    samples: Range<usize>,
}

fn runs(values: &[f64], bin_of: impl Fn(f64) -> usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (place, value) in values.iter().enumerate() {
        let bin = bin_of(*value);
        match runs.last_mut() {
            Some(run) if run.bin == bin => run.samples.end = place + 1,
            _ => runs.push(Run { bin, samples: place..place + 1 }),
        }
    }
    runs
}

/// `sums` are those of the squared differences, of [`sums_of_squares`].
#[allow(clippy::cast_precision_loss)] // counts of samples
fn of_axis(samples: &Samples, sums: &[Vec<f64>]) -> Option<Location> {
    let mut sorted: Vec<f64> = samples.values.iter().flatten().copied().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let mut edges: Vec<f64> = (0..=BINS).map(|bin| sorted[(bin * (sorted.len() - 1)) / BINS]).collect();
    edges.dedup();
    if samples.axis == "direction" {
        edges = vec![-1.0, 0.0, 1.0];
    }
    if edges.len() < 3 {
        return None;
    }
    let bins = edges.len() - 1;
    let bin_of = |value: f64| edges[1..bins].partition_point(|edge| *edge <= value);
    let runs: Vec<Vec<Run>> = samples.values.iter().map(|values| runs(values, bin_of)).collect();
    let mut record = vec![0.0; bins];
    runs.iter().flatten().for_each(|run| record[run.bin] += run.samples.len() as f64);
    let total: f64 = record.iter().sum();
    record.iter_mut().for_each(|share| *share /= total);
    let shares = |shift: usize| -> Vec<f64> {
        let mut gap = vec![0.0; bins];
        for (runs, sums) in runs.iter().zip(sums) {
            let moved = shift * (sums.len() / 2) / (SHIFTS + 1);
            for Run { bin, samples } in runs {
                gap[*bin] += sums[samples.end + moved] - sums[samples.start + moved];
            }
        }
        let sum = gap.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        gap.into_iter().map(|value| value / sum).collect()
    };
    let gap = shares(0);
    let (first, last) = densest(&gap, &record);
    let excess = |gap: &[f64]| {
        let (first, last) = densest(gap, &record);
        (first..=last).map(|bin| gap[bin] - record[bin]).sum::<f64>()
    };
    let own = excess(&gap);
    let exceedances = (1..=SHIFTS).filter(|shift| excess(&shares(*shift)) >= own).take(TOO_MANY).count();
    let range = [edges[first], edges[last + 1]];
    let sum = |shares: &[f64]| shares[first..=last].iter().sum::<f64>();
    let density =
        (0..bins).map(|bin| [0.5 * (edges[bin] + edges[bin + 1]), gap[bin] / record[bin].max(f64::MIN_POSITIVE)]);
    Some(located(
        samples.axis,
        samples.unit,
        range,
        [sum(&gap), sum(&record)],
        exceedances,
        density.collect(),
        &samples.phrase,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        signal::{
            Interpolation,
            excitation::{Excitation, Kind},
        },
        simulate::simulate,
        uniform_noise::uniform_noise,
    };
    use actuator_fmu::parameters::table;

    /// Locations of a difference that is this function of time, position and noise.
    fn located_where(difference: impl Fn(f64, f64, f64) -> f64) -> Vec<Location> {
        located_after(0, difference)
    }

    /// The same where the first samples are not evaluated.
    fn located_after(settling: usize, difference: impl Fn(f64, f64, f64) -> f64) -> Vec<Location> {
        let model = Model::from_set(&table()[0]);
        let random = Excitation { duration_s: 30.0, amplitude: 4.0, ..Excitation::new(Kind::Random) };
        let command = random.command().unwrap();
        let position = simulate(&model, &command, Interpolation::Held).unwrap().position;
        let record = Record::new(command, position.clone(), model.unit(), Interpolation::Held, "random").unwrap();
        let mut noise = uniform_noise(4);
        let gap = position.iter().zip(record.time()).map(|(position, time)| difference(*time, *position, noise()));
        locate(&model, std::slice::from_ref(&record), &[gap.skip(settling).collect()])
    }

    #[test]
    fn an_end_of_a_range_that_is_next_to_nothing_is_zero() {
        assert_eq!(between(8.42e-36, 15.2, "deg/s"), "0 to 15.2 deg/s");
        assert_eq!(between(-12.34, -1e-9, "deg"), "-12.3 to 0 deg");
        assert_eq!(between(0.02, 15.2, "deg/s"), "0.0200 to 15.2 deg/s");
    }

    #[test]
    fn shares_at_a_shift_are_those_of_the_shifted_difference() {
        let gap: Vec<f64> = (0..60).map(|n| f64::from(n * n % 17)).collect();
        let values: Vec<f64> = (0..60).map(|n| f64::from(n * n % 7)).collect();
        let (sums, runs) = (sums_of_squares(&gap), runs(&values, |value| value as usize));
        for moved in [0, 1, 31, 59] {
            for bin in 0..7 {
                let of_bin = runs.iter().filter(|run| run.bin == bin);
                let found: f64 =
                    of_bin.map(|run| sums[run.samples.end + moved] - sums[run.samples.start + moved]).sum();
                let places = (0..60).filter(|place| values[*place] as usize == bin);
                let expected: f64 = places.map(|place| gap[(place + moved) % 60].powi(2)).sum();
                assert!((found - expected).abs() < 1e-9, "{moved} {bin}: {found} {expected}");
            }
        }
    }

    #[test]
    fn noise_is_spread_as_chance_has_it() {
        let found = located_where(|_, _, noise| noise);
        assert!(found.len() <= 1, "{found:?}");
    }

    #[test]
    fn a_difference_is_located_wherever_its_evaluation_begins() {
        let where_high = |_: f64, position: f64, noise: f64| f64::from(position > 1.5) + 0.02 * noise;
        for settling in [0, 700] {
            let found = located_after(settling, where_high);
            let place = found.iter().find(|location| location.axis == "position").unwrap();
            assert!(place.range[0] > 0.8 && place.share_of_gap > 0.9, "{settling}: {found:?}");
        }
    }

    #[test]
    fn a_difference_is_located_on_the_axis_on_which_it_lies() {
        let found = located_where(
            |_, position, noise| if position > 1.5 { 0.5 * (position - 1.5) } else { 0.0 } + 0.02 * noise,
        );
        assert!(found[0].axis == "position" && found[0].range[0] > 0.8 && found[0].share_of_gap > 0.9, "{found:?}");
        let hum = located_where(|time, _, noise| 0.1 * (std::f64::consts::TAU * 50.0 * time).sin() + 0.02 * noise);
        let [low, high] = hum.iter().find(|location| location.axis == "frequency").unwrap().range;
        assert!(low < 50.0 && high > 50.0, "{low} to {high} Hz");
    }
}
