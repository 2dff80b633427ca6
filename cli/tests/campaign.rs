//! Campaigns: valid manifests, the handling of records that fail, and that nothing is done twice.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

use cli::{
    campaign::{self, Campaign, How, Manifest, Options, generate},
    invocation::Invocation,
    report::campaign as report,
};

use crate::compare::assert_well_formed;

/// Without a diagnosis, which has a separate test.
const QUICK: Options = Options { force: false, diagnose: false };

fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path
}

const RECORD: &str =
    "[[record]]\nfile = \"a.csv\"\nsurface = \"trailing_edge\"\nstage = \"early\"\nload_case = \"unloaded\"\n";

#[test]
fn a_bad_manifest_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let with = |more: &str| format!("{RECORD}{more}");
    for (text, line, part) in [
        ("[[record\n".to_owned(), 1, "manifest"),
        ("[campaign]\nname = \"x\"\n".to_owned(), 1, "record"),
        (format!("[campaign]\nmethod = \"guess\"\n{RECORD}"), 2, "likelihood or report"),
        (format!("[campaign]\norder = 4\n{RECORD}"), 2, "2, 3 or"),
        (format!("[campaign]\ndelay_s = -0.1\n{RECORD}"), 2, "delay_s"),
        (format!("[campaign]\ncolour = \"red\"\n{RECORD}"), 2, "colour"),
        (with("mach = -1.0\n"), 6, "mach"),
        (with("dynamic_pressure_psf = nan\n"), 6, "dynamic_pressure_psf"),
        (with("unit = \"inch\"\n"), 6, "rad, deg, mm, m or 1"),
        (with("columns = { speed = \"v\" }\n"), 6, "speed"),
        (with("hold = \"yes\"\n"), 6, "boolean"),
        (with("altitude = 3.0\n"), 6, "altitude"),
        (with("time-unit = \"ms\"\n"), 6, "name, method, order, delay_s, truth; [[record]] with file, name"),
        (with("name = \"../outside\"\n"), 1, "name of a record"),
        (RECORD.replace("unloaded", "heavy"), 5, "unloaded or loaded"),
        (RECORD.replace("trailing_edge", "trailing/edge"), 3, "surface"),
        (format!("{RECORD}\n{RECORD}"), 7, "line 1"),
    ] {
        let path = write(folder.path(), "manifest.toml", &text);
        let message = Manifest::read(&path).unwrap_err().to_string();
        assert!(message.contains(&format!("manifest.toml:{line}: ")), "{message}\n{text}");
        assert!(message.contains(part), "{message}");
    }
    let empty = write(folder.path(), "manifest.toml", "record = []\n");
    assert!(Manifest::read(&empty).unwrap_err().to_string().contains("one [[record]] or more"));
}

#[test]
fn a_record_may_differ_from_what_the_campaign_says_for_all() {
    let folder = tempfile::tempdir().unwrap();
    let head = "[campaign]\nunit = \"rad\"\nhold = false\ncolumns = { time = \"t\", command = \"c\" }\norder = 2\ndelay_s = \"free\"\n";
    let own = "[[record]]\nfile = \"b/c.csv\"\nsurface = \"rudder\"\nstage = \"overhauled\"\nload_case = \"loaded\"\nunit = \"mm\"\n\
               hold = true\ncolumns = { position = \"x\" }\n";
    let manifest = Manifest::read(&write(folder.path(), "bench.toml", &format!("{head}{RECORD}{own}"))).unwrap();
    let [common, own] = manifest.records.as_slice() else { panic!() };
    assert_eq!((manifest.name.as_str(), common.name.as_str(), own.name.as_str()), ("bench", "a", "b_c"));
    assert_eq!(own.condition.to_string(), "rudder-overhauled-loaded");
    let of = |entry: &campaign::Entry| format!("{:?}", entry.format);
    assert!(of(common).contains("Radian") && of(common).contains("Linear") && of(common).contains("\"position\""));
    assert!(of(own).contains("Millimetre") && of(own).contains("Held") && of(own).contains("position: \"x\""));
    assert!(of(own).contains("time: \"t\""));
    assert_eq!(own.file, folder.path().join("b/c.csv"));
}

/// A campaign of short records in a separate folder, some of which the manifest keeps.
fn generated(folder: &Path, kept: impl Fn(usize, &str) -> bool) -> PathBuf {
    let options = generate::Options { seed: 11, duration_s: 25.0, ..generate::Options::default() };
    assert_eq!(generate::write(folder, &options, false, &|_, _| {}).unwrap(), 34);
    let path = folder.join("manifest.toml");
    let text = fs::read_to_string(&path).unwrap();
    let (head, records) = text.split_once("\n[[record]]").unwrap();
    let records = records.split("\n[[record]]").enumerate().filter(|(index, record)| kept(*index, record));
    let records: String = records.map(|(_, record)| format!("\n[[record]]{record}")).collect();
    fs::write(&path, format!("{head}{records}")).unwrap();
    path
}

