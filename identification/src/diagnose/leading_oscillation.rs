//! An oscillation that no command drives and that is most of the difference: hum, hunting, a limit cycle. It is one line in the spectrum of the
//! residual of any base, with one frequency in all records, so that it is identified whatever the structure of the actuator.

use std::f64::consts::TAU;

use super::{
    diagnosis::Lead,
    evidence::pooled_deviation,
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm, family},
    judgement::Judgement,
    linear_rival::{left_by_linear, left_by_linear_of},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    spectral_peak::strongest_frequency_hz,
    trace::{Trace, interval_s},
};
use crate::{
    linear_least_squares::subtract,
    signal::record::{rms, without_mean},
};
use actuator_fmu::parameters::Model;

pub const CHATTER: &str = "chatter";

/// Variance about the levels with an oscillation over that of the given model, at most, on fit and on check records; and that of any base over that
/// with the oscillation, at least.
const GREATEST_LEFT: f64 = 0.5;
const LEAST_LEFT_BY_BASE: f64 = 2.0;

/// Largest over smallest amplitude of the records: an oscillation caused by the motion differs with it.
const GREATEST_RATIO: f64 = 2.0;

/// Periods in the shortest record, at least.
const FEWEST_PERIODS: f64 = 4.0;
/// The same for a line beside which noise remains.
const FEWEST_PERIODS_BESIDE_NOISE: f64 = 3.0;

/// Highest harmonic of the command that is considered, and distance within which a line is such a harmonic, in lines of the record's spectrum.
const HIGHEST_HARMONIC: f64 = 9.0;
const HARMONIC_LINES: f64 = 2.0;
/// This distance over the spacing of the harmonics, at most, in a record that identifies one.
const MOST_OF_SPACING: f64 = 0.25;

/// Variance of an oscillation over the variance without it, at least, for it to be listed.
const LEAST_LISTED: f64 = 0.2;

/// Share of the variance of a line that a linear model of the command leaves, at least.
const LEAST_LEFT_BY_LINEAR: f64 = 0.5;

const ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// The oscillation that is most of the difference, in the given model, beside a base refitted near it, without or with the oscillation, or beside
    /// a free base, whose parameters do not affect it; none where there is none.
    ///
    /// # Errors
    /// An oscillation that is a lesser part, or hum in the recorded command, as a lead to be listed.
    pub fn oscillation(&self, judged: &Judgement, base: &Fitted) -> Option<Result<Fitted, Lead>> {
        if self.given.effects.active_values_of(CHATTER).is_some() || self.as_healthy().is_some() {
            return None;
        }
        let anywhere = self.base_of_its_own(judged)?;
        let levelled: Vec<Vec<f64>> = anywhere.residuals.iter().map(|left| without_mean(left)).collect();
        let frequency_hz = strongest_frequency_hz(&levelled, &self.fit);
        let space_of_base = Space::new(anywhere.space.hypothesis.clone(), &anywhere.model, &self.given.base, 0.0);
        let by_base = PlainFit::at_start(space_of_base.clone(), &self.check)?;
        let of_base = [&anywhere, &by_base].map(|fit| pooled_deviation(&fit.residuals).powi(2));
        let beside = |kind: Hypothesis, start: &Model| {
            let hypothesis = Hypothesis { effects: vec![CHATTER], ..kind };
            let space = Space::new(hypothesis, start, &self.given.base, frequency_hz);
            let space = if space.hypothesis.wide { space.within_sampling(interval_s(&self.fit)) } else { space };
            self.by_likelihood(PlainFit::search(space, &self.fit, ITERATIONS)?)
        };
        let leads = |line: Option<Fitted>| {
            line.filter(|line| {
                let is_told =
                    |left: [f64; 2]| left.iter().zip(of_base).all(|(left, base)| LEAST_LEFT_BY_BASE * left < base);
                self.left_by(line).is_some_and(is_told) && self.objection_to_oscillation(line, base).is_none()
            })
        };
        let near = Hypothesis { base_free: true, ..Hypothesis::default() };
        let leading = leads(beside(Hypothesis::default(), self.given))
            .or_else(|| leads(beside(Hypothesis::default(), &base.model)))
            .or_else(|| leads(beside(near, self.given)));
        if leading.is_some() {
            return leading.map(Ok);
        }
        let beside_own = beside(anywhere.space.hypothesis.clone(), &anywhere.model)?;
        let lesser = || self.hum_of_command(&beside_own).or_else(|| self.lesser_oscillation(&beside_own));
        leads(Some(beside_own.clone())).map(Ok).or_else(|| lesser().map(Err))
    }

    /// An oscillation that is a lesser part of the difference, as a lead to be listed: some share of the residual without it, on fit and on check
    /// records.
    #[allow(clippy::cast_precision_loss)] // counts of records
    pub fn lesser_oscillation(&self, line: &Fitted) -> Option<Lead> {
        let left = self.left_by(line)?;
        let there = line.on(&self.check)?;
        let amplitudes = [amplitudes(line), amplitudes(&there)];
        let variance = |amplitudes: &[f64]| {
            amplitudes.iter().map(|one| 0.5 * one * one).sum::<f64>() / amplitudes.len().max(1) as f64
        };
        let is_some = |(amplitudes, left): (&Vec<f64>, f64)| {
            let line = variance(amplitudes);
            line > LEAST_LISTED * (line + left)
        };
        if !amplitudes.iter().zip(left).all(is_some) || self.is_no_oscillation(line).is_some() {
            return None;
        }
        let [_, given] = self.left_by_model()?;
        let share = (variance(&amplitudes[1]) / given).min(1.0);
        let amplitude = amplitudes[0].iter().sum::<f64>() / amplitudes[0].len() as f64;
        Some(Lead {
            name: CHATTER,
            family: family(CHATTER),
            share: Some(share),
            nonlinear_share: None,
            check_rms: None,
            parameters: [("amplitude", amplitude), ("frequency", line.space.chatter_hz(&line.x))].into(),
            only_in: None,
            why_not: format!(
                "all records contain this line, which no command drives; it is {:.0} % of the variance of the difference",
                100.0 * share
            ),
        })
    }

    /// Why an oscillation does not lead; none where it does.
    pub fn objection_to_oscillation(&self, lead: &Fitted, base: &Fitted) -> Option<String> {
        let (Some(left), Some(before)) = (self.left_by(lead), self.left_by_model()) else {
            return Some("a model with it diverges".to_owned());
        };
        let by_base = self.left_by(base);
        let takes = |place: usize| {
            left[place] < GREATEST_LEFT * before[place]
                && by_base.is_none_or(|by_base| LEAST_LEFT_BY_BASE * left[place] < by_base[place])
        };
        if !takes(0) || !takes(1) {
            return Some("much of the difference remains, or hardly less than with another base alone".to_owned());
        }
        self.is_no_oscillation(lead)
    }

    /// Periods of a line in the shortest record.
    fn periods(&self, lead: &Fitted) -> f64 {
        let durations = self.fit.iter().chain(&self.check).map(|trace| trace.record.duration_s());
        lead.space.chatter_hz(&lead.x) * durations.fold(f64::INFINITY, f64::min)
    }

    /// Whether an explanation has a line so slow that it may as well be a drift, or a residual of the base.
    pub fn has_slow_line(&self, found: &Fitted) -> bool {
        found.space.hypothesis.effects.contains(&CHATTER) && self.periods(found) < FEWEST_PERIODS_BESIDE_NOISE
    }

    /// Why a line in the residual is no oscillation by itself; none where it is one.
    fn is_no_oscillation(&self, lead: &Fitted) -> Option<String> {
        if self.periods(lead) < FEWEST_PERIODS {
            return Some("it has too few periods in the shortest record: it may be a drift".to_owned());
        }
        let frequency_hz = lead.space.chatter_hz(&lead.x);
        let Some(there) = lead.on(&self.check) else { return Some("a model with it diverges".to_owned()) };
        let amplitudes: Vec<f64> = amplitudes(lead).into_iter().chain(amplitudes(&there)).collect();
        let (least, greatest) = amplitudes
            .iter()
            .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), one| (low.min(*one), high.max(*one)));
        if greatest > GREATEST_RATIO * least {
            return Some("its amplitude differs between records: it depends on the motion".to_owned());
        }
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let is_driven =
            traces.iter().all(|trace| is_harmonic(trace, frequency_hz)) || self.is_driven(lead, &there, &traces);
        is_driven
            .then(|| "the command drives it, or it is a harmonic of the command".to_owned())
            .or_else(|| self.hum_of_command(lead).map(|hum| hum.why_not))
    }

    /// Whether the command drives a line: removing the line from the positions reduces the residual of a linear model of the command by less than
    /// most of the line's variance.
    fn is_driven(&self, lead: &Fitted, there: &Fitted, traces: &[Trace<'_>]) -> bool {
        let records = lead.factors.iter().chain(&there.factors).zip(traces);
        let lines: Vec<Vec<f64>> = records.map(|(factors, trace)| line(lead, factors, trace)).collect();
        let omega = self.given.base.omega();
        let without = |(trace, line): (&Trace<'_>, &Vec<f64>)| {
            let mut position = trace.record.position()[trace.settling..].to_vec();
            subtract(&mut position, [line], &[1.0]);
            position
        };
        let without: Vec<Vec<f64>> = traces.iter().zip(&lines).map(without).collect();
        let sum = |left: Vec<f64>| left.iter().sum::<f64>();
        let taken = sum(left_by_linear(traces, omega)) - sum(left_by_linear_of(&without, traces, omega));
        taken < LEAST_LEFT_BY_LINEAR * lines.iter().map(|line| rms(line).powi(2)).sum::<f64>()
    }

    /// Variance of the residual of a fit about the levels, on the fit and on the check records.
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
    lead.factors.iter().map(|factors| phasor(lead, factors)).map(|[sine, cosine]| sine.hypot(cosine)).collect()
}

