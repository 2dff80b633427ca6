//! The content of an FMU, and all checks on it. All problems are collected and reported together: five problems should not take five runs.

use crate::{
    archive::{Archive, MODEL_DESCRIPTION},
    description,
    error::{Error, Result},
    folder,
    platform::Platform,
};
use std::{borrow::Cow, collections::BTreeMap, path::PathBuf};

/// First eight bytes of every PNG file (ISO/IEC 15948, section 5.2).
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The content of an FMU. Fill the fields, then call [`Package::archive`].
#[derive(Clone, Debug, Default)]
pub struct Package {
    /// Name of the binaries: a C identifier, equal to `modelIdentifier` in the description.
    pub model_identifier: String,
    /// Text of `modelDescription.xml`.
    pub description: String,
    /// One shared library for each platform.
    pub binaries: Vec<(Platform, Binary)>,
    /// A PNG picture, packaged as `model.png`.
    pub icon: Option<Vec<u8>>,
    /// Files below `documentation/`; importers open `index.html`.
    pub documentation: BTreeMap<String, Vec<u8>>,
    /// Files below `resources/`, which the binary can read at run time.
    pub resources: BTreeMap<String, Vec<u8>>,
    /// Licence texts, packaged below `documentation/licenses/`.
    pub licenses: BTreeMap<String, Vec<u8>>,
    /// Other files, under their full names, such as `extra/org.example/data.csv`.
    pub extra: BTreeMap<String, Vec<u8>>,
}

/// A compiled shared library: a file, or its bytes.
#[derive(Clone, Debug)]
pub enum Binary {
    /// A file to read when the archive is made.
    File(PathBuf),
    /// The bytes themselves.
    Bytes(Vec<u8>),
}

impl From<PathBuf> for Binary {
    fn from(path: PathBuf) -> Self {
        Self::File(path)
    }
}

impl From<Vec<u8>> for Binary {
    fn from(bytes: Vec<u8>) -> Self {
        Self::Bytes(bytes)
    }
}

impl Package {
    /// Checks everything and makes the archive, or reports all problems.
    pub fn archive(&self) -> Result<Archive> {
        let mut archive = Archive::new();
        let mut problems = Vec::new();
        if !is_c_identifier(&self.model_identifier) {
            problems.push(format!(
                "the model identifier is \"{}\"; it must be a C identifier of letters, digits and underscores",
                self.model_identifier
            ));
        }
        problems.extend(description::problems(&self.description, &self.model_identifier));
        if self.binaries.is_empty() {
            problems.push("there is no binary; add the shared library of at least one platform".into());
        }

        let mut add = |name: String, bytes: &[u8]| {
            if let Err(problem) = archive.insert(name, bytes) {
                problems.push(problem.to_string());
            }
        };
        add(MODEL_DESCRIPTION.into(), self.description.as_bytes());
        for (folder, files) in [
            ("documentation/", &self.documentation),
            ("documentation/licenses/", &self.licenses),
            ("resources/", &self.resources),
            ("", &self.extra),
        ] {
            for (name, bytes) in files {
                add(format!("{folder}{name}"), bytes);
            }
        }
        if let Some(icon) = &self.icon {
            add("model.png".into(), icon);
        }
        let mut unusable = Vec::new();
        for (platform, binary) in &self.binaries {
            match binary.read() {
                Ok(bytes) => {
                    unusable.extend(binary_problem(*platform, &bytes));
                    add(platform.entry(&self.model_identifier), &bytes);
                    if let Some((entry, part)) = platform.other_entry(&self.model_identifier, &bytes) {
                        add(entry, part);
                    }
                }
                Err(problem) => unusable.push(problem.to_string()),
            }
        }
        problems.append(&mut unusable);
        if self.icon.as_ref().is_some_and(|icon| !icon.starts_with(PNG_SIGNATURE)) {
            problems.push("the icon is not a PNG picture; FMI 2.0 allows no other format: convert it".into());
        }

        if problems.is_empty() {
            Ok(archive)
        } else {
            Err(Error::Package { model_identifier: self.model_identifier.clone(), problems })
        }
    }
}

impl Binary {
    fn read(&self) -> Result<Cow<'_, [u8]>> {
        match self {
            Self::File(path) => folder::read_file(path).map(Cow::Owned),
            Self::Bytes(bytes) => Ok(Cow::Borrowed(bytes)),
        }
    }
}

fn binary_problem(platform: Platform, bytes: &[u8]) -> Option<String> {
    (!platform.recognises(bytes)).then(|| {
        let start = bytes.get(..4).unwrap_or(bytes);
        format!(
            "the binary for {platform} is not a shared library of that platform (it has {} bytes and begins with \
             {start:02x?}); compile it for {}",
            bytes.len(),
            platform.target()
        )
    })
}

/// FMI 2.0.4, section 4.3.1: the model identifier is a short class name in C syntax, and the name of the binary.
pub(crate) fn is_c_identifier(word: &str) -> bool {
    !word.starts_with(|c: char| c.is_ascii_digit())
        && !word.is_empty()
        && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::is_c_identifier;

    #[test]
    fn model_identifiers_are_c_identifiers() {
        for word in ["M", "_m", "BactActuator", "a1_"] {
            assert!(is_c_identifier(word), "{word}");
        }
        for word in ["", "1a", "a-b", "a b", "größe", "../a"] {
            assert!(!is_c_identifier(word), "{word}");
        }
    }
}