fn run(manifest: &Path, folder: &Path) -> Campaign {
    campaign::run(&Manifest::read(manifest).unwrap(), folder, QUICK, &Invocation::default(), &|_, _| {}).unwrap()
}

/// Names and contents of the results that a campaign keeps for each record and condition.
fn results_of(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files: Vec<(PathBuf, Vec<u8>)> = ["records", "conditions", "models"]
        .iter()
        .flat_map(|part| fs::read_dir(folder.join(part)).unwrap().map(|entry| entry.unwrap().path()))
        .map(|path| (path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn results_are_the_same_to_the_bit_for_any_number_of_threads_and_any_order_of_the_manifest() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = generated(folder.path(), |index, _| index < 6);
    let on = |threads: usize, manifest: &Path| {
        let results = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(manifest, results.path()));
        results_of(results.path())
    };
    let expected = on(1, &manifest);
    assert_eq!(expected.len(), 6 + 3 + 3, "{:?}", expected.iter().map(|(name, _)| name).collect::<Vec<_>>());
    assert!(on(4, &manifest) == expected);

    let text = fs::read_to_string(&manifest).unwrap();
    let mut parts: Vec<&str> = text.split("\n[[record]]").collect();
    parts[1..].reverse();
    let reversed = write(folder.path(), "reversed.toml", &parts.join("\n[[record]]"));
    assert!(on(2, &reversed) == expected);
}

#[test]
fn a_campaign_goes_on_where_it_was_killed_while_it_wrote_its_first_file() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = generated(folder.path(), |index, _| index == 0);
    let results = folder.path().join("results");
    let remains = results.join(format!("{}a", fmu_build::TEMPORARY_PREFIX));
    fs::create_dir(&results).unwrap();
    fs::write(&remains, "half").unwrap();
    run(&manifest, &results);
    assert!(!remains.exists());
}

#[test]
fn a_record_that_fails_is_listed_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = generated(folder.path(), |index, _| index < 6);
    let record = |name: &str| folder.path().join(format!("records/te-{name}.csv"));
    fs::remove_file(record("early-unloaded-sweep")).unwrap();
    let text = fs::read_to_string(record("early-unloaded-random")).unwrap();
    let broken: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(row, line)| if row == 70 { "0.345,NaN,1".into() } else { line.to_owned() })
        .collect();
    fs::write(record("early-unloaded-random"), broken.join("\n")).unwrap();
    fs::write(record("middle-unloaded-sweep"), "time,command,angle\n0,0,0\n").unwrap();

    let results = folder.path().join("results");
    let campaign = run(&manifest, &results);
    let failure = |index: usize| campaign.records[index].failure.clone().unwrap_or_default();
    assert!(failure(0).contains("te-early-unloaded-sweep.csv"), "{}", failure(0));
    assert!(failure(1).contains("te-early-unloaded-random.csv:71"), "{}", failure(1));
    assert!(failure(2).contains("te-middle-unloaded-sweep.csv"), "{}", failure(2));
    // In the terms of the manifest: the command has no such options.
    assert!(failure(2).contains("columns = { position = \"NAME\" }") && !failure(2).contains("--"), "{}", failure(2));
    for record in &campaign.records[3..] {
        assert!(record.result.is_some(), "{:?}", record.failure);
    }
    // One condition has lost all its records, one continues with a single one, one has both.
    let conditions: Vec<_> = campaign.conditions.iter().map(|condition| condition.result.as_ref()).collect();
    assert!(conditions[0].is_none() && campaign.conditions[0].failure.is_some());
    assert_eq!(conditions[1].map(|result| result.how), Some(How::Alone));
    assert_eq!(conditions[2].map(|result| result.how), Some(How::Joint));
    let text = report::text(&campaign);
    assert!(text.contains("3 failed") && text.contains("te-early-unloaded-random.csv:71"), "{text}");
    let page = report::html(&campaign, &[], &Invocation::default());
    assert!(page.contains("te-early-unloaded-random.csv:71") && page.matches("<svg").count() >= 2);
    for svg in page.split("<svg").skip(1) {
        assert_well_formed("chart", &format!("<svg{}</svg>", svg.split("</svg>").next().unwrap()));
    }
}

