//! An oscillation that no command drives and that is most of a difference: hum, hunting, a limit cycle. It is one line in the spectrum of what any base
//! leaves, of one frequency in all records, so that it is told whatever the structure of the actuator is.

use super::{
    evidence::pooled_deviation,
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm},
    leave_one_out::Judgement,
    linear_rival::left_by_linear,
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    spectral_peak::strongest_frequency_hz,
    trace::{Trace, interval_s},
};
use crate::signal::record::without_mean;
use actuator_fmu::parameters::Model;

pub const CHATTER: &str = "chatter";

/// Of the variance that the given model leaves about the level of each record, what an oscillation leaves at most, of fitted and of check records; and how
/// many times as much any base leaves, and a flexible linear model of the command.
const GREATEST_LEFT: f64 = 0.4;
const LEAST_LEFT_BY_BASE: f64 = 2.0;

/// Largest over smallest amplitude among the records: what the motion makes differs with it.
const GREATEST_RATIO: f64 = 2.0;

/// Periods in the shortest record.
const FEWEST_PERIODS: f64 = 4.0;

/// Harmonics of the command up to this one are within so many lines of the record's spectrum.
const HIGHEST_HARMONIC: f64 = 9.0;
const HARMONIC_LINES: f64 = 2.0;

const ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// The oscillation that is most of what the given model leaves, beside it, beside a base near it, with the oscillation or without it, or beside
    /// one of its own, whose numbers do not matter to it; none where there is none.
    pub fn leading_oscillation(&self, judged: &Judgement, base: &Fitted) -> Option<Fitted> {
        if self.given.effects.active_values_of(CHATTER).is_some() || self.as_healthy().is_some() {
            return None;
        }
        let anywhere = self.base_of_its_own(judged)?;
        let levelled: Vec<Vec<f64>> = anywhere.residuals.iter().map(|left| without_mean(left)).collect();
        let frequency_hz = strongest_frequency_hz(&levelled, &self.fit);
        let space_of_base = Space::new(anywhere.space.hypothesis.clone(), &anywhere.model, &self.given.base, 0.0);
        let by_base = PlainFit::at(space_of_base.clone(), space_of_base.start(), &self.check)?;
        let [of_fit, of_check] = [&anywhere, &by_base].map(|fit| pooled_deviation(&fit.residuals).powi(2));
        let beside = |kind: Hypothesis, start: &Model| {
            let hypothesis = Hypothesis { effects: vec![CHATTER], ..kind };
            let space = Space::new(hypothesis, start, &self.given.base, frequency_hz);
            let space = if space.hypothesis.wide { space.within_sampling(interval_s(&self.fit)) } else { space };
            let lead = self.by_likelihood(PlainFit::search(space, &self.fit, ITERATIONS)?)?;
            let [fitted, checked] = self.left_by(&lead)?;
            let is_told = LEAST_LEFT_BY_BASE * fitted < of_fit && LEAST_LEFT_BY_BASE * checked < of_check;
            (is_told && self.objection_to_oscillation(&lead, base).is_none()).then_some(lead)
        };
        let near = Hypothesis { base_free: true, ..Hypothesis::default() };
        beside(Hypothesis::default(), self.given)
            .or_else(|| beside(Hypothesis::default(), &base.model))
            .or_else(|| beside(near, self.given))
            .or_else(|| beside(anywhere.space.hypothesis.clone(), &anywhere.model))
    }

    /// Why an oscillation is no lead; none where it is one.
    pub fn objection_to_oscillation(&self, lead: &Fitted, base: &Fitted) -> Option<String> {
        let (Some(left), Some(before)) = (self.left_by(lead), self.left_by_model()) else {
            return Some("a model with it moves without end".to_owned());
        };
        let by_base = self.left_by(base);
        let takes = |place: usize| {
            left[place] < GREATEST_LEFT * before[place]
                && by_base.is_none_or(|by_base| LEAST_LEFT_BY_BASE * left[place] < by_base[place])
        };
        if !takes(0) || !takes(1) {
            return Some("it leaves much of the difference, or another base leaves as little".to_owned());
        }
        let frequency_hz = lead.space.chatter_hz(&lead.x);
        let durations = self.fit.iter().chain(&self.check).map(|trace| trace.record.duration_s());
        if frequency_hz * durations.fold(f64::INFINITY, f64::min) < FEWEST_PERIODS {
            return Some("it is a drift as well".to_owned());
        }
        let Some(there) = lead.on(&self.check) else { return Some("a model with it moves without end".to_owned()) };
        let amplitudes: Vec<f64> = amplitudes(lead).into_iter().chain(amplitudes(&there)).collect();
        let (least, greatest) = amplitudes
            .iter()
            .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), one| (low.min(*one), high.max(*one)));
        if greatest > GREATEST_RATIO * least {
            return Some("its amplitude differs between records: it comes with the motion".to_owned());
        }
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let by_linear = left_by_linear(&traces, self.given.base.omega());
        #[allow(clippy::cast_precision_loss)] // a count of records
        let by_linear = by_linear.iter().sum::<f64>() / by_linear.len() as f64;
        let is_driven = by_linear < LEAST_LEFT_BY_BASE * left[0].max(left[1])
            || traces.iter().all(|trace| is_harmonic(trace, frequency_hz));
        is_driven.then(|| "the command drives it, or has a frequency of which it is a multiple".to_owned())
    }

    /// Variance about the level of each record that a fit leaves of the fitted and of the check records.
    fn left_by(&self, fitted: &Fitted) -> Option<[f64; 2]> {
        let there = fitted.on(&self.check)?;
        Some([fitted, &there].map(|fit| pooled_deviation(&fit.residuals).powi(2)))
    }

    /// The same of the given model.
    fn left_by_model(&self) -> Option<[f64; 2]> {
        let of = |traces: &[Trace<'_>]| Some(PlainFit::as_it_is(self.given, traces)?.residuals);
        Some([of(&self.fit)?, of(&self.check)?].map(|residuals| pooled_deviation(&residuals).powi(2)))
    }
}

