//! A lag: a delay beside the given base explains nearly all of the difference, and so does a base near the given one. The records do not distinguish
//! them, but show that it is one of their family. Neither explains a sensor that is far slower than the actuator; a `sensor_lag` does.

use super::{
    fitted::Fitted,
    hypothesis::{DELAY, Hypothesis, PARAMETER_SHIFT, SENSOR_LAG},
    judgement::Judgement,
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    trace::Trace,
    unseen::{excess, sample_counts},
};
use actuator_fmu::{effects::find, parameters::Model};

/// Excess of a lag over that of the given model, at most, on fit and on check records.
const GREATEST_LEFT: f64 = 0.25;

/// Mean square of a delay, with one free parameter, over that of a base, with four, at most, for the delay to lead.
const DELAY_OVER_BASE: f64 = 1.5;

/// g below which an effect explains a small part of the difference.
const SMALL_PART: f64 = 0.25;

/// `GREATEST_LEFT` for the lag of a sensor.
const LEFT_BY_SENSOR: f64 = 0.1;
/// Mean square with that lag over that of the given model, at most, on fit and on check records.
const MOST_LEFT: f64 = 0.5;
/// Start values of its time constant, in time constants 1/ω.
const STARTS: [f64; 4] = [0.5, 2.0, 8.0, 32.0];

/// Time constant over the duration of the shortest record, at most.
const LONGEST_LAG: f64 = 0.25;

const ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// A delay, a base or the lag of a sensor, with the members of the family that the records do not distinguish from it; none where check records
    /// do not show it.
    pub fn leading_lag(&self, judged: &Judgement) -> Option<(Fitted, Vec<String>)> {
        self.delay_or_base(judged).or_else(|| self.slow_sensor())
    }

    /// The lag of a sensor beside the given base, where it explains nearly all of the difference on fit and on check records. A pole of the base may
    /// have become as slow instead.
    fn slow_sensor(&self) -> Option<(Fitted, Vec<String>)> {
        let lag = find(SENSOR_LAG).filter(|lag| self.as_healthy().is_none() && !self.is_given(lag.name))?;
        let hypothesis = Hypothesis { effects: vec![lag.name], wide: true, ..Hypothesis::default() };
        let spaces = STARTS.iter().filter_map(|start| {
            let effects = self.given.effects.with(lag, &[start / self.given.base.omega()]).ok()?;
            Some(Space::new(hypothesis.clone(), &Model { effects, ..self.given.clone() }, &self.given.base, 0.0))
        });
        let found = PlainFit::search_from_nearest(spaces, &self.fit, ITERATIONS)?;
        let is_all = |lead: &Fitted| self.left_by_lag(lead).is_some_and(|left| left < LEFT_BY_SENSOR);
        // Where the difference is mainly rounding or noise, nothing explains much of it.
        let is_much = |lead: &Fitted| {
            [&self.fit, &self.check].into_iter().all(|traces| {
                let left = |model: &Model| PlainFit::as_it_is(model, traces).map(|fit| fit.mean_square());
                left(&lead.model).zip(left(self.given)).is_some_and(|(after, given)| after < MOST_LEFT * given)
            })
        };
        // A response that takes longer than the record is a change of gain.
        let shortest = self.fit.iter().chain(&self.check).map(|trace| trace.record.duration_s());
        let longest = LONGEST_LAG * shortest.fold(f64::INFINITY, f64::min);
        let is_seen = |lead: &Fitted| lead.model.effects.values_of(lag.name).is_some_and(|values| values[0] < longest);
        let lead = self.by_likelihood(found).filter(|lead| is_seen(lead) && is_all(lead) && is_much(lead))?;
        Some((lead, vec![PARAMETER_SHIFT.to_owned()]))
    }

    /// The delay beside the given base, or the near base where its residual is far smaller; none where neither holds.
    fn delay_or_base(&self, judged: &Judgement) -> Option<(Fitted, Vec<String>)> {
        let (delay, near) = judged.delay.as_ref().zip(judged.base_as_late.as_ref())?;
        let refitted = |fit: &PlainFit| {
            let refitted = PlainFit::search_from(fit.space.clone(), &fit.x, &self.fit, ITERATIONS)?;
            self.by_likelihood(refitted)
        };
        let stands = |lead: &Fitted| self.as_healthy().is_none() && self.objection_to_lag(lead).is_none();
        let late = refitted(&delay.fit).filter(stands);
        let is_inside = |shifted: &Fitted| !shifted.space.is_base_at_bound(&shifted.x);
        let shifted = refitted(near).filter(|shifted| is_inside(shifted) && stands(shifted));
        let left = |lead: &Fitted| Some(PlainFit::as_it_is(&lead.model, &self.fit)?.mean_square());
        let is_late = |late: &Fitted, shifted: &Fitted| {
            left(late).zip(left(shifted)).is_some_and(|(late, shifted)| late < DELAY_OVER_BASE * shifted)
        };
        let (lead, other) = match (late, shifted) {
            (Some(late), Some(shifted)) if !is_late(&late, &shifted) => (shifted, DELAY),
            (Some(late), _) => (late, PARAMETER_SHIFT),
            (None, Some(shifted)) => (shifted, DELAY),
            (None, None) => return None,
        };
        Some((lead, [other, SENSOR_LAG].map(str::to_owned).to_vec()))
    }

    /// The same instead of a lead that explains a small part of the difference.
    pub fn lag_instead_of(&self, lead: &Fitted, judged: &Judgement) -> Option<(Fitted, Vec<String>)> {
        let is_small = |effect: &str| judged.judged.iter().any(|own| own.effect == effect && own.part < SMALL_PART);
        let is_small = lead.space.hypothesis.effects.last().is_some_and(|effect| is_small(effect));
        is_small.then(|| self.leading_lag(judged)).flatten()
    }

    /// Why a delay or a shifted base does not lead as one of its family; none where it does.
    pub fn objection_to_lag(&self, lead: &Fitted) -> Option<String> {
        let is_lag = self.left_by_lag(lead).is_some_and(|left| left < GREATEST_LEFT);
        (!is_lag).then(|| {
            "much of the difference remains on the fit or the check records, or a record gets worse".to_owned()
        })
    }

    /// Excess of a lag over that of the given model, the larger of the shares on the fit and on the check records; 1 where the residual of any record
    /// increases.
    fn left_by_lag(&self, lead: &Fitted) -> Option<f64> {
        let noise = self.noise.mean_squares();
        let (fitted, checked) = noise.split_at(self.fit.len().min(noise.len()));
        let left = |traces: &[Trace<'_>], noise: &[f64]| {
            let [given, after] = [self.given, &lead.model].map(|model| PlainFit::as_it_is(model, traces));
            let (given, after) = (given?, after?);
            let grows = after.mean_squares().iter().zip(given.mean_squares()).any(|(after, given)| *after > given);
            let counts = sample_counts(&given);
            let [given, after] = [given, after].map(|fit| excess(&fit.mean_squares(), noise, &counts));
            Some(if grows { 1.0 } else { after.max(0.0) / given.max(f64::MIN_POSITIVE) })
        };
        Some(left(&self.fit, fitted)?.max(left(&self.check, checked)?))
    }
}

/// Whether a lead is of the lag family, and the records do not distinguish it from a delay or a shifted base.
pub fn is_delay_or_base(lead: &Fitted, alternatives: &[String]) -> bool {
    lead.space.hypothesis.family() == "lag" && alternatives.iter().any(|name| name == DELAY || name == PARAMETER_SHIFT)
}

