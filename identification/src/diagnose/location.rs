//! Where the gap lies: its share over frequency, amplitude, rate, direction, time since a reversal, position, time and load, against
//! the share of the record that lies there, with a permutation test.
//!
//! Under the null hypothesis the gap is independent of the axis: circular shifts along the record keep its colour and give the
//! distribution of its shares.

use rustfft::{FftPlanner, num_complex::Complex};
use serde::Serialize;

use super::{
    regressors::since_reversal_s,
    trace::{Motion, Trace},
};
use crate::{
    digits::{significant, with_unit},
    signal::record::Record,
};
use actuator_fmu::parameters::Model;

/// A part of an axis in which the gap is denser than the record.
#[derive(Debug, Clone, Serialize)]
pub struct Location {
    /// `frequency`, `amplitude`, `rate`, `direction`, `reversal`, `position`, `time` or `load`.
    pub axis: &'static str,
    /// From and to.
    pub range: [f64; 2],
    /// Unit of the range.
    pub unit: &'static str,
    /// Share of the squared gap that lies there.
    pub share_of_gap: f64,
    /// Share of the record that lies there.
    pub share_of_record: f64,
    /// p-value of the share.
    pub p_value: f64,
    /// In words.
    pub sentence: String,
    /// Density of the gap over that of the record along the whole axis: middle of a bin, ratio.
    pub density: Vec<[f64; 2]>,
}

/// Parts into which an axis is divided, each with the same share of the record.
const BINS: usize = 12;

/// Circular shifts against which a share is tested.
const SHIFTS: usize = 99;

/// Greatest p-value of a location that is stated.
const SIGNIFICANCE_LEVEL: f64 = 0.05;

/// Samples of all records on one axis.
struct Samples {
    axis: &'static str,
    unit: &'static str,
    values: Vec<Vec<f64>>,
    phrase: Phrase,
}

/// A range in words.
type Phrase = Box<dyn Fn(f64, f64) -> String>;

/// Where the gap of records lies, the axis with the greatest excess first. `gaps` are measured less simulated, of the evaluated samples.
#[must_use]
pub fn locate(model: &Model, records: &[Record], gaps: &[Vec<f64>]) -> Vec<Location> {
    let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &model.base)).collect();
    let mut found: Vec<Location> =
        axes(model, &traces).iter().filter_map(|axis| of_axis(axis, gaps)).chain(of_frequency(&traces, gaps)).collect();
    found.retain(|location| location.p_value <= SIGNIFICANCE_LEVEL && location.share_of_gap > location.share_of_record);
    let excess = |location: &Location| location.share_of_gap - location.share_of_record;
    found.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    found
}