/// Amplitude in each record.
fn amplitudes(lead: &Fitted) -> Vec<f64> {
    let place = 2 * lead.space.terms().take_while(|term| *term != MeasurementTerm::Chatter).count();
    lead.factors.iter().map(|factors| factors[place].hypot(factors[place + 1])).collect()
}

/// Whether a frequency is a multiple of that of the strongest line of the command.
fn is_harmonic(trace: &Trace<'_>, frequency_hz: f64) -> bool {
    let strongest = strongest_frequency_hz(&[without_mean(trace.record.command())], std::slice::from_ref(trace));
    let multiple = (frequency_hz / strongest).round();
    let width = HARMONIC_LINES / trace.record.duration_s();
    (1.0..=HIGHEST_HARMONIC).contains(&multiple) && (frequency_hz - multiple * strongest).abs() < width
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use crate::{
        diagnose::{
            Verdict,
            three_records::{behind_gear, measured_as, said, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::parameters::{Base, Model, table};

    #[test]
    #[ignore = "slow"]
    fn a_line_that_is_most_of_a_difference_leads_beside_an_error_that_nothing_explains_where_all_records_have_it_alike()
    {
        let given = Model::from_set(&table()[0]);
        let records: Vec<Record> =
            three_records_of(&given, 3.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
        let of = |amplitudes: [f64; 3], frequencies_hz: [f64; 3]| {
            let humming = |(record, (amplitude, frequency_hz)): (&Record, (f64, f64))| {
                // The records began at any time.
                let phase = record.command().iter().sum::<f64>();
                measured_as(record, |t, position| position + amplitude * (TAU * frequency_hz * t + phase).sin())
            };
            let each = amplitudes.into_iter().zip(frequencies_hz);
            said(&given, &records.iter().zip(each).map(humming).collect::<Vec<Record>>())
        };
        let (verdict, found) = of([0.3; 3], [7.3; 3]);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "chatter", "{verdict:?} {name}");
        assert!((values[0] - 0.3).abs() < 0.02 && (values[1] - 7.3).abs() < 0.01, "{values:?}");
        let nothing = (Verdict::Unexplained, None);
        assert_eq!(of([0.3, 0.1, 0.3], [7.3; 3]), nothing);
        assert_eq!(of([0.3; 3], [7.3, 7.3, 9.1]), nothing);
        assert_eq!(of([0.02; 3], [7.3; 3]), nothing);
    }

    #[test]
    #[ignore = "slow"]
    fn a_line_leads_whatever_is_wrong_with_the_base() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        // Further from the given one than a base is searched near it.
        let base = Base::from_values([0.9 * k, p, 0.4 * omega, zeta]).unwrap();
        let humming = |record: &Record| {
            let phase = record.command().iter().sum::<f64>();
            measured_as(&behind_gear(record, 0.0), |t, position| position + 0.6 * (TAU * 7.3 * t + phase).sin())
        };
        let records = three_records_of(&Model { base, ..given.clone() }, 3.0, 6.0);
        let (verdict, found) = said(&given, &records.iter().map(humming).collect::<Vec<Record>>());
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "chatter", "{verdict:?} {name}");
        assert!((values[0] - 0.6).abs() < 0.02 && (values[1] - 7.3).abs() < 0.01, "{values:?}");
    }
}
