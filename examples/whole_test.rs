//! The size of the real wind-tunnel test, 2300 test points of 5 minutes at 200 samples/s: 138 million samples of each channel.
//!
//! Test points are generated one at a time on every core, analysed as `actuator campaign` analyses a record (response by local
//! polynomials, maximum-likelihood fit), and forgotten, so that memory holds a record for each core and no more.
//!
//! ```sh
//! cargo run --release --example whole_test -- 2300
//! ```

use std::{
    sync::atomic::{AtomicUsize, Ordering},
    time::Instant,
};

use actuator_fmu::{
    Result,
    parameters::{Model, table},
};
use cli::campaign::record::of_record;
use identification::{
    compare::tunnel::tunnel,
    estimate::Settings,
    generated::{TestPoint, Turbulence},
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
    },
};
use rayon::prelude::*;

/// As the program `actuator` has it.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Length of a test point [s].
const DURATION_S: f64 = 300.0;

fn main() -> Result<()> {
    let points: u64 = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(100);
    let (samples, unlike) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let start = Instant::now();
    (0..points).into_par_iter().try_for_each(|seed| -> Result<()> {
        let set = &table()[usize::try_from(seed % 17).unwrap_or(0)];
        let pressure = tunnel(set.name).map_or(0.0, |tunnel| tunnel.dynamic_pressure_psf);
        let kind = if seed / 17 % 2 == 0 { Kind::Sweep } else { Kind::Random };
        let point = TestPoint {
            model: Model::from_set(set),
            excitation: Excitation { duration_s: DURATION_S, seed, ..Excitation::new(kind) },
            interpolation: Interpolation::Held,
            noise_share: 0.02,
            turbulence: Turbulence::at(pressure),
            seed,
        };
        let result = of_record(point.record("generated")?, &Settings::default())?;
        samples.fetch_add(result.samples, Ordering::Relaxed);
        if (result.fit.values[0] / set.base.k() - 1.0).abs() > 0.01 {
            unlike.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    })?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{points} test points of {DURATION_S} s, {:.1} million samples of each channel: {seconds:.1} s on {} cores, {:.3} s of a core for each; \
         k off by more than 1 % in {}",
        samples.load(Ordering::Relaxed) as f64 / 1e6,
        rayon::current_num_threads(),
        seconds * rayon::current_num_threads() as f64 / points as f64,
        unlike.load(Ordering::Relaxed)
    );
    Ok(())
}
