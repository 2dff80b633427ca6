//! A stop that the measured positions show by themselves: wherever the model would go beyond a level, the position stands at it, whatever the command.
//!
//! What a stop leaves in a record goes on after the contact: a controller with integral action has wound up, and comes back late. No limit of the library
//! does that, so that on such an actuator the effect takes a smaller part of the difference than other leads have to. What the positions show is certain
//! all the same.

use super::{
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::{Hypothesis, family},
    outcome::{Form, Outcome, Standing},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    trace::Trace,
};
use crate::{
    digits::with_unit,
    signal::{play::range, record::rms},
};
use actuator_fmu::{effects::find, parameters::Model};

/// What positions that stand at a level can come from: a stop, or a command that is limited.
const LIMITS: [&str; 2] = ["position_limit", "command_limit"];

/// Half the width of the band in which a position stands, in standard deviations of the noise, and in half ranges of the positions at least.
const BAND_IN_NOISE: f64 = 4.0;
const BAND_IN_RANGE: f64 = 0.004;
/// Widths of that band by which a model is beyond a level.
const BEYOND: f64 = 2.0;
/// Of the samples in which the model is beyond the level, those in which the position stands there at least: in the others it is on its way.
const LEAST_HELD: f64 = 0.6;
/// Samples of a contact at least, and contacts on both sides together.
const FEWEST_SAMPLES: usize = 3;
const FEWEST_CONTACTS: usize = 3;
/// How much further the model goes beyond the level in one contact than in another, in widths of the band and in half ranges at least: a gain that is off,
/// or a command that comes to the same value each time, holds the model at one distance.
const SPREAD_IN_BANDS: f64 = 2.5;
const SPREAD_IN_RANGE: f64 = 0.03;
/// How far apart the levels of records are at most, in half ranges: sensors have an offset of the day.
const SAME_LEVEL: f64 = 0.1;
/// Share of the samples of a record that may lie beyond its level: spikes.
const SPIKES: f64 = 0.005;

/// Of the root mean square that the given model, a base refitted near it, and its own base without the stop leave of the fitted or of the check records, what
/// a model with the stop leaves at most.
const CLOSES: f64 = 0.95;
/// Root mean square that one of the limits leaves of the fitted records over that of the other, where both come as near.
const AS_NEAR: f64 = 1.1;

const ITERATIONS: usize = 12;

/// Of the half range of the positions, and in standard deviations of the noise, how far they end short of a stop that they never reach.
const SHORT_OF_HALF_RANGE: f64 = 0.03;
const SHORT_OF_NOISE: f64 = 5.0;

/// Stops that positions show.
struct Stop {
    /// As a lead to which a model comes nearer; none where no model with them does.
    form: Option<Form>,
    /// What the positions show.
    note: String,
    /// The same where there is no form.
    shown: Lead,
}

/// What positions show of one side.
struct Contact {
    /// Where they stand, towards that side.
    level: f64,
    /// How often.
    contacts: usize,
    /// Whether the model is further beyond the level in one contact than in another.
    is_whatever_the_command: bool,
}

/// Positions of a record towards one side.
struct Side {
    measured: Vec<f64>,
    simulated: Vec<f64>,
    band: f64,
}

/// Of the half range of the positions, and in standard deviations of the noise, how far these go beyond a stop that cannot be; and the share of the samples
/// of a record that do.
const BEYOND_OF_HALF_RANGE: f64 = 0.08;
const BEYOND_OF_NOISE: f64 = 5.0;
const BEYOND_SHARE: f64 = 0.02;

