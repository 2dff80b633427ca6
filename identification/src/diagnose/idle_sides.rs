//! Sides of a limit that no record shows: a search leaves them where they last acted on the motion, and no record determines them.

use super::{
    evidence::REQUIRED_BIC_LEAD, fitted::Fitted, outcome::Standing, past_stop::ends_short,
    selection::StructureSelection, space::Space, trace::Trace,
};
use actuator_fmu::{
    effects::{CHAIN, Effect, UNLIMITED},
    parameters::Model,
};

/// Sum of squares that one side explains on the fit or on the check records over that of the whole limit, at least, where a difference remains.
const LEAST_SHARE: f64 = 0.02;

/// The same on the fit and on the check records, where both show it.
const AGREED: f64 = 0.005;

/// Sum of squares that one side explains on the check records over that of the whole limit there, at least, for a side that the fit records do not
/// reach.
const CONFIRMED: f64 = 0.1;

/// Mean square that one side adds on the check records over that it explains on the fit records, at least, for them to contradict each other: any
/// increase is significant on many samples.
const CONTRADICTED: f64 = 0.1;

impl StructureSelection<'_> {
    /// An explanation without the sides of its limits that explain almost nothing on the fit records, unless check records confirm them, or clearly
    /// increase the residual on the check records, compared with what they explain. One side of each limit stays. A side that only check records reach
    /// stays where they show it clearly: it is where the fit records end.
    pub fn without_idle_sides(&self, found: &Fitted, standing: &Standing) -> Fitted {
        let two_sided = |effect: &&&Effect| {
            let is_limit =
                |place: usize| effect.parameters[place].decides && effect.parameters[place].neutral.abs() >= UNLIMITED;
            effect.parameters.len() == 2 && is_limit(0) && is_limit(1) && !self.is_given(effect.name)
        };
        let of_found = |effect: &&&Effect| found.space.hypothesis.effects.contains(&effect.name);
        CHAIN
            .iter()
            .filter(of_found)
            .filter(two_sided)
            .fold(found.clone(), |found, effect| self.without_idle_side(&found, effect, standing).unwrap_or(found))
    }

    /// Without the side of one limit that explains less, if it is idle.
    fn without_idle_side(&self, found: &Fitted, effect: &'static Effect, standing: &Standing) -> Option<Fitted> {
        let lifted = |sides: &[usize], traces: &[Trace<'_>]| {
            let mut values = found.model.effects.values_of(effect.name)?.to_vec();
            sides.iter().for_each(|side| values[*side] = effect.parameters[*side].neutral);
            let model = Model { effects: found.model.effects.with(effect, &values).ok()?, ..found.model.clone() };
            let (hypothesis, chatter_hz) = (found.space.hypothesis.clone(), found.space.chatter_hz(&found.x));
            Fitted::at_start(Space::new(hypothesis, &model, &self.given.base, chatter_hz), traces)
        };
        // Sum of squares that sides explain on some records; negative where they increase the residual.
        let taken = |sides: &[usize], traces: &[Trace<'_>]| {
            Some(squares(&lifted(sides, traces)?) - squares(&lifted(&[], traces)?))
        };
        let each = [0, 1].map(|side| Some((side, taken(&[side], &self.fit)?)));
        let (side, by_side) = each.into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let whole = |traces: &[Trace<'_>]| Some(taken(&[0, 1], traces)?.max(0.0));
        let [of_fit, of_check] = [whole(&self.fit)?, whole(&self.check)?];
        // Noise and rounding are no evidence for a side or against it.
        let weighs = |square: f64, traces: &[Trace<'_>], whole: f64| match standing {
            Standing::Adequate => {
                let left = squares(&lifted(&[], traces)?).max(f64::MIN_POSITIVE);
                Some(evaluated(traces) * (square / left).max(0.0).ln_1p() > REQUIRED_BIC_LEAD)
            }
            _ => Some(square > LEAST_SHARE * whole && square > 0.0),
        };
        let on_check = taken(&[side], &self.check)?;
        // Beyond what the fit records reach, a side costs next to nothing there.
        let is_beyond = by_side > -LEAST_SHARE * of_fit && on_check > CONFIRMED * of_check;
        let is_confirmed = (by_side > 0.0 || is_beyond) && weighs(on_check, &self.check, of_check)?;
        let remains = !matches!(standing, Standing::Adequate);
        let agree = remains && by_side > AGREED * of_fit && on_check > AGREED * of_check;
        let is_shown = weighs(by_side, &self.fit, of_fit)? || is_confirmed || agree;
        let is_contradicted = -on_check / evaluated(&self.check) > CONTRADICTED * by_side / evaluated(&self.fit);
        let is_idle = !is_shown || (is_contradicted && weighs(-on_check, &self.check, of_check)?);
        let is_idle = is_idle || (effect.name == "position_limit" && self.is_never_reached(found, side));
        let without = is_idle.then(|| lifted(&[side], &self.fit)).flatten()?;
        // Without the side, a model that goes too far for another reason may have a larger residual than the given one on an unseen record.
        let widens = self.widens_unseen(&without)? && !self.widens_unseen(found)?;
        (!widens).then_some(without)
    }

    /// Whether positions end short of a stop and stand at no other on that side: a model that goes too far put it there.
    fn is_never_reached(&self, found: &Fitted, side: usize) -> bool {
        let Some(&[min, max]) = found.model.effects.active_values_of("position_limit") else { return false };
        let value_of = |effect| found.model.effects.active_values_of(effect).map_or(0.0, |values| values[0]);
        let (bias, play) = (value_of("sensor_bias"), 0.5 * value_of("backlash"));
        let noise = self.noise.mean_squares();
        // What is behind the play is half a gap short of where the stop holds the drive.
        let [min, max] = [min + bias + play, max + bias - play];
        self.fit
            .iter()
            .chain(&self.check)
            .zip(noise)
            .all(|(trace, noise)| ends_short([min, max], trace.record.position(), noise.sqrt())[side])
            && !self.stand_at_stop(side)
    }
}

