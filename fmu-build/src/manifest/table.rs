//! The part of `Cargo.toml` that is read, as typed structures. A key of `[package.metadata.fmu]` without a field here is refused; the rest
//! of the file is left to cargo.

use serde::Deserialize;
use std::path::PathBuf;

#[derive(Deserialize)]
pub(super) struct CargoToml {
    pub(super) package: Option<PackageTable>,
}

#[derive(Deserialize)]
pub(super) struct PackageTable {
    pub(super) name: String,
    #[serde(default)]
    pub(super) metadata: MetadataTable,
}

#[derive(Deserialize, Default)]
pub(super) struct MetadataTable {
    pub(super) fmu: Option<FmuTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct FmuTable {
    pub(super) model_identifier: String,
    pub(super) description: PathBuf,
    pub(super) icon: Option<PathBuf>,
    pub(super) documentation: Option<PathBuf>,
    #[serde(default)]
    pub(super) licenses: Vec<PathBuf>,
    pub(super) resources: Option<PathBuf>,
    pub(super) extra: Option<PathBuf>,
    pub(super) profile: Option<String>,
    #[serde(default)]
    pub(super) features: Vec<String>,
}
