//! What a package declares about its FMU, in the table `[package.metadata.fmu]` of its `Cargo.toml`:
//!
//! ```toml
//! [package.metadata.fmu]
//! model-identifier = "Pendulum"             # a C identifier; names the binaries and the archive
//! description = "modelDescription.xml"      # the model description
//! icon = "model.png"                        # optional, PNG
//! documentation = "documentation"           # optional, a folder with index.html
//! licenses = ["LICENSE-MIT"]                # optional, files for documentation/licenses/
//! resources = "resources"                   # optional, a folder for the binary to read from
//! extra = "extra"                           # optional, a folder with files for other tools, one folder per standard
//! profile = "release"                       # optional, the cargo profile to compile with
//! features = ["fast"]                       # optional, features to compile with; default features are off
//! ```
//!
//! Paths are relative to the folder of the `Cargo.toml`. A key that is not in this list is an error.

mod table;

use crate::{
    error::{Error, Result},
    package::is_c_identifier,
};
use std::{
    fs,
    path::{Path, PathBuf},
};
use table::CargoToml;

/// The default profile.
pub const DEFAULT_PROFILE: &str = "release";

/// A package and the FMU it makes, with all paths resolved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Manifest {
    /// The `Cargo.toml` this was read from.
    pub manifest_path: PathBuf,
    /// Name of the package.
    pub package: String,
    /// Name of the binaries and of the archive.
    pub model_identifier: String,
    /// The model description.
    pub description: PathBuf,
    /// A PNG picture.
    pub icon: Option<PathBuf>,
    /// Folder of the documentation.
    pub documentation: Option<PathBuf>,
    /// Licence texts.
    pub licenses: Vec<PathBuf>,
    /// Folder of the resources.
    pub resources: Option<PathBuf>,
    /// Folder of files for other tools.
    pub extra: Option<PathBuf>,
    /// Cargo profile to compile with.
    pub profile: String,
    /// Features to compile with.
    pub features: Vec<String>,
}

impl Manifest {
    /// Reads the `Cargo.toml` at `path`, or in the folder `path`.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let path = if path.is_dir() { path.join("Cargo.toml") } else { path.into() };
        let text = fs::read_to_string(&path).map_err(|cause| Error::Read { path: path.clone(), cause })?;
        Self::parse(&text, path)
    }

    fn parse(text: &str, path: PathBuf) -> Result<Self> {
        let cargo_toml: CargoToml = toml::from_str(text).map_err(|problem| Error::ManifestSyntax {
            path: path.clone(),
            cause: problem.to_string().trim_end().into(),
        })?;
        let refused = |key, found: &str, allowed, remedy: &str| Error::Manifest {
            path: path.clone(),
            key,
            found: found.into(),
            allowed,
            remedy: remedy.into(),
        };
        let Some(package) = cargo_toml.package else {
            return Err(refused("package", "missing", "a package", "name the folder of a package, not of a workspace"));
        };
        let Some(fmu) = package.metadata.fmu else {
            let remedy = "add the table with model-identifier = \"Name\" and description = \"modelDescription.xml\"";
            return Err(refused("package.metadata.fmu", "missing", "a table", remedy));
        };
        let (identifier, profile) = (fmu.model_identifier, fmu.profile.unwrap_or(DEFAULT_PROFILE.into()));
        if !is_c_identifier(&identifier) {
            let remedy = "choose one, and use it as modelIdentifier in the model description";
            let found = format!("\"{identifier}\"");
            return Err(refused("model-identifier", &found, "a C identifier: letters, digits and underscores", remedy));
        }

        let folder = path.parent().unwrap_or(Path::new(""));
        // Paths are checked here, where the key is known, before anything is compiled.
        let existing = |key, relative: &Path, is_kind: fn(&Path) -> bool, kind| {
            let full = folder.join(relative);
            if is_kind(&full) {
                return Ok(full);
            }
            let found = format!("\"{}\", which is no such thing", relative.display());
            Err(refused(key, &found, kind, &format!("create {} or correct the path", full.display())))
        };
        let file = |key, relative: &Path| existing(key, relative, Path::is_file, "the path of a file");
        let directory = |key, relative: &Path| existing(key, relative, Path::is_dir, "the path of a folder");

        Ok(Self {
            description: file("description", &fmu.description)?,
            icon: fmu.icon.map(|icon| file("icon", &icon)).transpose()?,
            documentation: fmu.documentation.map(|path| directory("documentation", &path)).transpose()?,
            licenses: fmu.licenses.iter().map(|path| file("licenses", path)).collect::<Result<_>>()?,
            resources: fmu.resources.map(|path| directory("resources", &path)).transpose()?,
            extra: fmu.extra.map(|path| directory("extra", &path)).transpose()?,
            package: package.name,
            model_identifier: identifier,
            profile,
            features: fmu.features,
            manifest_path: path,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(fmu_table: &str) -> String {
        let text = format!("[package]\nname = \"p\"\n{fmu_table}");
        Manifest::parse(&text, "pkg/Cargo.toml".into()).unwrap_err().to_string()
    }

    fn assert_says(message: &str, words: &[&str]) {
        assert!(words.iter().all(|word| message.contains(word)), "{words:?} in: {message}");
    }

    #[test]
    fn this_package_is_no_fmu_and_the_message_says_how_to_make_it_one() {
        let message = Manifest::read(env!("CARGO_MANIFEST_DIR")).unwrap_err().to_string();
        assert_says(&message, &["Cargo.toml", "package.metadata.fmu", "missing", "model-identifier ="]);
    }

    #[test]
    fn a_workspace_without_a_package_is_not_enough() {
        let message = Manifest::parse("[workspace]", "Cargo.toml".into()).unwrap_err().to_string();
        assert_says(&message, &["`package` is missing", "not of a workspace"]);
    }

    #[test]
    fn an_unknown_key_is_refused_with_line_and_allowed_keys() {
        let message = refusal("[package.metadata.fmu]\nmodel-identifer = \"M\"\n");
        assert_says(
            &message,
            &["pkg/Cargo.toml", "line 4", "unknown field `model-identifer`", "`resources`", "correct this line"],
        );
    }

    #[test]
    fn a_missing_or_mistyped_key_is_named() {
        assert_says(&refusal("[package.metadata.fmu]\nmodel-identifier = \"M\""), &["missing field `description`"]);
        let mistyped = "[package.metadata.fmu]\nmodel-identifier = \"M\"\ndescription = \"d\"\nlicenses = \"MIT\"";
        assert_says(&refusal(mistyped), &["line 6", "licenses", "expected a sequence"]);
    }

    #[test]
    fn a_path_that_leads_nowhere_is_named_with_its_key() {
        let message = refusal("[package.metadata.fmu]\nmodel-identifier = \"M\"\ndescription = \"no.xml\"");
        assert_says(&message, &["`description`", "\"no.xml\"", "the path of a file", "no.xml or correct the path"]);
    }

    #[test]
    fn an_identifier_that_c_would_refuse_is_refused() {
        let message = refusal("[package.metadata.fmu]\nmodel-identifier = \"a-b\"\ndescription = \"d\"");
        assert_says(&message, &["`model-identifier` is \"a-b\"", "C identifier"]);
    }
}
