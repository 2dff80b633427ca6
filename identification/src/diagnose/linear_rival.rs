//! The linear model: how much of the records a linear system of any structure explains on unseen samples.
//!
//! A nonlinear effect must have a smaller residual or, beside an equally flexible linear model, explain what the linear model leaves: where it does
//! neither, the base has another structure, and no effect is missing.

use super::{
    folds::Folds,
    plain_fit::PlainFit,
    predictable::{linear_columns, linear_columns_of},
    trace::Trace,
};
use crate::parallel;

/// Time constants of the Laguerre filters, as multiples of 1/ω.
const TIME_CONSTANTS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// Mean square of the residual of the best linear model on each record, fitted to the other records or to alternating parts.
pub fn left_by_linear(traces: &[Trace<'_>], omega: f64) -> Vec<f64> {
    let targets: Vec<Vec<f64>> =
        traces.iter().map(|trace| trace.record.position()[trace.settling..].to_vec()).collect();
    left_by_linear_of(&targets, traces, omega)
}

/// The same for other columns than the positions of the records.
pub fn left_by_linear_of(targets: &[Vec<f64>], traces: &[Trace<'_>], omega: f64) -> Vec<f64> {
    left_by(targets, |multiple| traces.iter().map(|trace| linear_columns(trace, multiple / omega)).collect())
}

/// The same for the residual of an explanation, with a linear model of the command and of its simulated position: what its effect explains even if
/// its base has another structure than the actuator. None where the motion diverges.
pub fn left_beside_linear(fit: &PlainFit, traces: &[Trace<'_>], omega: f64) -> Option<Vec<f64>> {
    let positions = parallel::map(traces, |trace| trace.position(&fit.model));
    let positions = positions.into_iter().collect::<Option<Vec<Vec<f64>>>>()?;
    let columns = |(trace, position): (&Trace<'_>, &Vec<f64>), multiple: f64| {
        let mut columns = linear_columns(trace, multiple / omega);
        columns.extend(linear_columns_of(position, trace, multiple / omega));
        columns
    };
    let all = |multiple: f64| traces.iter().zip(&positions).map(|of_record| columns(of_record, multiple)).collect();
    Some(left_by(&fit.residuals, all))
}

/// Mean square of the residual on each record with the best time constant.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn left_by(targets: &[Vec<f64>], columns: impl Fn(f64) -> Vec<Vec<Vec<f64>>> + Sync) -> Vec<f64> {
    let each: Vec<Vec<f64>> = parallel::map(&TIME_CONSTANTS, |multiple| {
        let folds = Folds::new(&columns(*multiple), targets);
        // A record may show what no other does.
        let across = folds.left_across_records();
        across.into_iter().zip(folds.left_within_records()).map(|(across, within)| across.min(within)).collect()
    });
    let best = each.into_iter().min_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()));
    let counts = targets.iter().map(|target| target.len().max(1) as f64);
    best.unwrap_or_default().into_iter().zip(counts).map(|(left, count)| left / count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{hypothesis::Hypothesis, space::Space, three_records::three_records};
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, Order, table},
    };

    fn with(effects: &[(&str, &[f64])]) -> Model {
        let of = |all: Effects, (name, values): &(&str, &[f64])| all.with(find(name).unwrap(), values).unwrap();
        let effects = effects.iter().fold(Effects::default(), of);
        Model { order: Order::Second, effects, ..Model::from_set(&table()[0]) }
    }

    /// The actuator has a lag that its model does not have: beside a linear model only the limit remains to be explained, and play does not explain
    /// it.
    #[test]
    fn an_effect_is_told_although_the_base_has_another_structure() {
        let truth = with(&[("command_limit", &[-2.0, 2.0]), ("sensor_lag", &[0.03])]);
        let records = three_records(&truth, 4.0);
        let base = truth.base;
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &base)).collect();
        let left = |model: &Model| {
            let space = Space::new(Hypothesis::default(), model, &base, 0.0);
            let fit = PlainFit::at(space, Vec::new(), &traces).unwrap();
            left_beside_linear(&fit, &traces, base.omega()).unwrap().iter().sum::<f64>()
        };
        let linear: f64 = left_by_linear(&traces, base.omega()).iter().sum();
        let (limit, play) = (left(&with(&[("command_limit", &[-2.0, 2.0])])), left(&with(&[("backlash", &[0.5])])));
        assert!(limit < 0.05 * linear && play > 0.5 * linear, "{limit} {play} {linear}");
    }
}
