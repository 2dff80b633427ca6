//! The command behind the play, dead zone or stop that explains most of a position.

use super::laguerre;
use crate::signal::play::{behind_play, range};

/// Behind a play: the command, and the fraction of the position that a flexible linear model of it explains.
pub fn best_play(command: &[f64], position: &[f64]) -> (Vec<f64>, f64) {
    let (low, high) = range(command);
    best(|part| behind_play(command, part * 0.5 * (high - low)), position)
}

/// Behind a dead zone.
pub fn best_dead_zone(command: &[f64], position: &[f64]) -> (Vec<f64>, f64) {
    let peak = peak(command);
    best(|part| dead_zone(command, part * peak), position)
}

/// Behind stops.
pub fn best_stop(command: &[f64], position: &[f64]) -> (Vec<f64>, f64) {
    let peak = peak(command);
    best(|part| command.iter().map(|value| value.clamp(-part * peak, part * peak)).collect(), position)
}

/// A command behind a dead zone.
pub fn dead_zone(command: &[f64], half_width: f64) -> Vec<f64> {
    command.iter().map(|value| value - value.clamp(-half_width, half_width)).collect()
}

/// The largest magnitude.
pub fn peak(command: &[f64]) -> f64 {
    command.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}

/// The best one: searched over tenths of the command's range or peak, then refined.
fn best(behind: impl Fn(f64) -> Vec<f64>, position: &[f64]) -> (Vec<f64>, f64) {
    const STEP: f64 = 0.1;
    let tried = |part: f64| {
        let command = behind(part);
        let share = laguerre::fit(&command, position).share;
        (part, command, share)
    };
    let better = |best: (f64, Vec<f64>, f64), part: f64| {
        let next = tried(part);
        if next.2 > best.2 { next } else { best }
    };
    let best = (2..10).map(|tenth| STEP * f64::from(tenth)).fold(tried(STEP), better);
    let best = [0.5, 0.25, 0.125].iter().fold(best, |best, step| {
        let middle = best.0;
        [middle - step * STEP, middle + step * STEP].into_iter().fold(best, better)
    });
    (best.1, best.2)
}
