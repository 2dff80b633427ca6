//! The stages of a search, for its progress: how many times each simulates all samples, as counted on records with one effect, with two, with none,
//! and of rigs that nothing explains.

use super::thinned::{MOST_SAMPLES_WHOLE, Thinning};
use crate::progress::Stage;

/// The given model and its base refitted.
pub const BASE: usize = 0;
/// All effects, one at a time.
pub const SINGLES: usize = 1;
/// Further effects beside the best one.
pub const FORWARD: usize = 2;
/// Effects beside a free base.
pub const WIDE: usize = 3;
/// Pairs of effects.
pub const PAIRS: usize = 4;
/// The conclusion, on all records.
pub const CONCLUSION: usize = 5;

/// Passes through the samples in each stage, and the probability that it is reached.
const EXPECTED: [[f64; 2]; 6] = [[25.0, 1.0], [100.0, 1.0], [100.0, 1.0], [1200.0, 0.2], [600.0, 0.05], [80.0, 1.0]];

/// The stages of a search on this number of samples; where there are many, all stages but the last use a part of them.
#[allow(clippy::cast_precision_loss)] // counts
pub fn stages(samples: usize) -> Vec<Stage> {
    let part = if samples > MOST_SAMPLES_WHOLE { Thinning::FINE.most_samples } else { samples };
    let all = EXPECTED.iter().enumerate().map(|(stage, [passes, chance])| Stage {
        samples: passes * if stage == CONCLUSION { samples } else { part } as f64,
        chance: *chance,
    });
    all.collect()
}