impl StructureSelection<'_> {
    /// That positions go beyond the stop of a lead: levels of the records, which no model has, may have put it there.
    pub fn passed_stop(&self, lead: &Fitted) -> Option<String> {
        let stop = lead.space.hypothesis.effects.contains(&LIMITS[0]);
        let &[min, max] = lead.model.effects.active_values_of(LIMITS[0]).filter(|_| stop)? else { return None };
        let bias = lead.model.effects.active_values_of("sensor_bias").map_or(0.0, |values| values[0]);
        let noise = self.noise.mean_squares();
        self.fit.iter().chain(&self.check).zip(noise).find_map(|(trace, noise)| {
            let share = share_beyond([min + bias, max + bias], trace.record.position(), noise.sqrt());
            (share > BEYOND_SHARE).then(|| {
                let record = trace.record.source().display();
                format!("{record} is beyond the stop for {:.0} % of its samples", 100.0 * share)
            })
        })
    }

    /// Whether positions stand at a stop towards the lower or the upper side.
    pub fn stand_at_stop(&self, side: usize) -> bool {
        self.contact_towards([-1.0, 1.0][side]).is_some_and(|contact| contact.is_whatever_the_command)
    }

    /// The stops that positions show, in the given model or beside a base refitted near it; none where they show none, or the model has a limit of this
    /// kind.
    fn leading_stop(&self, base: &Fitted) -> Option<Stop> {
        let has_limit = LIMITS.iter().any(|limit| self.given.effects.active_values_of(limit).is_some());
        if has_limit || self.as_healthy().is_some() {
            return None;
        }
        let sides = [-1.0, 1.0].map(|sign| self.contact_towards(sign));
        let contacts: usize = sides.iter().flatten().map(|side| side.contacts).sum();
        if contacts < FEWEST_CONTACTS || !sides.iter().flatten().any(|side| side.is_whatever_the_command) {
            return None;
        }
        let levels = [-1.0, 1.0].iter().zip(&sides).map(|(sign, side)| side.as_ref().map(|side| sign * side.level));
        let levels: Vec<Option<f64>> = levels.collect();
        let form = self.at_levels(self.given, &levels, base).or_else(|| {
            let stop = self.with_limit(self.given, LIMITS[0], &levels)?;
            let beside = Hypothesis { base_free: true, ..Hypothesis::default() };
            let beside = Space::new(beside, &stop, &self.given.base, 0.0);
            self.at_levels(&PlainFit::search(beside, &self.fit, ITERATIONS)?.model, &levels, base)
        });
        let parameters = find(LIMITS[0]).map_or(&[][..], |stop| stop.parameters).iter().map(|parameter| parameter.name);
        let shown = Lead {
            name: LIMITS[0],
            family: family(LIMITS[0]),
            share: None,
            nonlinear_share: None,
            check_rms: None,
            parameters: parameters.zip(&levels).filter_map(|(name, level)| Some((name, (*level)?))).collect(),
            only_in: None,
            why_not: format!(
                "the position stands there in {contacts} contacts, however far the model goes beyond, but a model with it leaves hardly less, or more of \
                 some record, as where a controller with integral action comes back late from a stop"
            ),
        };
        let unit = self.given.unit().name();
        let at: Vec<String> = levels.iter().flatten().map(|level| with_unit(*level, 4, unit)).collect();
        let note = format!(
            "the position stands at {} in {contacts} contacts, however far the model goes beyond: a stop. What follows a contact may be another matter: \
             a controller with integral action winds up there",
            at.join(" and at ")
        );
        Some(Stop { form, note, shown })
    }

    /// An outcome that explains nothing, with the stops that these records show.
    pub fn with_stop(&self, mut outcome: Outcome) -> Outcome {
        let stop = if outcome.is_unexplained() { self.leading_stop(&outcome.base) } else { None };
        // Of parts of the records they may have been told before.
        outcome.shown.retain(|lead| lead.name != LIMITS[0]);
        let Some(Stop { form, note, shown }) = stop else { return outcome };
        let Some(form) = form else {
            outcome.shown.push(shown);
            return outcome;
        };
        let Some((misfit, predictable)) = self.misfit(&form.fitted).zip(self.predictable(&form.fitted)) else {
            return outcome;
        };
        let (explanation, note) = (Some(form.fitted.clone()), Some(note));
        Outcome { explanation, standing: Standing::Leading { forms: vec![form] }, misfit, predictable, note, ..outcome }
    }

    /// The limit that leaves less of the fitted records, in a model, and the other one where it comes as near; none where neither closes anything.
    fn at_levels(&self, model: &Model, levels: &[Option<f64>], base: &Fitted) -> Option<Form> {
        let base_free = model.base != self.given.base;
        let leads = LIMITS.into_iter().filter_map(|limit| {
            let with = self.with_limit(model, limit, levels)?;
            let hypothesis = Hypothesis { effects: vec![limit], base_free, ..Hypothesis::default() };
            let lead = Fitted::at_start(Space::new(hypothesis, &with, &self.given.base, 0.0), &self.fit)?;
            let is_sound = lead.space.is_plausible(&lead.model) && !lead.space.is_base_at_bound(&lead.x);
            (is_sound && self.closes_and_widens_nothing(&lead, base)?).then_some(lead)
        });
        let mut leads: Vec<Fitted> = leads.collect();
        let least = leads.iter().map(Fitted::rms).fold(f64::INFINITY, f64::min);
        leads.retain(|lead| lead.rms() < AS_NEAR * least);
        let others = leads.iter().skip(1).flat_map(|other| &other.space.hypothesis.effects);
        let alternatives = others.map(|limit| (*limit).to_owned()).collect();
        Some(Form { fitted: leads.first()?.clone(), alternatives })
    }

    /// A model with a limit where positions stand: of a command, where the steady position is that.
    fn with_limit(&self, model: &Model, limit: &str, levels: &[Option<f64>]) -> Option<Model> {
        let limit = find(limit)?;
        let scale = if limit.name == LIMITS[0] { 1.0 } else { model.base.k() };
        let values = levels.iter().zip(limit.parameters);
        let values: Vec<f64> =
            values.map(|(level, parameter)| level.map_or(parameter.neutral, |level| level / scale)).collect();
        Some(Model { effects: self.given.effects.with(limit, &values).ok()?, ..model.clone() })
    }

    /// Whether a lead leaves clearly less of the fitted or of the check records than a base without it, and no record with more than the given model.
    fn closes_and_widens_nothing(&self, lead: &Fitted, base: &Fitted) -> Option<bool> {
        let unlimited = Model { effects: self.given.effects.clone(), ..lead.model.clone() };
        let mut closes = false;
        for traces in [&self.fit, &self.check] {
            let (before, after) = (PlainFit::as_it_is(self.given, traces)?, PlainFit::as_it_is(&lead.model, traces)?);
            for ((trace, before), after) in traces.iter().zip(&before.residuals).zip(&after.residuals) {
                if self.leaves_more(lead, [rms(after), rms(before)], std::slice::from_ref(trace))? {
                    return Some(false);
                }
            }
            let others = [&base.model, &unlimited].map(|model| Some(PlainFit::as_it_is(model, traces)?.mean_square()));
            let least = others.into_iter().try_fold(before.mean_square(), |least, other| Some(least.min(other?)))?;
            closes |= after.mean_square() < CLOSES.powi(2) * least;
        }
        Some(closes)
    }

    /// Where positions of the fitted records stand on one side, as all records tell it; none where they do not, or go further in some record.
    #[allow(clippy::cast_precision_loss)] // a count of records
    fn contact_towards(&self, sign: f64) -> Option<Contact> {
        let traces = || self.fit.iter().chain(&self.check);
        let positions = || traces().flat_map(|trace| trace.record.position());
        let (least, greatest) =
            positions().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| (low.min(*one), high.max(*one)));
        let half_range = 0.5 * (greatest - least);
        let side = |(trace, noise): (&Trace<'_>, f64)| {
            let towards = |values: &[f64]| -> Vec<f64> {
                let counted = trace.where_measured(values[trace.settling..].to_vec());
                counted.into_iter().map(|value| sign * value).collect()
            };
            let simulated = towards(&trace.position(self.given)?);
            let band = (BAND_IN_NOISE * noise).max(BAND_IN_RANGE * half_range);
            Some(Side { measured: towards(trace.record.position()), simulated, band })
        };
        let noise = self.noise.records.iter().map(|noise| noise.rms);
        let sides: Vec<Side> = traces().zip(noise).map(side).collect::<Option<_>>()?;
        let each: Vec<Option<(f64, Vec<f64>)>> = sides.iter().map(Side::contacts).collect();
        // Check records show it as well, and do not decide where it is.
        let levels: Vec<f64> = each[..self.fit.len()].iter().flatten().map(|(level, _)| *level).collect();
        let level = levels.iter().sum::<f64>() / levels.len() as f64;
        let furthest_apart = SAME_LEVEL * half_range;
        let is_one_level = each.iter().flatten().all(|(other, _)| (other - level).abs() < furthest_apart);
        let is_exceeded = sides.iter().any(|side| side.highest() > level + furthest_apart);
        if levels.is_empty() || !is_one_level || is_exceeded {
            return None;
        }
        let distances: Vec<f64> = each.into_iter().flatten().flat_map(|(_, distances)| distances).collect();
        let (nearest, furthest) =
            distances.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), one| (low.min(*one), high.max(*one)));
        let widest = sides.iter().map(|side| side.band).fold(0.0, f64::max);
        let is_whatever_the_command = furthest - nearest > (SPREAD_IN_BANDS * widest).max(SPREAD_IN_RANGE * half_range);
        Some(Contact { level, contacts: distances.len(), is_whatever_the_command })
    }
}

