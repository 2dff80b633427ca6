//! From a package to an FMU: read its manifest, compile, collect, check, write.

use crate::{
    atomic::Overwrite,
    cargo, compile,
    error::{Error, Result},
    folder,
    linker::Linker,
    manifest::Manifest,
    package::{Binary, Package},
    platform::Platform,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// How to build. The default is an FMU for this computer at the default place.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Platforms to compile for, so that the binaries run on other computers as well ([`Linker::for_other_computers`]); empty means this
    /// computer's own, on Linux with zig if available, so that an older glibc suffices.
    pub platforms: Vec<Platform>,
    /// Output path; `None` means `<target directory>/fmu/<model identifier>.fmu`, a build product that every build replaces.
    pub output: Option<PathBuf>,
    /// Also replace a file at [`Options::output`].
    pub force: bool,
}

/// Builds the FMU of the package at `package`, a folder or a `Cargo.toml`, and returns its path.
pub fn build(package: impl AsRef<Path>, options: &Options) -> Result<PathBuf> {
    let manifest = Manifest::read(package)?;
    let output = match &options.output {
        Some(output) => output.clone(),
        None => default_output(&manifest)?,
    };
    let overwrite = if options.force || options.output.is_none() { Overwrite::Allow } else { Overwrite::Refuse };
    overwrite.check(&output)?;
    assemble(&manifest, &options.platforms)?.archive()?.write(&output, overwrite)?;
    Ok(output)
}

/// Compiles for each platform (none means this computer's) and reads all files: the FMU before it is checked and written, for callers that
/// want to add to it.
pub fn assemble(manifest: &Manifest, platforms: &[Platform]) -> Result<Package> {
    let (platforms, linker) = match platforms {
        [] => {
            let host = Platform::host()?;
            // On Linux a binary linked by zig runs with older versions of glibc as well.
            let linker = if host.has_glibc() { Linker::for_other_computers() } else { Linker::Native };
            (BTreeSet::from([host]), linker)
        }
        named => (named.iter().copied().collect(), Linker::for_other_computers()),
    };
    // All are checked before the first is compiled, which may take minutes.
    compile::check_targets(&platforms.iter().copied().collect::<Vec<_>>(), &linker)?;
    let binary = |platform| Ok((platform, Binary::Bytes(compile::shared_library(manifest, platform, &linker)?)));
    let files = |path: &Option<PathBuf>| path.as_deref().map_or(Ok(BTreeMap::new()), folder::read);
    Ok(Package {
        model_identifier: manifest.model_identifier.clone(),
        description: read_text(&manifest.description)?,
        icon: manifest.icon.as_deref().map(folder::read_file).transpose()?,
        documentation: files(&manifest.documentation)?,
        resources: files(&manifest.resources)?,
        licenses: read_licenses(&manifest.licenses)?,
        binaries: platforms.into_iter().map(binary).collect::<Result<_>>()?,
        // FMI 2.0.4, section 2.2: the folder `extra`, with one folder in reverse domain notation for each standard.
        extra: files(&manifest.extra)?.into_iter().map(|(name, bytes)| (format!("extra/{name}"), bytes)).collect(),
    })
}

fn default_output(manifest: &Manifest) -> Result<PathBuf> {
    let folder = cargo::target_directory(&manifest.manifest_path)?.join("fmu");
    Ok(folder.join(format!("{}.fmu", manifest.model_identifier)))
}

fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).map_err(|cause| Error::Read { path: path.into(), cause })
}

/// Licences come from different places and go to one folder, so their file names must differ.
fn read_licenses(paths: &[PathBuf]) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut licenses = BTreeMap::new();
    for path in paths {
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            return Err(Error::Unpackable { path: path.clone(), problem: "has a name that is not UTF-8" });
        };
        if licenses.insert(name.to_owned(), folder::read_file(path)?).is_some() {
            return Err(Error::DuplicateEntry { name: path.display().to_string(), existing: name.into() });
        }
    }
    Ok(licenses)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_licences_of_one_name_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["LICENSE", "third-party/LICENSE"].map(|name| folder.path().join(name));
        std::fs::create_dir(folder.path().join("third-party")).unwrap();
        for path in &paths {
            std::fs::write(path, "text").unwrap();
        }
        assert_eq!(read_licenses(&paths[..1]).unwrap()["LICENSE"], b"text");
        assert!(matches!(read_licenses(&paths), Err(Error::DuplicateEntry { .. })));
    }
}