#[allow(clippy::cast_precision_loss)] // a count of samples
fn evaluated(traces: &[Trace<'_>]) -> f64 {
    traces.iter().map(Trace::evaluated_samples).sum::<usize>() as f64
}

/// Sum of squares of the residuals.
fn squares(fitted: &Fitted) -> f64 {
    fitted.residuals.iter().flatten().map(|left| left * left).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{hypothesis::Hypothesis, measured_noise::MeasuredNoise, three_records::three_records_of},
        progress::Work,
        signal::record::Record,
    };
    use actuator_fmu::{effects::find, parameters::table};

    /// Behind play of a third of the range between stops, no position comes as far as these.
    #[test]
    fn stops_in_front_of_play_stay() {
        let given = Model::from_set(&table()[0]);
        let play =
            |model: Model| Model { effects: model.effects.with(find("backlash").unwrap(), &[1.4]).unwrap(), ..model };
        let truth = play(limited([-2.0, 2.2]));
        let records = three_records_of(&truth, 4.0, 6.0);
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        let selection = StructureSelection::new(&given, &records[..2], &records[2..], noise, None, &work);
        let hypothesis = Hypothesis { effects: vec!["position_limit", "backlash"], ..Hypothesis::default() };
        let found = Fitted::at_start(Space::new(hypothesis, &truth, &given.base, 0.0), &selection.fit).unwrap();
        let kept = selection.without_idle_sides(&found, &Standing::Adequate);
        assert_eq!(kept.model.effects.active_values_of("position_limit"), Some([-2.0, 2.2].as_slice()));
    }

    /// The given model with stops.
    fn limited(stops: [f64; 2]) -> Model {
        let given = Model::from_set(&table()[0]);
        Model { effects: given.effects.with(find("position_limit").unwrap(), &stops).unwrap(), ..given }
    }

    fn highest(record: &Record) -> f64 {
        record.position().iter().fold(f64::NEG_INFINITY, |high, one| high.max(*one))
    }

    /// The stops that remain of those found, for three records of which the last one is unseen.
    fn kept(stops: [f64; 2], records: &[Record], standing: &Standing) -> [f64; 2] {
        let given = Model::from_set(&table()[0]);
        let (fit, check) = records.split_at(2);
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        let selection = StructureSelection::new(&given, fit, check, noise, None, &work);
        let hypothesis = Hypothesis { effects: vec!["position_limit"], ..Hypothesis::default() };
        let space = Space::new(hypothesis, &limited(stops), &given.base, 0.0);
        let found = Fitted::at_start(space, &selection.fit).unwrap();
        let kept = selection.without_idle_sides(&found, standing);
        kept.model.effects.active_values_of("position_limit").unwrap().try_into().unwrap()
    }

    /// The upper stop that remains of one found a fifth beyond it: for positions that a stop holds, and for those of an actuator that just does not
    /// reach it.
    #[test]
    fn a_side_at_which_positions_stand_stays_also_where_a_search_has_it_beyond_them() {
        let upper_of = |held: [f64; 2], amplitude: f64| {
            let leading = Standing::Leading { forms: Vec::new() };
            kept([-2.0, 2.6], &three_records_of(&limited(held), amplitude, 6.0), &leading)[1]
        };
        assert_eq!(upper_of([-2.0, 2.2], 4.0), 2.6);
        assert_eq!(upper_of([-2.0, UNLIMITED], 2.3), UNLIMITED);
    }

    /// A stop that the fit records reach on both sides, and a check record without noise that goes a little beyond one of them.
    #[test]
    fn a_side_that_explains_far_more_than_it_adds_elsewhere_stays() {
        const STOPS: [f64; 2] = [-2.2, 2.0];
        let lowest = |record: &Record| record.position().iter().fold(f64::INFINITY, |low: f64, one| low.min(*one));
        let mut records = three_records_of(&limited(STOPS), 4.0, 6.0);
        let reached = lowest(&three_records_of(&Model::from_set(&table()[0]), 1.0, 6.0)[2]);
        records[2] = three_records_of(&limited([-UNLIMITED, STOPS[1]]), -2.21 / reached, 6.0).swap_remove(2);
        assert!(lowest(&records[2]) < STOPS[0]);
        assert_eq!(kept(STOPS, &records, &Standing::Adequate), STOPS);
    }

    /// A stop that the fit records do not reach, found where they end, and a check record that ends there as well, or goes far beyond.
    #[test]
    fn a_side_beyond_the_fit_records_stays_where_check_records_show_it_clearly() {
        let free = three_records_of(&Model::from_set(&table()[0]), 4.0, 6.0);
        let stops = [-2.0, 1.02 * free[..2].iter().map(highest).fold(0.0, f64::max)];
        let leading = Standing::Leading { forms: Vec::new() };
        let upper_of = |amplitude: f64, standing: &Standing| {
            let mut records = three_records_of(&limited(stops), 4.0, 6.0);
            records[2] = three_records_of(&limited(stops), amplitude, 6.0).swap_remove(2);
            kept(stops, &records, standing)[1]
        };
        for standing in [&leading, &Standing::Adequate] {
            assert_eq!(upper_of(3.0, standing), UNLIMITED);
            assert_eq!(upper_of(10.0, standing), stops[1]);
        }
    }

    /// An upper stop that explains a thousandth of what both stops do, or a hundredth on the fit records and half of that on the check record.
    #[test]
    fn a_side_that_fit_and_check_records_show_alike_stays_beside_a_remaining_difference() {
        let free = three_records_of(&Model::from_set(&table()[0]), 4.0, 6.0);
        let top = free[..2].iter().map(highest).fold(0.0, f64::max);
        let amplitude = 4.2 * top / highest(&free[2]);
        let leading = Standing::Leading { forms: Vec::new() };
        let upper_of = |share: f64| {
            let stops = [-1.0, share * top];
            let mut records = three_records_of(&limited(stops), 4.0, 6.0);
            records[2] = three_records_of(&limited(stops), amplitude, 6.0).swap_remove(2);
            kept(stops, &records, &leading)[1]
        };
        assert_eq!(upper_of(0.95), UNLIMITED);
        assert_eq!(upper_of(0.85), 0.85 * top);
    }

    /// A stop that the fit records just reach, and a check record goes far beyond.
    #[test]
    fn a_side_that_fit_records_hardly_show_stays_where_check_records_confirm_it() {
        let free = three_records_of(&Model::from_set(&table()[0]), 4.0, 6.0);
        let stops = [-2.0, 0.99 * free[..2].iter().map(highest).fold(0.0, f64::max)];
        let leading = Standing::Leading { forms: Vec::new() };
        let upper_of = |amplitude: f64| {
            let mut records = three_records_of(&limited(stops), 4.0, 6.0);
            records[2] = three_records_of(&limited(stops), amplitude, 6.0).swap_remove(2);
            kept(stops, &records, &leading)[1]
        };
        assert_eq!(upper_of(2.0), UNLIMITED);
        assert_eq!(upper_of(8.0), stops[1]);
    }
}