impl Side {
    /// The highest position but for spikes.
    fn highest(&self) -> f64 {
        quantile(self.measured.clone(), 1.0 - SPIKES)
    }

    /// The level at which the position stands where the model is beyond it, and how far that is on average in each contact; none where the model hardly
    /// goes there, or the position does not stand.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    fn contacts(&self) -> Option<(f64, Vec<f64>)> {
        let highest = self.highest();
        let near = |position: &&f64| (*position - highest).abs() <= 2.0 * self.band;
        let level = quantile(self.measured.iter().filter(near).copied().collect(), 0.5);
        let pairs: Vec<(f64, f64)> = self.measured.iter().copied().zip(self.simulated.iter().copied()).collect();
        let is_free = |(measured, _): &&(f64, f64)| *measured < level - 2.0 * self.band;
        let [gain, offset] = straight_line(pairs.iter().filter(is_free).copied())?;
        let distance = |(_, simulated): &(f64, f64)| offset + gain * simulated - level;
        let is_beyond = |pair: &(f64, f64)| distance(pair) > BEYOND * self.band;
        let stands = |pair: &(f64, f64)| is_beyond(pair) && (pair.0 - level).abs() <= self.band;
        let count = |is: &dyn Fn(&(f64, f64)) -> bool| pairs.iter().filter(|pair| is(pair)).count() as f64;
        let runs = pairs.chunk_by(|one, next| stands(one) == stands(next));
        let contacts = runs.filter(|run| run.len() >= FEWEST_SAMPLES && stands(&run[0]));
        let distances: Vec<f64> =
            contacts.map(|run| run.iter().map(distance).sum::<f64>() / run.len() as f64).collect();
        let is_stop = !distances.is_empty() && count(&stands) >= LEAST_HELD * count(&is_beyond);
        is_stop.then_some((level, distances))
    }
}

