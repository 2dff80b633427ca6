//! The steady rate that a limit of acceleration allows.

use super::{plain_fit::PlainFit, trace::Trace};
use crate::digits::significant;
use actuator_fmu::parameters::Model;

/// Name of the effect.
pub const ACCELERATION_LIMIT: &str = "acceleration_limit";
/// Share of the steady rate from which on the motion is at it.
const NEARLY: f64 = 0.9;

/// A note on the steady rate under a limit of acceleration, at which drive and damping balance, value = 2ζω rate, and on how often the motion is at
/// it.
pub fn steady_rate(model: &Model, traces: &[Trace<'_>]) -> Option<String> {
    /// Share of the samples from which on that is stated.
    const WORTH_A_WORD: f64 = 0.02;
    let rate = rate_of(model)?;
    let share = share_of_rates_above(NEARLY * rate, model, traces).filter(|share| *share > WORTH_A_WORD);
    let (rate, unit) = (significant(rate, 4), model.unit().of_rate());
    let at_it = share.map_or_else(String::new, |share| {
        format!("; the motion reaches it in {:.0} % of the samples, so that the rate is limited as well", 100.0 * share)
    });
    Some(format!("the acceleration limit allows no steady rate above value / (2 zeta omega) = {rate} {unit}{at_it}"))
}

/// Whether a limit of acceleration holds the motion at its steady rate for so long that it limits the rate as well.
pub fn limits_rate(model: &Model, traces: &[Trace<'_>]) -> bool {
    /// Share of the samples, at least.
    const LONG: f64 = 0.05;
    let share = rate_of(model).and_then(|rate| share_of_rates_above(NEARLY * rate, model, traces));
    share.is_some_and(|share| share > LONG)
}

/// The steady rate that the limit of acceleration of a model allows.
fn rate_of(model: &Model) -> Option<f64> {
    let values = model.effects.active_values_of(ACCELERATION_LIMIT)?;
    Some(values[0] / (2.0 * model.base.zeta() * model.base.omega()))
}

/// Share of the samples in which a model moves at this rate or faster.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn share_of_rates_above(rate: f64, model: &Model, traces: &[Trace<'_>]) -> Option<f64> {
    let moved = PlainFit::as_it_is(model, traces)?;
    let counts = traces.iter().zip(&moved.residuals).map(|(trace, left)| {
        let evaluated = trace.settling..;
        let (time, position) = (&trace.record.time()[evaluated.clone()], &trace.record.position()[evaluated]);
        let at: Vec<(f64, f64)> = time
            .iter()
            .zip(position.iter().zip(left))
            .map(|(time, (measured, left))| (*time, measured - left))
            .collect();
        let is_above = |ends: &&[(f64, f64)]| (ends[1].1 - ends[0].1).abs() >= rate * (ends[1].0 - ends[0].0);
        (at.windows(2).filter(is_above).count(), at.len())
    });
    let (above, all) = counts.fold((0, 0), |(above, all), (one, count)| (above + one, all + count));
    Some(above as f64 / all.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{diagnose::three_records::three_records, simulate::simulate};
    use actuator_fmu::{effects::find, parameters::table};

    #[test]
    fn a_limit_of_acceleration_says_how_long_the_motion_is_at_its_steady_rate() {
        let given = Model::from_set(&table()[0]);
        let steady = 40.0;
        let value = steady * 2.0 * given.base.zeta() * given.base.omega();
        let effects = given.effects.with(find("acceleration_limit").unwrap(), &[value]).unwrap();
        let limited = Model { effects, ..given.clone() };
        let records = three_records(&limited, 10.0);
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &given.base)).collect();
        // From positions without noise, simulated separately.
        let mut rates = Vec::new();
        for trace in &traces {
            let (command, time) = (trace.record.to_command(), trace.record.time());
            let position = simulate(&limited, &command, trace.record.interpolation()).unwrap().position;
            rates.extend(
                (trace.settling + 1..time.len()).map(|n| (position[n] - position[n - 1]) / (time[n] - time[n - 1])),
            );
        }
        let expected = rates.iter().filter(|rate| rate.abs() > 0.9 * steady).count() as f64 / rates.len() as f64;
        let found = share_of_rates_above(0.9 * steady, &limited, &traces).unwrap();
        assert!(expected > 0.05 && (found - expected).abs() < 0.01, "{found} {expected}");
        let note = steady_rate(&limited, &traces).unwrap();
        assert!(note.contains("40.00 deg/s; the motion reaches it in"), "{note}");
        assert!(steady_rate(&given, &traces).is_none());
    }
}
