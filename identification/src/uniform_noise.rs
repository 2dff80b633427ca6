//! Uniform noise in ±0.5 for tests, from a named generator.

use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// One value per call.
pub fn uniform_noise(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || random.random_range(-0.5..0.5)
}
