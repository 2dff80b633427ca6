//! The two XML files: `fmi-ls-manifest.xml`, which describes each file, and the experiments.
//!
//! FMI-LS-REF is a pre-release (1.0.0-beta.1), and so is the format of experiments that it refers to (MA-HS-Experiments). Of the latter we
//! follow the schema, in which the times of a simulation are in `TransientSimulation`; its text still has them one level up.

use serde::Serialize;

use super::experiment::{EXPERIMENTS, SAMPLES_PER_SECOND, STIMULUS, response_name, stop_time_s, values_name};
use crate::{ssp, xml};
use actuator_fmu::{
    error::Result,
    parameters::{ParameterSet, table},
};

const NAMESPACE: &str = "http://fmi-standard.org/fmi-ls-manifest";
const PARAMETER_SET: &str = "application/x-ssp-parameter-set";
const TABLE: &str = "text/csv";

#[derive(Serialize)]
#[serde(rename = "fmiReferences")]
struct Manifest {
    #[serde(rename = "@xmlns:fmi-ls")]
    namespace: &'static str,
    #[serde(rename = "@fmi-ls:fmi-ls-name")]
    name: &'static str,
    #[serde(rename = "@fmi-ls:fmi-ls-version")]
    version: &'static str,
    #[serde(rename = "@fmi-ls:fmi-ls-description")]
    description: &'static str, // fixed by the schema
    #[serde(rename = "Related")]
    files: Vec<Related>,
}

#[derive(Serialize)]
struct Related {
    #[serde(rename = "@type")]
    kind: &'static str,
    #[serde(rename = "@source")]
    source: String,
    #[serde(rename = "@role")]
    role: &'static str,
    #[serde(rename = "@description")]
    description: String,
}

pub(super) fn manifest() -> Result<String> {
    let experiments = Related {
        kind: "application/x-ma-hs-experiments",
        source: EXPERIMENTS.into(),
        role: "experiment/smoke-test",
        description: "Step response of each set".into(),
    };
    let stimulus = Related {
        kind: TABLE,
        source: STIMULUS.into(),
        role: "other",
        description: "Command of the experiments".into(),
    };
    let sets = table().iter().map(|set| Related {
        kind: PARAMETER_SET,
        source: values_name(set),
        role: "parameter",
        description: ssp::summary(set),
    });
    let responses = table().iter().map(|set| Related {
        kind: TABLE,
        source: response_name(set),
        role: "result",
        description: format!("Response of {} to the command of the experiments", set.name),
    });
    let manifest = Manifest {
        namespace: NAMESPACE,
        name: "org.fmi-standard.fmi-ls-ref",
        version: "1.0.0-beta.1",
        description: "Layered Standard providing information on related files included in an FMU.",
        files: [experiments, stimulus].into_iter().chain(sets).chain(responses).collect(),
    };
    xml::document("fmi-ls-manifest.xml", &manifest)
}

#[derive(Serialize)]
#[serde(rename = "Experiments")]
struct Experiments {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@description")]
    description: &'static str,
    #[serde(rename = "Experiment")]
    all: Vec<Experiment>,
}

#[derive(Serialize)]
struct Experiment {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@description")]
    description: String,
    #[serde(rename = "TransientSimulation")]
    simulation: TransientSimulation,
    #[serde(rename = "Parameters")]
    parameters: Source,
    #[serde(rename = "Stimuli")]
    stimuli: Source,
    #[serde(rename = "References")]
    references: Source,
}

#[derive(Serialize)]
struct TransientSimulation {
    #[serde(rename = "@startTime")]
    start: f64,
    #[serde(rename = "@stopTime")]
    stop: f64,
    #[serde(rename = "@stepSize")]
    step: f64,
}

#[derive(Serialize)]
struct Source {
    #[serde(rename = "@type")]
    kind: &'static str,
    #[serde(rename = "@source")]
    source: String,
}

pub(super) fn experiments() -> Result<String> {
    let experiment = |set: &ParameterSet| Experiment {
        name: format!("{}-step", set.name),
        description: ssp::summary(set),
        simulation: TransientSimulation { start: 0.0, stop: stop_time_s(), step: 1.0 / SAMPLES_PER_SECOND },
        parameters: Source { kind: PARAMETER_SET, source: values_name(set) },
        stimuli: Source { kind: TABLE, source: STIMULUS.into() },
        references: Source { kind: TABLE, source: response_name(set) },
    };
    let document = Experiments {
        name: "step responses",
        description: "Every identified actuator answers to steps of 1 deg, as it should in any importer",
        all: table().iter().map(experiment).collect(),
    };
    xml::document(EXPERIMENTS, &document)
}
