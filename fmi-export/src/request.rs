//! The arguments of an instantiation.

use std::path::PathBuf;

use percent_encoding::percent_decode_str;

use crate::{
    abi::library,
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
    /// Refuses a GUID other than the model's own: binary and description must belong together.
    ///
    /// # Errors
    /// The GUID found.
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

    /// Candidate folders of the resources: the one given by the host, and that of the FMU from which this library was loaded, for hosts
    /// that give none or a wrong one.
    #[must_use]
    pub fn resource_folders(&self) -> Vec<PathBuf> {
        // <FMU>/binaries/<platform>/<library>
        let own = library::path().and_then(|path| Some(path.parent()?.parent()?.parent()?.join("resources")));
        self.resource_folder().into_iter().chain(own).collect()
    }
}

/// Path of `fmuResourceLocation`, or of a string that is not a URL.
fn resource_path(uri: &str) -> PathBuf {
    let path = uri.strip_prefix("file:").map(|rest| percent_decode_str(rest).decode_utf8_lossy().into_owned());
    match path {
        None => PathBuf::from(uri),
        Some(path) => PathBuf::from(if cfg!(windows) { windows_path(&path) } else { unix_path(&path) }),
    }
}

/// For `/x`, `///x`, `////x`, `//localhost/x`.
fn unix_path(path: &str) -> String {
    let path = path.strip_prefix("//localhost").unwrap_or(path);
    let rest = path.trim_start_matches('/');
    if rest.len() == path.len() { rest.to_owned() } else { format!("/{rest}") }
}

/// As above with a drive, `///C:/x`; a path with two, four or five slashes contains a server, `//server/share/x`.
fn windows_path(path: &str) -> String {
    let path = path.strip_prefix("//localhost").unwrap_or(path);
    let rest = path.trim_start_matches('/');
    let has_drive = rest.as_bytes().get(1) == Some(&b':');
    match path.len() - rest.len() {
        _ if has_drive => rest.to_owned(),
        0 => rest.to_owned(),
        2 | 4.. if !rest.is_empty() => format!("//{rest}"),
        _ => format!("/{rest}"),
    }
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

    #[test]
    fn locations_on_windows_have_drives_and_servers() {
        for (uri, path) in [
            ("///C:/a", "C:/a"),
            ("/C:/a", "C:/a"),
            ("//localhost/C:/a", "C:/a"),
            ("C:/a", "C:/a"),
            ("//server/share/a", "//server/share/a"),
            ("////server/share/a", "//server/share/a"),
            ("/////server/share/a", "//server/share/a"),
            ("///a", "/a"),
            ("", ""),
        ] {
            assert_eq!(windows_path(path_of(uri).as_str()), path, "{uri}");
        }
        assert_eq!(windows_path(&path_of("///C%3A/a%20b")), "C:/a b");
    }

    fn path_of(encoded: &str) -> String {
        percent_decode_str(encoded).decode_utf8_lossy().into_owned()
    }

    #[test]
    #[cfg_attr(miri, ignore = "asks the loader of the system")]
    fn without_a_location_the_resources_are_beside_the_library() {
        let request = Request { name: "a".into(), kind: Kind::CoSimulation, guid: None, resources: None };
        assert_eq!(request.resource_folder(), None);
        let own = request.resource_folders();
        // The test program takes the place of the library.
        let expected = std::env::current_exe().unwrap().ancestors().nth(3).unwrap().join("resources");
        assert_eq!(own, [expected]);
    }
}