/// Slope and offset of measured over simulated positions, by least squares; none where these stand still.
#[allow(clippy::cast_precision_loss)] // a count of samples
fn straight_line(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Option<[f64; 2]> {
    let count = pairs.clone().count() as f64;
    let mean = |of: fn((f64, f64)) -> f64| pairs.clone().map(of).sum::<f64>() / count;
    let (measured, simulated) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let (square, product) = (mean(|pair| pair.1 * pair.1), mean(|pair| pair.0 * pair.1));
    let gain = (product - measured * simulated) / (square - simulated * simulated);
    gain.is_finite().then_some([gain, measured - gain * simulated])
}

/// The value below which a share of some values lies; not a number where there are none.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a share of a count
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (share * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}

/// Share of the samples that are clearly beyond stops.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn share_beyond([min, max]: [f64; 2], position: &[f64], noise_rms: f64) -> f64 {
    let (low, high) = range(position);
    let beyond = (BEYOND_OF_HALF_RANGE * 0.5 * (high - low)).max(BEYOND_OF_NOISE * noise_rms);
    let passes = |value: &&f64| !(min - beyond..=max + beyond).contains(*value);
    position.iter().filter(passes).count() as f64 / position.len().max(1) as f64
}

/// Whether positions end clearly short of the lower and of the upper stop.
pub fn ends_short([min, max]: [f64; 2], position: &[f64], noise_rms: f64) -> [bool; 2] {
    let (low, high) = range(position);
    let short = (SHORT_OF_HALF_RANGE * 0.5 * (high - low)).max(SHORT_OF_NOISE * noise_rms);
    [low - min > short, max - high > short]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_tell_whether_they_go_beyond_a_stop_or_end_short_of_it() {
        let motion: Vec<f64> = (0..1000).map(|n| 10.0 * (0.02 * f64::from(n)).sin()).collect();
        let stopped: Vec<f64> = motion.iter().map(|value| value.min(9.0)).collect();
        assert_eq!(share_beyond([-1e9, 9.0], &stopped, 0.01), 0.0);
        // Within eight hundredths of the half range, or five times the noise.
        assert_eq!([share_beyond([-1e9, 8.3], &stopped, 0.01), share_beyond([-1e9, 7.6], &stopped, 0.3)], [0.0, 0.0]);
        assert!(share_beyond([-1e9, 8.0], &stopped, 0.01) > 0.15);
        assert_eq!(ends_short([-10.5, 9.0], &stopped, 0.01), [true, false]);
        assert_eq!(ends_short([-10.2, 9.2], &stopped, 0.01), [false, false]);
        assert_eq!(ends_short([-10.5, 9.2], &stopped, 0.2), [false, false]);
    }
    use crate::{
        diagnose::{
            Verdict, diagnose,
            three_records::{measured_as, said, three_records},
        },
        signal::record::Record,
    };
    use actuator_fmu::parameters::{PositionUnit, table};

    /// A motor of first order under proportional and integral control, that runs against stops: by Euler's method, a hundred steps a sample.
    fn under_integral_control(command: &[f64], interval_s: f64, integral_gain: f64, stops: [f64; 2]) -> Vec<f64> {
        let [proportional, lag_s] = [25.0, 0.01];
        let step = interval_s / 100.0;
        let (mut position, mut rate, mut integral) = (0.0_f64, 0.0, 0.0);
        let sample = |command: &f64| {
            let before = position;
            for _ in 0..100 {
                let error = command - position;
                integral += integral_gain * error * step;
                rate += (proportional * (error + integral) - rate) / lag_s * step;
                position += rate * step;
                if position <= stops[0] || position >= stops[1] {
                    (position, rate) = (position.clamp(stops[0], stops[1]), 0.0);
                }
            }
            before
        };
        command.iter().map(sample).collect()
    }

    /// The given model and three records of such a motor.
    fn wound_up(integral_gain: f64, stops: [f64; 2]) -> (Model, Vec<Record>) {
        let base = actuator_fmu::parameters::Base::from_values([1.0, 1e4, 50.0, 1.0]).unwrap();
        let given = Model { base, ..Model::from_set(&table()[0]) };
        let records = three_records(&given, 10.0);
        let records = records.iter().map(|record| {
            let noise: Vec<f64> = record.position().iter().map(|z| 0.02 * (1e4 * z).sin()).collect();
            let interval_s = record.sampling().interval_s();
            let moved = under_integral_control(record.command(), interval_s, integral_gain, stops);
            let position = moved.iter().zip(noise).map(|(position, noise)| position + noise).collect();
            Record::new(record.to_command(), position, PositionUnit::default(), record.interpolation(), "wound up")
                .unwrap()
        });
        let records = records.collect();
        (given, records)
    }

    #[test]
    #[ignore = "slow"]
    fn a_stop_leads_though_the_controller_winds_up_at_it_and_that_leaves_most_of_the_difference() {
        let of = |stops: [f64; 2]| {
            let (given, records) = wound_up(15.0, stops);
            said(&given, &records)
        };
        let (verdict, found) = of([-4.0, 5.0]);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "position_limit", "{verdict:?} {name}");
        assert!((values[0] + 4.0).abs() < 0.05 && (values[1] - 5.0).abs() < 0.05, "{values:?}");
        let (verdict, found) = of([-1e9, 1e9]);
        assert_eq!((verdict, found), (Verdict::Unexplained, None));
    }

    /// As of references that were set anew for each record.
    #[test]
    #[ignore = "slow"]
    fn a_stop_leads_where_its_level_is_off_by_what_the_zeros_of_the_records_are() {
        let (given, records) = wound_up(15.0, [-4.0, 5.0]);
        let of = |zeros: [f64; 3]| {
            let each = records.iter().zip(zeros);
            let anew: Vec<Record> =
                each.map(|(record, zero)| measured_as(record, |_, position| position + zero)).collect();
            said(&given, &anew)
        };
        let (verdict, found) = of([0.35, -0.2, 0.1]);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "position_limit", "{verdict:?} {name}");
        assert!((values[0] + 4.0).abs() < 0.3 && (values[1] - 5.0).abs() < 0.3, "{values:?}");
        assert_eq!(of([1.0, -1.0, 0.0]).1, None);
    }

    #[test]
    #[ignore = "slow"]
    fn a_stop_that_positions_show_is_listed_where_winding_up_leaves_no_model_with_less() {
        let (given, records) = wound_up(60.0, [-8.0, 8.5]);
        let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
        let lead = diagnosis.leads.iter().find(|lead| lead.name == "position_limit").unwrap();
        assert!(diagnosis.verdict == Verdict::Unexplained && lead.share.is_none(), "{:?} {lead:?}", diagnosis.verdict);
        let [min, max] = ["min", "max"].map(|side| lead.parameters[side]);
        assert!((min + 8.0).abs() < 0.05 && (max - 8.5).abs() < 0.05, "{min} {max}");
    }

    fn side(of: impl Fn(f64) -> [f64; 2]) -> Option<(f64, Vec<f64>)> {
        let pairs: Vec<[f64; 2]> = (0..2000).map(|n| of(0.01 * f64::from(n))).collect();
        let [measured, simulated] = [0, 1].map(|place| pairs.iter().map(|pair| pair[place]).collect());
        Side { measured, simulated, band: 0.02 }.contacts()
    }

    #[test]
    fn a_position_stands_where_more_is_asked_for_and_not_where_gain_or_lag_are_off() {
        let wave = |t: f64| 5.0 * t.sin() + 2.0 * (0.37 * t).sin();
        let (level, distances) = side(|t| [wave(t).min(4.0), wave(t)]).unwrap();
        assert!((level - 4.0).abs() < 1e-9 && distances.len() == 3, "{level} {distances:?}");
        // The gain of the model does not matter.
        let (level, scaled) = side(|t| [wave(t).min(4.0), 0.7 * wave(t)]).unwrap();
        assert!((level - 4.0).abs() < 1e-9 && scaled.len() == 3, "{level} {scaled:?}");
        for (distance, of_scaled) in distances.iter().zip(&scaled) {
            assert!((distance - of_scaled).abs() < 1e-6, "{distances:?} {scaled:?}");
        }
        assert!(side(|t| [0.9 * wave(t), wave(t)]).is_none());
        assert!(side(|t| [wave(t - 0.2), wave(t)]).is_none());
    }
}
