//! Whether an explanation is adequate: its residual is noise and its parameters are plausible for such an actuator.

use super::{
    evidence::{RIVAL_BIC_RANGE, pooled_deviation},
    fitted::Fitted,
    hypothesis::MeasurementTerm,
    late,
    notes::coloured,
    predictable::{ADEQUATE_SHARE, NOISE_SHARE, Predictable, predictable},
    selection::StructureSelection,
    steady_level::is_steady,
    trace::Trace,
};
use crate::inspect::deviation;

/// Deviation of the residual of one record over that of another, at least, for a rest that changes slowly not to be noise of the sensor.
const UNEVEN: f64 = 1.5;
/// Mean square beside an effect over that of the given model, about the levels, above which the effect explains the smaller part.
const SMALLER_PART: f64 = 0.5;

impl StructureSelection<'_> {
    /// Whether an explanation, or the base where there is none, is adequate.
    pub fn is_adequate(&self, explanation: Option<&Fitted>, base: &Fitted) -> bool {
        let current = explanation.unwrap_or(base);
        let most = if explanation.is_some() { ADEQUATE_SHARE } else { NOISE_SHARE };
        !current.space.is_base_at_bound(&current.x)
            && current.space.is_plausible(&current.model)
            && self.misfit(current).is_some_and(|misfit| misfit.is_noise())
            && self.predictable(current).is_some_and(|predictable| predictable.share < most)
            && self.bias_is_steady(current)
            && !self.is_lag_of_structure(current)
    }

    /// A delay or lag that is adequate and about as likely as a shifted base which is not: whitening may hide a difference that functions of the motion
    /// show. None for an explanation with effects.
    pub fn lag_instead_of_base(&self, found: &Fitted, base: &Fitted, candidates: &[Fitted]) -> Option<Fitted> {
        let is_as_likely = |other: &&Fitted| {
            other.space.hypothesis.lag().is_some_and(|lag| other.space.hypothesis.effects == [lag.name])
                && other.bic < found.bic + RIVAL_BIC_RANGE
                && self.is_significant(other, base)
                && self.is_adequate(Some(other), base)
        };
        let likely = candidates.iter().filter(|_| found.space.hypothesis.effects.is_empty()).filter(is_as_likely);
        likely.min_by(|a, b| a.bic.total_cmp(&b.bic)).cloned()
    }

    /// Whether effects or another base explain the smaller part of the difference, and the rest changes slowly and differs between records. Noise of
    /// a sensor does not depend on the record: it is a disturbance, or what the motion causes and no function of it shows.
    pub fn leaves_uneven_slow_rest(&self, found: &Fitted, given: &Fitted) -> bool {
        let left = pooled_deviation(&found.residuals) / pooled_deviation(&given.residuals);
        if left * left < SMALLER_PART || coloured(found).is_none() {
            return false;
        }
        let Some(there) = found.on(&self.check) else { return false };
        let each = found.residuals.iter().chain(&there.residuals).map(|residual| deviation(residual));
        let (least, greatest) =
            each.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), one| (low.min(one), high.max(one)));
        greatest > UNEVEN * least
    }

    /// Whether a delay or lag is due to the structure of the model: its third-order base is far from the given one, as when fitted to an actuator of
    /// higher order.
    fn is_lag_of_structure(&self, fitted: &Fitted) -> bool {
        let lag = fitted.space.hypothesis.lag();
        lag.is_some_and(|lag| late::is_of_structure(lag, &fitted.model, self.given))
    }

    /// Whether a bias of the sensor, if there is one, is the same in the fit and in the check records.
    fn bias_is_steady(&self, fitted: &Fitted) -> bool {
        let has_bias = fitted.space.terms().any(|term| term == MeasurementTerm::Bias);
        !has_bias
            || fitted.on(&self.check).is_some_and(|there| is_steady(&[(fitted, &self.fit), (&there, &self.check)]))
    }

    /// The part of a residual that the motion predicts, over all records.
    pub fn predictable(&self, fitted: &Fitted) -> Option<Predictable> {
        self.predictables.of(fitted, || self.find_predictable(fitted))
    }

    fn find_predictable(&self, fitted: &Fitted) -> Option<Predictable> {
        let there = fitted.on(&self.check)?;
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let residuals: Vec<Vec<f64>> = fitted.residuals.iter().chain(&there.residuals).cloned().collect();
        Some(predictable(&fitted.model, &residuals, &traces))
    }

    /// The same on the fit records alone.
    pub fn predictable_when_fitted(&self, fitted: &Fitted) -> Predictable {
        predictable(&fitted.model, &fitted.residuals, &self.fit)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::{
        diagnose::{hypothesis::Hypothesis, measured_noise::MeasuredNoise, three_records::three_records_of},
        progress::Work,
        signal::record::Record,
    };
    use actuator_fmu::parameters::{Base, Model, table};

    /// A record of a servo whose ω swings by this share of itself every few seconds, integrated by classical Runge-Kutta steps.
    fn of_swinging_omega(record: &Record, base: Base, swing: f64) -> Record {
        let [k, _, omega, zeta] = base.values();
        let slope = |t: f64, command: f64, [position, rate]: [f64; 2]| {
            let omega = omega * (1.0 + swing * (TAU * t / 4.7).sin());
            [rate, omega * omega * (k * command - position) - 2.0 * zeta * omega * rate]
        };
        let mut state = [0.0; 2];
        let (time, commands) = (record.time(), record.command());
        let mut positions = vec![0.0];
        for (n, command) in commands.iter().enumerate().take(commands.len() - 1) {
            let step = (time[n + 1] - time[n]) / 4.0;
            for part in 0..4 {
                let t = time[n] + f64::from(part) * step;
                let at = |by: f64, along: [f64; 2]| [0, 1].map(|row| state[row] + by * step * along[row]);
                let first = slope(t, *command, state);
                let second = slope(t + 0.5 * step, *command, at(0.5, first));
                let third = slope(t + 0.5 * step, *command, at(0.5, second));
                let last = slope(t + step, *command, at(1.0, third));
                state = [0, 1]
                    .map(|row| state[row] + step / 6.0 * (first[row] + 2.0 * (second[row] + third[row]) + last[row]));
            }
            positions.push(state[0]);
        }
        Record::new(record.to_command(), positions, record.unit(), record.interpolation(), "swinging").unwrap()
    }

    #[test]
    fn another_base_is_no_name_for_one_that_changes_in_time() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        let leaves_slow_rest = |records: &[Record]| {
            let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
            let work = Work::new(Vec::new(), None);
            let selection = StructureSelection::new(&given, &records[..2], &records[2..], noise, None, &work);
            let [beside, given] = [true, false].map(|base_free| {
                selection.fit(Hypothesis { base_free, ..Hypothesis::default() }, selection.given).unwrap()
            });
            selection.leaves_uneven_slow_rest(&beside, &given)
        };
        let records = three_records_of(&given, 3.0, 6.0);
        let swinging: Vec<Record> = records.iter().map(|record| of_swinging_omega(record, given.base, 0.4)).collect();
        assert!(leaves_slow_rest(&swinging));
        let shifted = Model { base: Base::from_values([k, p, 0.9 * omega, zeta]).unwrap(), ..given.clone() };
        assert!(!leaves_slow_rest(&three_records_of(&shifted, 3.0, 6.0)));
    }
}