#[cfg(test)]
mod tests {
    use crate::{
        diagnose::{
            Verdict,
            three_records::{behind_gear, said, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, table},
    };

    #[test]
    #[ignore = "slow"]
    fn a_small_part_does_not_lead_before_the_lag_that_is_most_of_it() {
        let given = Model::from_set(&table()[0]);
        let of = |effects: Effects, name: &str, values: &[f64]| effects.with(find(name).unwrap(), values).unwrap();
        let late = of(Effects::default(), "delay", &[0.05]);
        let truth = Model { effects: of(late, "command_rate_limit", &[80.0, 80.0]), ..given.clone() };
        let records: Vec<Record> =
            three_records_of(&truth, 3.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
        let (verdict, found) = said(&given, &records);
        let (name, values, others) = found.unwrap();
        // The limit adds to the delay.
        assert!(
            verdict == Verdict::Leading && name == "delay" && (0.05..0.0625).contains(&values[0]),
            "{name} {values:?}"
        );
        assert_eq!(others, ["parameter_shift", "sensor_lag"]);
    }

    #[test]
    #[ignore = "slow"]
    fn a_slower_sensor_is_a_lag_or_another_base_beside_an_error_that_nothing_explains() {
        let given = Model::from_set(&table()[0]);
        let of = |time_s: f64| {
            let lag = find("sensor_lag").unwrap();
            let truth = Model { effects: Effects::default().with(lag, &[time_s]).unwrap(), ..given.clone() };
            let records: Vec<Record> =
                three_records_of(&truth, 3.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
            let (verdict, found) = said(&given, &records);
            let mut names = found.map_or_else(Vec::new, |(name, _, others)| [vec![name.to_owned()], others].concat());
            names.sort();
            (verdict, names)
        };
        let family = ["delay", "parameter_shift", "sensor_lag"].map(str::to_owned).to_vec();
        assert_eq!(of(0.01), (Verdict::Leading, family));
        assert_eq!(of(1e-4), (Verdict::Unexplained, Vec::new()));
    }

    /// A base near the given one explains nine tenths of a delay of 2.5 or 4 ms: too much for the delay to lead alone, but its residual is larger
    /// than that of the delay.
    #[test]
    #[ignore = "slow"]
    fn a_delay_leads_of_which_a_shifted_base_takes_nearly_all() {
        let given = Model::from_set(&table()[0]);
        for late_s in [0.0025, 0.004] {
            let effects = Effects::default().with(find("delay").unwrap(), &[late_s]).unwrap();
            let truth = Model { effects, ..given.clone() };
            let records: Vec<Record> =
                three_records_of(&truth, 3.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
            let (verdict, found) = said(&given, &records);
            let (name, values, others) = found.unwrap_or_else(|| panic!("{late_s}: {verdict:?}"));
            let is_right = verdict == Verdict::Leading && name == "delay" && (values[0] / late_s - 1.0).abs() < 0.05;
            assert!(is_right, "{late_s}: {verdict:?} {name} {values:?}");
            assert_eq!(others, ["parameter_shift", "sensor_lag"]);
        }
    }

    /// Given models with a delay of practically zero, as fits may end with, and with that of the actuator before the change.
    #[test]
    #[ignore = "slow"]
    fn a_delay_that_came_leads_also_where_the_given_model_has_one() {
        let of = |late_s: f64| {
            let effects = Effects::default().with(find("delay").unwrap(), &[late_s]).unwrap();
            Model { effects, ..Model::from_set(&table()[0]) }
        };
        for before_s in [1e-17, 0.01] {
            let (given, truth) = (of(before_s), of(before_s + 0.03));
            let records: Vec<Record> =
                three_records_of(&truth, 3.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
            let (verdict, found) = said(&given, &records);
            let (name, values, _) = found.unwrap_or_else(|| panic!("{before_s}: {verdict:?}"));
            let is_right = (values[0] / (before_s + 0.03) - 1.0).abs() < 0.05;
            assert!(verdict == Verdict::Leading && name == "delay" && is_right, "{before_s}: {name} {values:?}");
        }
    }

    /// Neither a delay nor a base near the given one explains a lag of several time constants of the actuator.
    #[test]
    #[ignore = "slow"]
    fn a_sensor_that_is_slower_than_the_actuator_is_a_lag() {
        let given = Model::from_set(&table()[0]);
        for time_s in [0.04, 0.16] {
            let lag = find("sensor_lag").unwrap();
            let truth = Model { effects: Effects::default().with(lag, &[time_s]).unwrap(), ..given.clone() };
            let records: Vec<Record> =
                three_records_of(&truth, 3.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
            let (verdict, found) = said(&given, &records);
            let (name, values, others) = found.unwrap_or_else(|| panic!("{time_s}: {verdict:?}"));
            let is_right = (values[0] / time_s - 1.0).abs() < 0.05;
            assert!(verdict == Verdict::Leading && name == lag.name && is_right, "{time_s}: {name} {values:?}");
            assert_eq!(others, ["parameter_shift"]);
        }
    }
}