#[test]
fn a_second_run_takes_over_what_has_not_changed_and_makes_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = generated(folder.path(), |index, _| index < 4);
    let results = folder.path().join("results");
    let first = run(&manifest, &results);
    assert!(first.records.iter().all(|record| !record.reused && record.result.is_some()));
    let stored = |name: &str| results.join(format!("records/te-{name}.json"));
    let written = |name: &str| fs::metadata(stored(name)).unwrap().modified().unwrap();
    let before = written("early-unloaded-sweep");

    // As if interrupted: one result missing, one partly written by another program.
    fs::remove_file(stored("middle-unloaded-sweep")).unwrap();
    fs::write(stored("middle-unloaded-random"), "{\"key\": {\"data_sha").unwrap();
    let done = AtomicUsize::new(0);
    let read = Manifest::read(&manifest).unwrap();
    let second = campaign::run(&read, &results, QUICK, &Invocation::default(), &|_, _| {
        done.fetch_add(1, Ordering::Relaxed);
    })
    .unwrap();
    assert_eq!(done.load(Ordering::Relaxed), 4);
    assert_eq!(second.records.iter().map(|record| record.reused).collect::<Vec<_>>(), [true, true, false, false]);
    assert_eq!(written("early-unloaded-sweep"), before);
    for (first, second) in first.records.iter().zip(&second.records) {
        assert_eq!(first.result, second.result);
    }
    assert_eq!(first.conditions, second.conditions);

    // A changed record is recomputed, and so is its condition; after a changed option everything is recomputed.
    let path = folder.path().join("records/te-early-unloaded-sweep.csv");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.trim_end().rsplit_once('\n').unwrap().0).unwrap();
    let third = run(&manifest, &results);
    assert_eq!(third.records.iter().map(|record| record.reused).collect::<Vec<_>>(), [false, true, true, true]);
    assert_ne!(third.conditions[0], second.conditions[0]);
    assert_eq!(third.conditions[1], second.conditions[1]);
    let changed = fs::read_to_string(&manifest).unwrap().replace("[campaign]", "[campaign]\norder = 2");
    fs::write(&manifest, changed).unwrap();
    assert!(run(&manifest, &results).records.iter().all(|record| !record.reused));
}

#[test]
fn the_folder_of_something_else_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = Manifest::read(&generated(folder.path(), |index, _| index < 1)).unwrap();
    let taken = tempfile::tempdir().unwrap();
    fs::write(taken.path().join("thesis.tex"), "").unwrap();
    let message =
        campaign::run(&manifest, taken.path(), QUICK, &Invocation::default(), &|_, _| {}).unwrap_err().to_string();
    assert!(message.contains("--force"), "{message}");
    assert_eq!(fs::read_dir(taken.path()).unwrap().count(), 1);

    let results = folder.path().join("results");
    campaign::run(&manifest, &results, QUICK, &Invocation::default(), &|_, _| {}).unwrap();
    let other = Manifest { name: "another".into(), ..manifest };
    assert!(
        campaign::run(&other, &results, QUICK, &Invocation::default(), &|_, _| {})
            .unwrap_err()
            .to_string()
            .contains("Generated BACT")
    );
    assert!(
        campaign::run(&other, &results, Options { force: true, ..QUICK }, &Invocation::default(), &|_, _| {}).is_ok()
    );
}

#[test]
fn a_generated_campaign_is_the_same_for_the_same_seed_and_leads_back_to_its_truth() {
    let folder = tempfile::tempdir().unwrap();
    // One surface is sufficient here: 6 of the 17 conditions.
    let manifest = generated(folder.path(), |_, record| record.contains("trailing_edge"));
    let again = tempfile::tempdir().unwrap();
    generated(again.path(), |_, _| true);
    for name in ["truth.toml", "records/us-late-loaded-random.csv"] {
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), fs::read(again.path().join(name)).unwrap());
    }
    let campaign = run(&manifest, &folder.path().join("results"));
    assert_eq!((campaign.conditions.len(), campaign.truth.len()), (6, 3 * 6));
    // Records of 25 s with 2 % noise and turbulence, two of each condition.
    for deviation in &campaign.truth {
        let allowed = if deviation.parameter == "k" { 0.01 } else { 0.06 };
        assert!(deviation.relative.abs() < allowed, "{deviation:?}");
        assert!(deviation.in_std_errors.is_some_and(|errors| errors.abs() < 4.0), "{deviation:?}");
    }
    assert_eq!((campaign.comparison.wear.len(), campaign.comparison.load.len()), (6, 3));
    let early_late = &campaign.comparison.wear[1].data_band.phase_deg;
    // Figure 10 from records instead of tables: 7.82 deg, within the stated uncertainty.
    assert!((early_late.max - 7.82).abs() < 4.0 * early_late.std_error.unwrap(), "{early_late:?}");
    for condition in &campaign.conditions {
        let model = folder.path().join(format!("results/models/{}.toml", condition.condition));
        cli::files::read_model(&model.to_string_lossy()).unwrap();
    }
}