/// Factors of sine and cosine, among those of a record.
fn phasor(lead: &Fitted, factors: &[f64]) -> [f64; 2] {
    let place = 2 * lead.space.terms().take_while(|term| *term != MeasurementTerm::Chatter).count();
    [factors[place], factors[place + 1]]
}

/// The oscillation in a record, after the settling time.
fn line(lead: &Fitted, factors: &[f64], trace: &Trace<'_>) -> Vec<f64> {
    let [sine, cosine] = phasor(lead, factors);
    let time = trace.record.time();
    let phase = |t: &f64| TAU * lead.space.chatter_hz(&lead.x) * (t - time[0]);
    time[trace.settling..].iter().map(phase).map(|phase| sine * phase.sin() + cosine * phase.cos()).collect()
}

/// Whether a frequency is a multiple of that of the command's strongest line; false for a record too short to decide.
fn is_harmonic(trace: &Trace<'_>, frequency_hz: f64) -> bool {
    let strongest = strongest_frequency_hz(&[without_mean(trace.record.command())], std::slice::from_ref(trace));
    let multiple = (frequency_hz / strongest).round();
    let width = HARMONIC_LINES / trace.record.duration_s();
    (1.0..=HIGHEST_HARMONIC).contains(&multiple)
        && (frequency_hz - multiple * strongest).abs() < width
        && width < MOST_OF_SPACING * strongest
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use crate::{
        diagnose::{
            Verdict, diagnose,
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
                // The records began at unrelated times.
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
    fn a_line_that_is_a_lesser_part_is_listed() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        let base = Base::from_values([0.9 * k, p, omega, zeta]).unwrap();
        let records = three_records_of(&Model { base, ..given.clone() }, 3.0, 6.0);
        let listed = |amplitudes: [f64; 3]| {
            let humming = |(record, amplitude): (&Record, f64)| {
                let phase = record.command().iter().sum::<f64>();
                let hum = |t: f64| amplitude * (TAU * 7.3 * t + phase).sin();
                measured_as(&behind_gear(record, 0.0), |t, position| position + hum(t))
            };
            let records: Vec<Record> = records.iter().zip(amplitudes).map(humming).collect();
            let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
            assert_eq!(diagnosis.verdict, Verdict::Unexplained);
            diagnosis.leads.into_iter().find(|lead| lead.name == "chatter").map(|lead| lead.parameters)
        };
        let found = listed([0.05; 3]).unwrap();
        assert!((found["amplitude"] - 0.05).abs() < 0.005 && (found["frequency"] - 7.3).abs() < 0.01, "{found:?}");
        assert_eq!(listed([0.05, 0.0, 0.05]), None);
    }

    #[test]
    #[ignore = "slow"]
    fn a_line_leads_whatever_is_wrong_with_the_base() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        // Further from the given one than the near range of a base.
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
