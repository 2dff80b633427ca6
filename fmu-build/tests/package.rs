//! Properties of the archives that `fmu-build` guarantees, checked from outside: with the zip reader and on
//! the file system.

#![allow(clippy::unwrap_used)]

use fmu_build::{Archive, Error, Overwrite, Package, Platform};
use std::{fs, io::Cursor, path::Path};

const DESCRIPTION: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Tiny" guid="{tiny}">
  <CoSimulation modelIdentifier="Tiny"/>
  <ModelVariables/>
  <ModelStructure/>
</fmiModelDescription>
"#;

/// The first bytes of a 64-bit x86 ELF file, as far as the machine number 62.
fn elf_x86_64() -> Vec<u8> {
    let mut bytes = b"\x7fELF".to_vec();
    bytes.resize(18, 0);
    bytes.extend([62, 0]);
    bytes
}

fn tiny() -> Package {
    let file = |name: &str, text: &str| [(name.to_owned(), text.as_bytes().to_vec())].into();
    Package {
        model_identifier: "Tiny".into(),
        description: DESCRIPTION.into(),
        binaries: vec![(Platform::Linux64, elf_x86_64().into())],
        icon: Some(b"\x89PNG\r\n\x1a\n...".to_vec()),
        documentation: file("index.html", "<html></html>"),
        resources: file("data/table.csv", &"0.0,1.0\n".repeat(1000)),
        licenses: file("LICENSE-MIT", "Permission is hereby granted"),
        extra: file("extra/org.example/note.txt", "note"),
    }
}

#[test]
fn two_builds_are_byte_identical() {
    let first = tiny().archive().unwrap().to_bytes().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(2100)); // zip times count in steps of two seconds
    assert!(first == tiny().archive().unwrap().to_bytes().unwrap());
}

#[test]
fn a_zip_reader_finds_order_mode_compression_and_time_as_promised() {
    let bytes = tiny().archive().unwrap().to_bytes().unwrap();
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let names: Vec<_> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
    assert_eq!(
        names,
        [
            "modelDescription.xml",
            "binaries/linux64/Tiny.so",
            "documentation/index.html",
            "documentation/licenses/LICENSE-MIT",
            "extra/org.example/note.txt",
            "model.png",
            "resources/data/table.csv",
        ]
    );
    for index in 0..zip.len() {
        let file = zip.by_index(index).unwrap();
        assert_eq!(file.compression(), zip::CompressionMethod::Deflated);
        assert_eq!(file.unix_mode(), Some(0o100_644)); // a regular file, rw-r--r--
        assert_eq!(file.last_modified(), Some(zip::DateTime::DEFAULT)); // 1980-01-01
        assert_eq!(file.system(), zip::System::Unix);
        assert_eq!(file.extra_data().unwrap_or_default(), b"");
    }
    let table = zip.by_name("resources/data/table.csv").unwrap();
    assert!(table.compressed_size() < table.size() / 10, "repetitive text must shrink");
}

#[test]
fn names_that_unpack_outside_or_differently_are_refused() {
    let mut archive = Archive::new();
    for name in ["", "/a", "../a", "a/../../b", "a\\b", "C:a", "a//b", "a/", "./a", "a\u{7}"] {
        assert!(matches!(archive.insert(name, ""), Err(Error::EntryName { .. })), "{name:?}");
    }
    archive.insert("a", "").unwrap();
    assert!(matches!(archive.insert("a", ""), Err(Error::DuplicateEntry { .. })));
    assert_eq!(archive.names().collect::<Vec<_>>(), ["a"]);
}

#[test]
fn all_problems_are_reported_together() {
    let mut package = tiny();
    package.description =
        DESCRIPTION.replace("\"2.0\"", "\"3.0\"").replace("{tiny}", "").replace("\"Tiny\"/", "\"Other\"/");
    package.binaries = vec![
        (Platform::Win64, elf_x86_64().into()),
        (Platform::Linux64, Path::new("no/such/library.so").to_owned().into()),
    ];
    package.icon = Some(b"GIF89a".to_vec());
    package.resources.insert("../escape".into(), vec![]);
    package.extra.insert("MODEL.PNG".into(), vec![]);
    let Error::Package { problems, .. } = package.archive().unwrap_err() else { panic!("another error") };
    let expected = [
        "fmiVersion is \"3.0\"",
        "guid is \"\"",
        "<CoSimulation> is \"Other\"",
        "`resources/../escape`",
        "`MODEL.PNG`",
        "binary for win64",
        "no/such/library.so",
        "not a PNG",
    ];
    assert_eq!(problems.len(), expected.len(), "{problems:#?}");
    for words in expected {
        assert!(problems.iter().any(|problem| problem.contains(words)), "{words} in {problems:#?}");
    }
    let message = Error::Package { model_identifier: "Tiny".into(), problems }.to_string();
    assert!(message.starts_with("cannot package `Tiny`, 8 problems to solve:\n  - "), "{message}");
}

#[test]
fn a_package_without_binary_or_name_is_no_fmu() {
    let message = Package::default().archive().unwrap_err().to_string();
    for words in ["C identifier", "not well-formed XML", "no binary"] {
        assert!(message.contains(words), "{words} in {message}");
    }
}

#[test]
fn a_refused_or_failed_write_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/Tiny.fmu");
    let archive = tiny().archive().unwrap();
    archive.write(&path, Overwrite::Refuse).unwrap();
    assert_eq!(Archive::read(&path).unwrap(), archive);

    let before = fs::read(&path).unwrap();
    assert!(matches!(Archive::new().write(&path, Overwrite::Refuse), Err(Error::Exists { .. })));
    assert!(matches!(archive.write(path.parent().unwrap(), Overwrite::Allow), Err(Error::Write { .. })));
    assert!(fs::read(&path).unwrap() == before);
    let left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().chain(fs::read_dir(path.parent().unwrap()).unwrap()).collect();
    assert_eq!(left.len(), 2, "the folder and the archive only: {left:?}");
}

#[test]
fn an_fmu_with_other_content_is_a_new_archive_with_the_same_binary() {
    let original = tiny().archive().unwrap();
    let mut changed = Archive::from_bytes(&original.to_bytes().unwrap()).unwrap();
    changed.replace("modelDescription.xml", DESCRIPTION.replace("{tiny}", "{other}")).unwrap();
    changed.insert("resources/model.toml", "gain = 2.0").unwrap();
    let changed = Archive::from_bytes(&changed.to_bytes().unwrap()).unwrap();
    assert_eq!(changed.get("binaries/linux64/Tiny.so"), original.get("binaries/linux64/Tiny.so"));
    assert_eq!(changed.names().count(), original.names().count() + 1);
}
