//! Valid files, from which others are derived.

use actuator_fmu::{
    fmu::Start,
    parameters::{Model, find},
};
use fmu_build::Archive;

use super::disturbed::compressed;

/// Records in several dialects.
pub fn records() -> Vec<Vec<u8>> {
    let rows = |separator: &str, point: &str, count: usize, time: &dyn Fn(usize) -> String| -> String {
        (0..count)
            .map(|index| {
                let value = (index as f64 * 0.3).sin();
                let numbers = [value, 0.9 * value].map(|number| format!("{number:.4}").replace('.', point));
                format!("{}{separator}{}\n", time(index).replace('.', point), numbers.join(separator))
            })
            .collect()
    };
    let seconds = |index: usize| format!("{:.3}", index as f64 * 0.005);
    let plain = format!("time,command,position\n{}", rows(",", ".", 150, &seconds));
    let german = format!("# Prüfstand 3\ntime;command;position\ns;deg;deg\n{}", rows(";", ",", 120, &seconds));
    let bare = rows("\t", ".", 130, &seconds);
    let stamped = format!(
        "time,command,position\n{}",
        rows(",", ".", 110, &|index| format!("12:00:{:06.3}", index as f64 * 0.005))
    );
    let loaded =
        plain.lines().enumerate().map(|(row, line)| format!("{line},{}\n", if row == 0 { "load" } else { "0.5" }));
    let loaded: String = loaded.collect();
    let few = "time,command,position\n0,0,0\n1,1,1\n".to_owned();
    let mut all: Vec<Vec<u8>> = [plain.clone(), german, bare, stamped, loaded, few].map(String::into_bytes).into();
    all.push(compressed(plain.as_bytes()));
    all.push([b"\xef\xbb\xbf", plain.as_bytes()].concat());
    all
}

/// Commands.
pub fn commands() -> Vec<Vec<u8>> {
    ["time,command\n0,0\n0.005,1\n0.2,1\n", "time;command\n0;0\n0,5;1\n", "0\t0\n1\t1\n2\t0\n"]
        .map(|text| text.as_bytes().to_vec())
        .into()
}

/// Model files, of the tables and of a user.
pub fn models() -> Vec<Vec<u8>> {
    let set = find("us-late-loaded".parse().expect("a name")).expect("a set");
    let own = r#"
[model]
name = "Rudder"
unit = "mm"
[base]
order = 2
k = { value = 1.02, unit = "mm/mm", std_error = 0.01 }
omega = { value = 165.3, unit = "rad/s" }
zeta = { value = 0.56, unit = "1" }
[effects.rate_limit]
up = { value = 120.0, unit = "mm/s" }
down = { value = 100.0, unit = "mm/s" }
[effects.backlash]
gap = { value = 0.3, unit = "mm" }
[provenance]
records = ["sweep.csv"]
"#;
    vec![Model::from_set(set).to_toml().expect("a text").into_bytes(), own.as_bytes().to_vec()]
}

/// Manifests of campaigns.
pub fn manifests() -> Vec<Vec<u8>> {
    let whole = r#"
[campaign]
name = "Bench"
method = "likelihood"
order = "auto"
delay_s = 0.0
unit = "deg"
time_unit = "s"
hold = true
columns = { command = "cmd" }
[[record]]
file = "a.csv"
surface = "trailing_edge"
stage = "early"
load_case = "unloaded"
mach = 0.5
[[record]]
name = "second"
file = "b.csv"
surface = "rudder"
stage = "late"
load_case = "loaded"
unit = "rad"
hold = false
"#;
    let short = "[[record]]\nfile = \"a.csv\"\nsurface = \"x\"\nstage = \"y\"\nload_case = \"loaded\"\n";
    vec![whole.as_bytes().to_vec(), short.as_bytes().to_vec()]
}

/// FMUs with this program's description, with a short one, and with zip bombs.
pub fn archives() -> Vec<Vec<u8>> {
    let description = cli::description::xml(&Start::default());
    let short = r#"<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="a" guid="{1}"><CoSimulation modelIdentifier="a"/>
<ModelVariables><ScalarVariable name="command" valueReference="0" causality="input"><Real start="0"/></ScalarVariable></ModelVariables>
<ModelStructure/></fmiModelDescription>"#;
    let doctype = r#"<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;">]>
<fmiModelDescription fmiVersion="2.0" modelName="&d;&d;&d;&d;" guid="&d;"/>"#;
    let deep = format!("<fmiModelDescription fmiVersion=\"2.0\">{}", "<a>".repeat(50_000));
    let archive = |text: &str, others: &[(&str, &[u8])]| {
        let mut archive = Archive::new();
        archive.insert("modelDescription.xml", text).expect("a name");
        others.iter().for_each(|(name, bytes)| archive.insert(*name, *bytes).expect("a name"));
        archive.to_bytes().expect("an archive")
    };
    let zeros = vec![0; 1 << 20];
    vec![
        archive(
            &description,
            &[("binaries/linux64/BactActuator.so", b"not a library"), ("documentation/index.html", b"<p>")],
        ),
        archive(short, &[("resources/model.toml", b"[base]")]),
        archive(short, &[]),
        archive(doctype, &[]),
        archive(&deep, &[]),
        archive(short, &[("resources/zeros", &zeros)]),
    ]
}
