//! Valid names of archive entries: those that unpack to the same relative path on every system, and never outside the folder they are
//! unpacked into.

/// The problem with a name, or `None`.
pub(super) fn problem(name: &str) -> Option<&'static str> {
    let parts = || name.split('/');
    if name.is_empty() {
        Some("is empty")
    } else if name.starts_with('/') {
        Some("is absolute")
    } else if name.contains('\\') {
        Some("has a backslash")
    } else if name.contains(':') {
        Some("has a colon, which Windows reads as a drive")
    } else if name.chars().any(char::is_control) {
        Some("has a control character")
    } else if parts().any(|part| part == "..") {
        Some("has `..` and would leave the archive")
    } else if parts().any(|part| part.is_empty() || part == ".") {
        Some("has an empty part or `.`, or ends with a slash")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::problem;

    #[test]
    fn plain_relative_names_are_allowed() {
        for name in
            ["a", "modelDescription.xml", "binaries/aarch64-linux/M.so", "documentation/Größe (1).html", "a/..b/.c"]
        {
            assert_eq!(problem(name), None, "{name}");
        }
    }

    #[test]
    fn names_that_leave_the_archive_or_depend_on_the_system_are_refused() {
        for (name, word) in [
            ("", "empty"),
            ("/etc/passwd", "absolute"),
            ("C:/x", "colon"),
            ("a\\b", "backslash"),
            ("..", "leave"),
            ("a/../../b", "leave"),
            ("a//b", "empty part"),
            ("./a", "empty part"),
            ("a/", "slash"),
            ("a\nb", "control"),
            ("a\0", "control"),
        ] {
            assert!(problem(name).is_some_and(|problem| problem.contains(word)), "{name:?}: {:?}", problem(name));
        }
    }
}
