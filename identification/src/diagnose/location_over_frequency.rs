//! Location of the difference over frequency, where the null hypothesis is white noise.

use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, Gamma};
use rustfft::num_complex::Complex;

use super::{
    located::{BINS, Location, SHIFTS, TOO_MANY, densest, evaluated, located},
    trace::Trace,
};
use crate::{fourier, sorting::sort_by_number};

/// A spectral line of a record: frequency [Hz], power of the difference, power of the position.
type Line = [f64; 3];

/// Share of the position's power up to a certain frequency: the last bin begins at twice that frequency, or earlier.
const SHARE_OF_MOTION: f64 = 0.999;

/// Share of the difference beyond that of white noise, at least, for a location to be stated, however significant it is.
const LEAST_COLOUR: f64 = 0.1;

/// Over frequency the share of the record is that of the power of its position, and the null hypothesis is white noise, whose lines have
/// exponentially distributed powers. The last bin extends to Nyquist's frequency.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts and places of lines
pub fn of_frequency(traces: &[Trace<'_>], gaps: &[Vec<f64>]) -> Option<Location> {
    let mut lines: Vec<Line> = traces.iter().zip(gaps).flat_map(|(trace, gap)| lines(trace, gap)).collect();
    sort_by_number(&mut lines, |line| line[0]);
    let nyquist = lines.last()?[0];
    let whole: f64 = lines.iter().map(|line| line[2]).sum();
    let mut below = 0.0;
    let moved = lines.iter().find(|line| {
        below += line[2];
        below > SHARE_OF_MOTION * whole
    });
    let width = (2.0 * moved?[0] / (BINS - 1) as f64).min(nyquist / BINS as f64).max(f64::MIN_POSITIVE);
    let bin_of = |line: &Line| ((line[0] / width) as usize).min(BINS - 1);
    let in_bins = |of: &dyn Fn(&Line) -> f64| -> [f64; BINS] {
        let mut bins = [0.0; BINS];
        lines.iter().for_each(|line| bins[bin_of(line)] += of(line));
        bins
    };
    let shares = |bins: [f64; BINS]| -> [f64; BINS] {
        let sum = bins.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        bins.map(|value| value / sum)
    };
    let counts = in_bins(&|_| 1.0);
    let (gap, record) = (shares(in_bins(&|line| line[1])), shares(in_bins(&|line| line[2])));
    let white = shares(counts);
    let colour = |gap: &[f64]| {
        let (first, last) = densest(gap, &record);
        (first..=last).map(|bin| gap[bin] - white[bin]).sum::<f64>()
    };
    let own = colour(&gap);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    // A sum of n exponentially distributed powers has a gamma distribution of shape n.
    let sums = counts.map(|count| Gamma::new(count, 1.0).ok());
    let exceeds = |_: &usize| {
        let noise = sums.map(|sum| sum.map_or(0.0, |sum| sum.sample(&mut random)));
        colour(&shares(noise)) >= own
    };
    let exceedances = if own > LEAST_COLOUR { (0..SHIFTS).filter(exceeds).take(TOO_MANY).count() } else { SHIFTS };
    let (first, last) = densest(&gap, &record);
    let sum = |shares: &[f64]| shares[first..=last].iter().sum::<f64>();
    let edge = |bin: usize| if bin == BINS { nyquist } else { bin as f64 * width };
    let density = (0..BINS).map(|bin| [0.5 * (edge(bin) + edge(bin + 1)), gap[bin] / record[bin].max(1e-6)]).collect();
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

/// The lines of a record above frequency 0.
#[allow(clippy::cast_precision_loss)] // counts and places of lines
fn lines(trace: &Trace<'_>, gap: &[f64]) -> Vec<Line> {
    let spectrum = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let mut values: Vec<Complex<f64>> = values.iter().map(|value| Complex::new(value - mean, 0.0)).collect();
        fourier::forward(values.len()).process(&mut values);
        values.iter().map(Complex::norm_sqr).collect()
    };
    let (gap, position) = (spectrum(gap), spectrum(evaluated(trace.record.position(), gap)));
    let step = 1.0 / (trace.record.sampling().interval_s() * gap.len().max(1) as f64);
    (1..gap.len() / 2).map(|place| [place as f64 * step, gap[place], position[place]]).collect()
}
