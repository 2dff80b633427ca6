//! Wear and load: the numbers of an independent computation, and the resulting check of the report's statements.

use actuator_fmu::parameters::Model;
use cli::{files, invocation::Invocation, report::comparison};
use identification::compare::{Comparison, Difference, InBand, Set, Statement, Verdict};

fn tables() -> &'static Comparison {
    static TABLES: std::sync::OnceLock<Comparison> = std::sync::OnceLock::new();
    TABLES.get_or_init(Comparison::of_tables)
}

fn pair<'a>(pairs: &'a [Difference], from: &str, to: &str) -> &'a Difference {
    pairs.iter().find(|pair| pair.from == from && pair.to == to).unwrap_or_else(|| panic!("{from} {to}"))
}

#[test]
fn every_difference_is_that_of_an_independent_computation() {
    // tests/compare/reference.py: another formula, a grid of 0.001 Hz. A maximum inside the band may lie between our points,
    // 0.01 Hz apart: 1e-5 deg/deg and 1e-3 deg. A first frequency is the next of our points.
    let mut rows = csv::Reader::from_reader(include_bytes!("compare/reference.csv").as_slice());
    let mut count = 0;
    for row in rows.records() {
        let row = row.unwrap();
        let (kind, from, to, band) = (&row[0], &row[1], &row[2], &row[3]);
        let pairs = match kind {
            "wear" => &tables().wear,
            "load" => &tables().load,
            _ => &tables().order,
        };
        let found = pair(pairs, from, to);
        let found: &InBand = if band == "data" { &found.data_band } else { &found.aeroelastic_band };
        let number = |column: usize| row[column].parse::<f64>().ok();
        assert!((found.magnitude.max - number(4).unwrap()).abs() < 1e-5, "{row:?} {found:?}");
        assert!((found.phase_deg.max - number(6).unwrap()).abs() < 1e-3, "{row:?} {found:?}");
        for (found, expected) in
            [(found.magnitude.first_passed_hz, number(5)), (found.phase_deg.first_passed_hz, number(7))]
        {
            match (found, expected) {
                (None, None) => {}
                (Some(found), Some(expected)) => {
                    assert!((-1e-9..0.01).contains(&(found - expected)), "{row:?} {found}");
                }
                _ => panic!("{row:?} {found:?}"),
            }
        }
        count += 1;
    }
    assert_eq!(count, 2 * (tables().wear.len() + tables().load.len() + tables().order.len()));
}

#[test]
fn figures_7_10_and_13_have_their_numbers() {
    let close = |found: f64, expected: f64, digits: f64| {
        assert!((found - expected).abs() <= 0.5 * digits, "{found} {expected}")
    };
    let order = |name: &str| pair(&tables().order, name, &format!("{name}, second order")).data_band;
    let figure_7 = order("ls-early-unloaded");
    close(figure_7.phase_deg.max, 0.432, 1e-3);
    close(figure_7.phase_deg.at_hz, 12.0, 1e-9);
    close(figure_7.magnitude.max, 3e-5, 1e-5);
    close(order("te-late-loaded").phase_deg.max, 0.626, 1e-3);

    let wear = |from: &str, to: &str| pair(&tables().wear, from, to).data_band;
    let early_late = wear("te-early-unloaded", "te-late-unloaded");
    close(early_late.phase_deg.max, 7.82, 0.01);
    close(early_late.phase_deg.at_hz, 12.0, 1e-9);
    close(early_late.phase_deg.first_passed_hz.unwrap(), 5.68, 1e-9);
    let early_middle = wear("te-early-unloaded", "te-middle-unloaded");
    close(early_middle.phase_deg.max, 3.99, 0.01);
    close(early_middle.phase_deg.first_passed_hz.unwrap(), 10.6, 0.1);

    let load = |surface_stage: &str| {
        pair(&tables().load, &format!("{surface_stage}-unloaded"), &format!("{surface_stage}-loaded")).data_band
    };
    for (name, phase, magnitude) in [
        ("te-early", 1.13, Some(0.059)),
        ("us-early", 4.58, None),
        ("us-late", 14.0, Some(0.148)),
        ("te-middle", 5.0, Some(0.111)),
    ] {
        close(load(name).phase_deg.max, phase, 0.01);
        if let Some(magnitude) = magnitude {
            close(load(name).magnitude.max, magnitude, 1e-3);
        }
    }
    assert!(tables().wear.iter().chain(&tables().load).all(|pair| pair.aeroelastic_band.within_limits));
}

fn statement(name: &str) -> &'static Statement {
    tables().statements.iter().find(|statement| statement.name == name).unwrap_or_else(|| panic!("{name}"))
}

