//! The arguments of an instantiation.

use std::path::PathBuf;

use percent_encoding::percent_decode_str;

use crate::{
    calls::Kind,
    error::{Error, Result},
};

/// The arguments of `fmi2Instantiate` that a model may need.
#[derive(Debug, Clone)]
pub struct Request {
    /// Name of the instance; never empty.
    pub name: String,
    /// Kind of simulation; one that the model offers.
    pub kind: Kind,
    /// GUID of the model description read by the host.
    pub guid: Option<String>,
    /// `fmuResourceLocation`, unchanged.
    pub resources: Option<String>,
}

impl Request {
    /// Refuses another GUID than the model's own: binary and description must belong together.
    ///
    /// # Errors
    /// The GUID that was found.
    pub fn expect_guid(&self, own: &str) -> Result<()> {
        match self.guid.as_deref() {
            Some(guid) if guid == own => Ok(()),
            Some(guid) => {
                Err(Error::new("fmuGUID", guid, own).remedy("take binary and modelDescription.xml from the same FMU"))
            }
            None => Err(Error::new("fmuGUID", "NULL", own)),
        }
    }

    /// Folder of the resources, if the host gave one.
    #[must_use]
    pub fn resource_folder(&self) -> Option<PathBuf> {
        self.resources.as_deref().map(resource_path)
    }
}

/// Path of `fmuResourceLocation`: `file:/x`, `file:///x`, `file:////x`, `file://localhost/x`, or a path as it is.
fn resource_path(uri: &str) -> PathBuf {
    let Some(rest) = uri.strip_prefix("file:") else { return PathBuf::from(uri) };
    let rest = rest.strip_prefix("//localhost").unwrap_or(rest);
    let slashes = rest.len() - rest.trim_start_matches('/').len();
    let mut path = rest[slashes.saturating_sub(1)..].to_owned();
    // On Windows `file:///C:/x` is `C:/x`.
    if cfg!(windows) && path.starts_with('/') && path[1..].contains(':') {
        path.remove(0);
    }
    PathBuf::from(percent_decode_str(&path).decode_utf8_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resource_locations_of_all_importers_are_understood() {
        for (uri, path) in [
            ("file:///a/b", "/a/b"),
            ("file:/a/b", "/a/b"),
            ("file:////a/b", "/a/b"),
            ("file://localhost/a%20b/", "/a b/"),
            ("/a/b", "/a/b"),
            ("file:///a/50%", "/a/50%"),
            ("", ""),
            ("file:", ""),
        ] {
            assert_eq!(resource_path(uri), PathBuf::from(path), "{uri}");
        }
    }
}
