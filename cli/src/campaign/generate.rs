//! A synthetic BACT campaign: the 17 conditions of the tables, each with a linear sweep and a random sequence, as records with sensor noise
//! and, under load, turbulence; the corresponding manifest, and the truth.

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use rayon::prelude::*;

use super::outcome::Progress;
use super::truth::{TrueCondition, Truth};
use crate::files;
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Model, ParameterSet, table},
};
use identification::{
    compare::tunnel::tunnel,
    generated::{TestPoint, Turbulence},
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
    },
};

/// Options of the generator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed of everything random.
    pub seed: u64,
    /// Length of each record \[s\].
    pub duration_s: f64,
    /// Peak command \[deg\].
    pub amplitude_deg: f64,
    /// Sensor noise as a fraction of the position's rms.
    pub noise_share: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, duration_s: Excitation::LONG_S, amplitude_deg: 2.0, noise_share: 0.02 }
    }
}

/// Excitations of each condition.
const KINDS: [Kind; 2] = [Kind::Sweep, Kind::Random];

/// Records of a campaign: each excitation under each of the 17 conditions.
pub const RECORDS: usize = 17 * KINDS.len();

/// Number of seeds used for one campaign, so that neighbouring seeds share none.
const SEEDS: u64 = 1000;

struct Planned {
    set: &'static ParameterSet,
    kind: Kind,
    seed: u64,
}

impl Planned {
    fn name(&self) -> String {
        format!("{}-{}", self.set.name, self.kind.name())
    }

    fn pressure_psf(&self) -> f64 {
        tunnel(self.set.name).map_or(0.0, |tunnel| tunnel.dynamic_pressure_psf)
    }

    fn test_point(&self, options: &Options) -> TestPoint {
        TestPoint {
            model: Model::from_set(self.set),
            excitation: Excitation {
                duration_s: options.duration_s,
                amplitude: options.amplitude_deg,
                seed: self.seed,
                ..Excitation::new(self.kind)
            },
            interpolation: Interpolation::Held,
            noise_share: options.noise_share,
            turbulence: Turbulence::at(self.pressure_psf()),
            seed: self.seed,
        }
    }
}

/// Writes `manifest.toml`, `truth.toml` and the records to a folder; returns the number of records. `progress` is called after each record
/// with the number done and the total.
///
/// # Errors
/// Options for which no record can be generated; existing files when `force` is false.
pub fn write(folder: &Path, options: &Options, force: bool, progress: Progress) -> Result<usize> {
    if !(options.noise_share >= 0.0 && options.noise_share.is_finite()) {
        return Err(Error::new("noise", options.noise_share.to_string(), "a share of the position's rms from 0 on"));
    }
    let planned: Vec<Planned> = table()
        .iter()
        .flat_map(|set| KINDS.map(|kind| (set, kind)))
        .zip(options.seed.wrapping_mul(SEEDS)..)
        .map(|((set, kind), seed)| Planned { set, kind, seed })
        .collect();
    let done = AtomicUsize::new(0);
    let records: Vec<(String, Vec<u8>)> = planned
        .par_iter()
        .map(|one| {
            let name = one.name();
            let record = one.test_point(options).record(&format!("generated: {name}"))?;
            let mut csv = Vec::new();
            record.write_csv(&mut csv).map_err(|error| Error::new("record", error.to_string(), "a CSV file"))?;
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, planned.len());
            Ok((format!("records/{name}.csv"), csv))
        })
        .collect::<Result<_>>()?;
    let mut all = records;
    all.push(("truth.toml".into(), truth(&planned, options)?.into_bytes()));
    all.push(("manifest.toml".into(), manifest(&planned, options).into_bytes()));
    files::write_folder(folder, &all, force)?;
    Ok(planned.len())
}

fn manifest(planned: &[Planned], options: &Options) -> String {
    let mut text = format!(
        "# A generated campaign, not measured data: the 17 actuators of NASA/TM-1998-208452 with noise of {} % and turbulence under \
         load, seed {}.\n[campaign]\nname = \"Generated BACT campaign {}\"\ntruth = \"truth.toml\"\n",
        100.0 * options.noise_share,
        options.seed,
        options.seed
    );
    for planned in planned {
        let name = &planned.set.name;
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n[[record]]\nname = \"{}\"\nfile = \"records/{}.csv\"\nsurface = \"{}\"\nstage = \"{}\"\nload_case = \"{}\"\n",
            planned.name(),
            planned.name(),
            name.surface.name(),
            name.stage.name(),
            name.load_case.name()
        );
        if let Some(tunnel) = tunnel(*name) {
            let _ =
                write!(text, "mach = {:?}\ndynamic_pressure_psf = {:?}\n", tunnel.mach, tunnel.dynamic_pressure_psf);
        }
    }
    text
}

fn truth(planned: &[Planned], options: &Options) -> Result<String> {
    let condition: BTreeMap<String, TrueCondition> = planned
        .iter()
        .map(|planned| {
            let [k, p, omega, zeta] = planned.set.base.values();
            let turbulence =
                Turbulence::at(planned.pressure_psf()).map_or(0.0, |turbulence| turbulence.deflection_rms_deg);
            (
                planned.set.name.to_string(),
                TrueCondition { order: 3, k, p, omega, zeta, turbulence_rms_deg: turbulence },
            )
        })
        .collect();
    let truth = Truth { seed: options.seed, noise_share: options.noise_share, condition };
    let toml =
        toml::to_string(&truth).map_err(|error| Error::new("truth", error.to_string(), "values that TOML can hold"))?;
    Ok(format!("# What the records of this campaign were generated from.\n{toml}"))
}