#[test]
fn statements_stand_as_the_tables_have_it() {
    use Verdict::{Agrees, CannotBeChecked, Contradicted};
    for (name, verdict, number) in [
        ("load-has-no-significant-impact", Contradicted, "14.00 deg"),
        ("varied-little", Contradicted, "4 of 8"),
        ("gain-varies-less", Agrees, "1.25"),
        ("pole-varies-less", Contradicted, "43056"),
        ("pole-remained-large", Agrees, "6898"),
        ("second-order-suffices", Agrees, "0.432"),
        ("significant-beyond-6-hz", Agrees, "5.68"),
        ("allowed-between-3-and-5-hz", Agrees, "2.60 deg"),
        ("bandwidth-about-twice", Agrees, "2.1"),
        ("load-less-than-time", Contradicted, "4.58 against 3.05"),
        ("figure-13", Agrees, "1.13 deg and 0.059"),
        ("models-match-measurements", CannotBeChecked, "pictures"),
        ("figures-fit-their-axes", Contradicted, "-57.5 deg"),
    ] {
        let found = statement(name);
        assert_eq!(found.verdict, verdict, "{found:?}");
        assert!(found.finding.contains(number), "{found:?}");
    }
    let names: std::collections::BTreeSet<_> = tables().statements.iter().map(|statement| statement.name).collect();
    assert_eq!(names.len(), tables().statements.len());
    assert!(
        tables()
            .statements
            .iter()
            .all(|statement| !statement.finding.contains("inf") && !statement.finding.contains("NaN"))
    );
}

#[test]
fn given_sets_are_compared_by_condition_or_against_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let model = files::read_model("te-early-unloaded").unwrap();
    for name in ["te-late-unloaded.toml", "other.toml"] {
        std::fs::write(path(name), model.to_toml().unwrap()).unwrap();
    }
    let set = |text: &str| files::read_set(text).unwrap();
    let by_name = Comparison::of("", vec![set("te-early-unloaded"), set(&path("te-late-unloaded.toml"))]);
    assert_eq!((by_name.wear.len(), by_name.against_first.len()), (1, 0));
    // The file contains the first set: no difference, although its name gives another stage.
    assert_eq!(by_name.wear[0].data_band.phase_deg.max, 0.0);
    let assigned =
        Comparison::of("", vec![set("te-early-unloaded"), set(&format!("te-early-loaded={}", path("other.toml")))]);
    assert_eq!((assigned.load.len(), assigned.statements.len()), (1, 0));
    let unnamed = Comparison::of("", vec![set("te-early-unloaded"), set(&path("other.toml"))]);
    assert_eq!((unnamed.wear.len(), unnamed.load.len(), unnamed.against_first.len()), (0, 0, 1));
    let own = |stage: &str| set(&format!("rudder-{stage}-unloaded={}", path("other.toml")));
    let own = Comparison::of("", vec![own("overhauled"), own("worn")]);
    assert_eq!((own.wear.len(), own.wear[0].from.as_str()), (1, "rudder-overhauled-unloaded"));
    assert!(files::read_set("te-early=x.toml").unwrap_err().to_string().contains("te-early-unloaded"));
}

/// Panics with the place of the first malformed markup.
pub fn assert_well_formed(name: &str, xml: &str) {
    let mut reader = quick_xml::Reader::from_str(xml);
    loop {
        match reader.read_event() {
            Ok(quick_xml::events::Event::Eof) => break,
            Ok(quick_xml::events::Event::Start(element) | quick_xml::events::Event::Empty(element)) => {
                assert!(element.attributes().all(|attribute| attribute.is_ok()), "{name}");
            }
            Ok(_) => {}
            Err(error) => panic!("{name} at byte {}: {error}", reader.error_position()),
        }
    }
}

#[test]
fn all_figures_are_drawn_and_well_formed_and_the_page_needs_nothing_else() {
    let files = comparison::files(tables(), Vec::new(), &Invocation::default()).unwrap();
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    for number in (6..=13).map(|number| number.to_string()).chain((1..=10).map(|number| format!("A{number}"))) {
        assert!(names.contains(&format!("figure-{number}.svg").as_str()), "{number}: {names:?}");
    }
    for (name, bytes) in &files {
        let text = std::str::from_utf8(bytes).unwrap();
        if name.ends_with(".svg") {
            assert_well_formed(name, text);
            assert!(!text.contains("NaN") && text.contains("prefers-color-scheme: dark"), "{name}");
        }
    }
    let page = std::str::from_utf8(&files.last().unwrap().1).unwrap();
    assert_eq!(names.last(), Some(&"compare.html"));
    // Its script and its clips are embedded.
    let others = page.replace("url(#", "");
    for foreign in ["src=", "href=", "<script ", "@import", "url("] {
        assert!(!others.contains(foreign), "{foreign}");
    }
    assert!(page.contains("generated record") && page.matches("<svg").count() > 40);
}

#[test]
fn given_sets_have_figures_of_their_own_and_none_of_experiments() {
    let set = |label: &str, index: usize| Set::new(label, Model::from_set(&actuator_fmu::parameters::table()[index]));
    let pair = Comparison::of("", vec![set("before", 0), set("after", 1)]);
    assert!(pair.statements.is_empty() && Verdict::Agrees.text() == "agrees");
    let names = |comparison: &Comparison| -> Vec<String> {
        comparison::files(comparison, Vec::new(), &Invocation::default())
            .unwrap()
            .into_iter()
            .map(|(name, _)| name)
            .collect()
    };
    let expected = ["responses.svg", "differences-against-the-first-set.svg", "compare.json", "compare.html"];
    assert_eq!(names(&pair), expected);
    let known = |name: &str| files::read_set(name).unwrap();
    let wear = names(&Comparison::of("", vec![known("te-early-unloaded"), known("te-late-unloaded")]));
    assert!(wear.contains(&"figure-10.svg".to_owned()) && wear.contains(&"figure-8.svg".to_owned()), "{wear:?}");
    assert!(!wear.contains(&"figure-A1.svg".to_owned()) && !wear.contains(&"figure-A5.svg".to_owned()), "{wear:?}");
}
