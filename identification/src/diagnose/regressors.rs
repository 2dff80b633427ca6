//! Regressors: functions of the motion that a missing effect could act through.

use serde::Serialize;

use super::trace::{Motion, Trace};
use crate::signal::{delayed, play::behind_play, record::rms};

/// A named column over the evaluated samples.
pub struct Regressor {
    /// In words.
    pub name: &'static str,
    /// What it is a function of: `position`, `rate`, `direction`, `command`, `time` or `load`.
    pub kind: &'static str,
    /// In the units of the motion.
    pub values: Vec<f64>,
}

/// A regressor that explains part of a residual.
#[derive(Debug, Clone, Serialize)]
pub struct ExplainingRegressor {
    /// Its name.
    pub term: &'static str,
    /// What it is a function of.
    pub kind: &'static str,
    /// Share of the variance of the innovations that it explains in addition to those before it.
    pub share: f64,
    /// In words.
    pub sentence: String,
}

/// Time since the last reversal of the rate, at each sample \[s\].
pub fn since_reversal_s(time: &[f64], rate: &[f64]) -> Vec<f64> {
    // Share of the rms rate below which the position is at rest; rest is no reversal.
    const STANDSTILL_SHARE: f64 = 0.02;
    let least = STANDSTILL_SHARE * rms(rate);
    let (mut direction, mut since) = (0.0, time[0] - 1.0);
    time.iter()
        .zip(rate)
        .map(|(time, rate)| {
            if rate.abs() > least && rate.signum() != direction {
                (direction, since) = (rate.signum(), *time);
            }
            time - since
        })
        .collect()
}

/// Play operator of half width r: input minus output.
fn play(input: &[f64], half_width: f64) -> Vec<f64> {
    input.iter().zip(behind_play(input, half_width)).map(|(value, behind)| value - behind).collect()
}

/// Sizes of motions at which the regressors have their corners.
#[derive(Debug, Clone, Copy)]
pub struct Scales {
    position: f64,
    rate: f64,
    acceleration: f64,
}

impl Scales {
    /// Root mean squares of some motions together.
    #[allow(clippy::cast_precision_loss)] // a count of motions
    pub fn of(motions: &[Motion]) -> Self {
        let pooled = |of: &dyn Fn(&Motion) -> &Vec<f64>| {
            let square: f64 = motions.iter().map(|motion| rms(of(motion)).powi(2)).sum();
            (square / motions.len().max(1) as f64).sqrt().max(f64::MIN_POSITIVE)
        };
        Self {
            position: pooled(&|motion| &motion.position),
            rate: pooled(&|motion| &motion.rate),
            acceleration: pooled(&|motion| &motion.acceleration_demand),
        }
    }
}

/// All regressors of one record.
pub fn regressors(trace: &Trace<'_>, motion: &Motion, scales: Scales) -> Vec<Regressor> {
    let time = trace.record.time();
    let command = trace.record.command();
    let (y, v, a) = (&motion.position, &motion.rate, &motion.acceleration_demand);
    let Scales { position: size, rate: fast, acceleration: hard } = scales;
    let duration = trace.record.duration_s();
    let reversal = since_reversal_s(time, v);
    let mut found: Vec<Regressor> = Vec::new();
    let mut add = |name: &'static str, kind: &'static str, values: Vec<f64>| {
        let mut values = values[trace.settling..].to_vec();
        if !rms(&values).is_finite() {
            values.fill(0.0);
        }
        found.push(Regressor { name, kind, values });
    };
    let of = |function: &dyn Fn(usize) -> f64| (0..time.len()).map(function).collect::<Vec<f64>>();
    add("position", "position", y.clone());
    add("position squared", "position", of(&|n| y[n] * y[n]));
    add("position cubed", "position", of(&|n| y[n].powi(3)));
    add("|position|", "position", of(&|n| y[n].abs()));
    add("position beyond its rms", "position", of(&|n| y[n] - y[n].clamp(-size, size)));
    add("rate", "rate", v.clone());
    add("rate squared", "rate", of(&|n| v[n] * v[n]));
    add("rate |rate|", "rate", of(&|n| v[n] * v[n].abs()));
    add("rate cubed", "rate", of(&|n| v[n].powi(3)));
    add("rate beyond its rms", "rate", of(&|n| v[n] - v[n].clamp(-fast, fast)));
    add("|rate|", "rate", of(&|n| v[n].abs()));
    add("position squared times rate", "rate", of(&|n| y[n] * y[n] * v[n]));
    add("position times rate", "rate", of(&|n| y[n] * v[n]));
    add("acceleration", "rate", a.clone());
    add("acceleration beyond its rms", "rate", of(&|n| a[n] - a[n].clamp(-hard, hard)));
    add("acceleration cubed", "rate", of(&|n| a[n].powi(3)));
    add("direction", "direction", of(&|n| v[n] / (v[n].abs() + 0.02 * fast)));
    add("direction times |position|", "direction", of(&|n| y[n].abs() * v[n] / (v[n].abs() + 0.02 * fast)));
    add("direction for 20 ms after a reversal", "direction", of(&|n| v[n].signum() * (-reversal[n] / 0.02).exp()));
    add("direction for 100 ms after a reversal", "direction", of(&|n| v[n].signum() * (-reversal[n] / 0.1).exp()));
    add("play of 5 % of the position", "direction", play(y, 0.05 * size));
    add("play of 20 % of the position", "direction", play(y, 0.2 * size));
    add("play of 60 % of the position", "direction", play(y, 0.6 * size));
    add("command", "command", command.to_vec());
    add("|command|", "command", of(&|n| command[n].abs()));
    add("command cubed", "command", of(&|n| command[n].powi(3)));
    for (name, lag) in [("command one sample ago", 1), ("command two samples ago", 2), ("command four samples ago", 4)]
    {
        add(name, "command", delayed(command, lag).collect());
    }
    add("constant", "time", vec![1.0; time.len()]);
    let t = |n: usize| (time[n] - time[0]) / duration - 0.5;
    add("time", "time", of(&t));
    add("time times position", "time", of(&|n| t(n) * y[n]));
    add("time times rate", "time", of(&|n| t(n) * v[n]));
    add("time times acceleration", "time", of(&|n| t(n) * a[n]));
    if let Some(load) = trace.record.load() {
        add("load", "load", load.to_vec());
    }
    found
}