fn axes(model: &Model, traces: &[Trace<'_>]) -> Vec<Samples> {
    let motions: Vec<_> = traces.iter().filter_map(|trace| Some((trace, trace.motion(model)?))).collect();
    let of = |function: &dyn Fn(&Trace<'_>, &Motion) -> Vec<f64>| -> Vec<Vec<f64>> {
        motions.iter().map(|(trace, motion)| function(trace, motion)[trace.settling..].to_vec()).collect()
    };
    let position = model.unit();
    let (unit, rate_unit) = (position.name(), position.of_rate());
    let between = |low: f64, high: f64, unit: &str| format!("{} to {}", significant(low, 3), with_unit(high, 3, unit));
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
            phrase: Box::new(
                |low, _| if low < 0.0 { "in motions downwards".into() } else { "in motions upwards".into() },
            ),
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

/// Greatest |position| within half a second.
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

#[allow(clippy::cast_precision_loss)] // counts of samples
fn of_axis(samples: &Samples, gaps: &[Vec<f64>]) -> Option<Location> {
    let mut sorted: Vec<f64> = samples.values.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
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
    let places: Vec<Vec<usize>> =
        samples.values.iter().map(|values| values.iter().map(|value| bin_of(*value)).collect()).collect();
    let mut record = vec![0.0; bins];
    places.iter().flatten().for_each(|bin| record[*bin] += 1.0);
    let total: f64 = record.iter().sum();
    record.iter_mut().for_each(|share| *share /= total);
    let shares = |shift: usize| -> Vec<f64> {
        let mut gap = vec![0.0; bins];
        for (places, gaps) in places.iter().zip(gaps) {
            let moved = shift * gaps.len() / (SHIFTS + 1);
            for (index, bin) in places.iter().enumerate() {
                gap[*bin] += gaps[(index + moved) % gaps.len()].powi(2);
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
    let exceedances = (1..=SHIFTS).filter(|shift| excess(&shares(*shift)) >= own).count();
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

/// The run of bins in which the gap exceeds the record most.
fn densest(gap: &[f64], record: &[f64]) -> (usize, usize) {
    let (mut best, mut range) = (f64::NEG_INFINITY, (0, 0));
    let (mut sum, mut first) = (0.0, 0);
    for (bin, (gap, record)) in gap.iter().zip(record).enumerate() {
        if sum <= 0.0 {
            (sum, first) = (0.0, bin);
        }
        sum += gap - record;
        if sum > best {
            (best, range) = (sum, (first, bin));
        }
    }
    range
}

#[allow(clippy::cast_precision_loss)] // counts
fn located(
    axis: &'static str,
    unit: &'static str,
    range: [f64; 2],
    [share_of_gap, share_of_record]: [f64; 2],
    exceedances: usize,
    density: Vec<[f64; 2]>,
    phrase: &dyn Fn(f64, f64) -> String,
) -> Location {
    let sentence = format!(
        "{:.0} % of the difference lies {}, which is {:.0} % of the record",
        100.0 * share_of_gap,
        phrase(range[0], range[1]),
        100.0 * share_of_record
    );
    let p_value = (exceedances + 1) as f64 / (SHIFTS + 1) as f64;
    Location { axis, range, unit, share_of_gap, share_of_record, p_value, sentence, density }
}

/// Over frequency the record is the spectrum of its position; noise gives each of a band's lines an exponential share.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts and places of lines
fn of_frequency(traces: &[Trace<'_>], gaps: &[Vec<f64>]) -> Option<Location> {
    const HIGHEST_HZ: f64 = 15.0;
    let width = HIGHEST_HZ / BINS as f64;
    let mut planner = FftPlanner::new();
    let mut shares = |of: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
        let mut bins = vec![0.0; BINS];
        for (index, trace) in traces.iter().enumerate() {
            let values = of(index);
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let mut values: Vec<Complex<f64>> = values.iter().map(|value| Complex::new(value - mean, 0.0)).collect();
            planner.plan_fft_forward(values.len()).process(&mut values);
            let line = 1.0 / (trace.record.sampling().interval_s() * values.len() as f64);
            for (place, value) in values[..values.len() / 2].iter().enumerate() {
                if let Some(bin) = bins.get_mut((place as f64 * line / width) as usize) {
                    *bin += value.norm_sqr();
                }
            }
        }
        let sum = bins.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        bins.into_iter().map(|value| value / sum).collect()
    };
    let gap = shares(&|index| gaps[index].clone());
    let record = shares(&|index| traces[index].record.position()[traces[index].settling..].to_vec());
    let (first, last) = densest(&gap, &record);
    let sum = |shares: &[f64]| shares[first..=last].iter().sum::<f64>();
    let edge = |bin: usize| bin as f64 * width;
    let density =
        (0..BINS).map(|bin| [edge(bin) + 0.5 * width, gap[bin] / record[bin].max(1e-6)]).collect::<Vec<[f64; 2]>>();
    // Noise is spread over all frequencies, whatever the record's spectrum: a gap no denser than that is not significant.
    let spread = (last + 1 - first) as f64 / BINS as f64;
    let exceedances = if sum(&gap) > spread + 0.1 { 0 } else { SHIFTS };
    let phrase = |low: f64, high: f64| format!("between {low:.1} and {high:.1} Hz");
    Some(located(
        "frequency",
        "Hz",
        [edge(first), edge(last + 1)],
        [sum(&gap), sum(&record)],
        exceedances,
        density,
        &phrase,
    ))
}
