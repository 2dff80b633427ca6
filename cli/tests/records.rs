//! Records of users: which are accepted, which are refused and how.

use std::{
    fs,
    io::Write,
    path::Path,
    process::{Command as Program, Output},
};

use actuator_fmu::parameters::table;
use cli::files;
use identification::{
    frequency::{Method, estimate, welch::Welch},
    signal::{
        format::{Format, PositionUnit},
        sampling::Sampling,
    },
};

use sha2::{Digest, Sha256};

use crate::generated::Generated;

fn actuator(folder: &Path, arguments: &[&str]) -> Output {
    Program::new(env!("CARGO_BIN_EXE_actuator")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A short valid record, row by row, to be corrupted.
fn rows() -> Vec<String> {
    let record = Generated { duration_s: 11.0, ..Generated::new(table()[0].base) }.record();
    let mut csv = Vec::new();
    record.write_csv(&mut csv).unwrap();
    text(&csv).lines().map(str::to_owned).collect()
}

#[test]
fn each_bad_record_is_refused_with_file_line_and_remedy_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let spoil = |line: usize, row: &str| {
        let mut rows = rows();
        rows[line - 1] = row.to_owned();
        rows.join("\n")
    };
    let still: Vec<String> = rows()
        .iter()
        .enumerate()
        .map(|(index, row)| if index == 0 { row.clone() } else { format!("{},0.5,0", row.split(',').next().unwrap()) })
        .collect();
    let cases = [
        (spoil(1, "time,command,angle"), "bad.csv:1: column `position`", "--columns position=NAME"),
        (spoil(40, "0.19,NaN,0"), "bad.csv:40: column `command`", "repair or remove the row"),
        (spoil(40, "0.19,0.1,inf"), "bad.csv:40: column `position`", "repair or remove the row"),
        (spoil(40, "0.19,,0"), "bad.csv:40: column `command`", "repair or remove the row"),
        (spoil(40, "0.19,ein Grad,0"), "bad.csv:40: column `command`", "repair or remove the row"),
        (spoil(40, "0.1,0,0"), "bad.csv:40: column `time`", "sort the rows"),
        (spoil(40, "0.19,0"), "bad.csv:40: row", "repair or remove the row"),
        (rows()[..60].join("\n"), "bad.csv:60: samples", "record for longer"),
        (still.join("\n"), "bad.csv:2201: column `command`", "choose a record with excitation"),
        (
            String::new(),
            "bad.csv:1: columns `time`, `command`, `position`: found an empty file",
            "a header row and 100 rows",
        ),
        (spoil(1, "time;command;position"), "bad.csv:2: row: found 1 values", "repair or remove the row"),
        (spoil(1, "time,command,command"), "bad.csv:1: column `command`: found several", "rename or remove"),
        (spoil(1, "ti\0me,command,position"), "bad.csv:1: column `time`", "UTF-8"),
        (spoil(40, "0.19,x,0").replace('\n', "\r\n"), "bad.csv:40: column `command`", "repair or remove the row"),
        (spoil(40, "0.19,0").replace('\n', "\r\n"), "bad.csv:40: row", "repair or remove the row"),
        (spoil(40, "# a pause\n\n0.19,x,0"), "bad.csv:42: column `command`", "repair or remove the row"),
    ];
    for (bad, place, remedy) in cases {
        fs::write(folder.path().join("bad.csv"), bad).unwrap();
        for command in [
            ["fit", "bad.csv", "-o", "model.toml"].as_slice(),
            &["frf", "bad.csv", "-o", "frf.csv"],
            &["frf", "bad.csv", "--method", "report", "-o", "frf.csv"],
        ] {
            let output = actuator(folder.path(), command);
            let message = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{message}");
            assert!(message.contains(place) && message.contains(remedy), "{command:?}: {message}");
            assert!(output.stdout.is_empty());
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "something was written by {command:?}");
        }
    }
    let missing = actuator(folder.path(), &["fit", "none.csv"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(text(&missing.stderr).contains("none.csv: record"), "{}", text(&missing.stderr));
}

#[test]
fn a_header_that_is_not_utf8_is_refused_with_the_numbers_of_columns_which_then_serve() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = rows()[1..].iter().map(|row| format!("{row}\n").replace(',', ";").replace('.', ",")).collect();
    let inspect = |header: &[u8], more: &[&str]| {
        fs::write(folder.path().join("record.csv"), [header, rows.as_bytes()].concat()).unwrap();
        actuator(folder.path(), &[&["inspect", "record.csv"], more].concat())
    };
    let latin = b"Zeit [s];Sollwert [\xb0];Ist [\xb0]\n";
    let numbers = "time=1,command=2,position=3";
    let message = text(&inspect(latin, &[]).stderr);
    assert!(message.contains("UTF-8 text, or name columns by their numbers") && message.contains(numbers), "{message}");
    let message = text(&inspect("Zeit;Soll;Ist\n".as_bytes(), &[]).stderr);
    assert!(message.contains("--columns time=NAME,command=NAME,position=NAME, or by their numbers"), "{message}");
    assert!(inspect(latin, &["--columns", numbers]).status.success());
    assert!(text(&actuator(folder.path(), &["fit", "--help"]).stdout).contains(numbers));
}

#[test]
fn text_in_utf16_is_read_with_its_mark_or_without_packed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, rows().join("\n")).unwrap();
    let plain = files::read_record(&path, &Format::default()).unwrap();
    let marked = format!("\u{feff}{}\r\n", rows().join("\r\n"));
    for text in [marked.as_str(), &marked['\u{feff}'.len_utf8()..]] {
        for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
            let bytes: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
            let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(&bytes).unwrap();
            for bytes in [bytes, encoder.finish().unwrap()] {
                fs::write(&path, &bytes).unwrap();
                let record = files::read_record(&path, &Format::default()).unwrap();
                assert!(record.time() == plain.time() && record.position() == plain.position());
                let expected: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
                assert_eq!(record.sha256(), expected);
                assert_eq!(record.understood(), ["text in UTF-16"]);
            }
        }
    }
    let command = "\u{feff}time,command\r\n0,1\r\n0.1,2\r\n".encode_utf16().flat_map(u16::to_le_bytes);
    fs::write(&path, command.collect::<Vec<u8>>()).unwrap();
    assert_eq!(files::read_command(&path, &Format::default()).unwrap().command, [1.0, 2.0]);
    let mut spoilt = rows();
    spoilt[39] = "0.19,x,0".into();
    let spoilt = spoilt.join("\n").encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    fs::write(&path, spoilt).unwrap();
    let message = files::read_record(&path, &Format::default()).unwrap_err().to_string();
    assert!(message.contains("record.csv:40: column `command`: found `x`"), "{message}");
}

#[test]
fn times_of_loggers_are_read_and_dates_of_which_the_order_matters_and_is_not_plain_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let read = |stamp: &dyn Fn(usize) -> String| {
        let row = |index: usize| format!("{};{};{}\n", stamp(index), index % 2, index % 3);
        fs::write(&path, "time;command;position\n".to_owned() + &(0..200).map(row).collect::<String>()).unwrap();
        files::read_record(&path, &Format::default())
    };
    // 100 samples before midnight or noon and 100 after it, 5 ms apart.
    let second =
        |index: usize| format!("{}.{:03}", if index < 100 { "59:59" } else { "00:00" }, (500 + 5 * index) % 1000);
    let late = |index: usize| index >= 100;
    let dotted = |index| {
        format!("{}.11.2026 {}:{}", 24 + usize::from(late(index)), if late(index) { "00" } else { "23" }, second(index))
    };
    let comma = |index| dotted(index).split_at(19).0.to_owned() + "," + &dotted(index)[20..];
    let month_first = |index| {
        format!("11/{}/2026 {}:{}", 24 + usize::from(late(index)), if late(index) { "00" } else { "23" }, second(index))
    };
    let noon = |index| {
        format!(
            "11/03/2026 {}:{} {}",
            if late(index) { "12" } else { "11" },
            second(index),
            if late(index) { "PM" } else { "AM" }
        )
    };
    let one_day = |index: usize| format!("11/03/2026 12:00:0{}.{:03}", 5 * index / 1000, 5 * index % 1000);
    let stamps: [&dyn Fn(usize) -> String; 5] = [&dotted, &comma, &month_first, &noon, &one_day];
    for stamp in stamps {
        let record = read(stamp).unwrap();
        let is_even = |(index, time): (usize, &f64)| (time - 0.005 * index as f64).abs() < 1e-9;
        assert!(record.time().iter().enumerate().all(is_even), "{}", stamp(150));
    }
    let message = read(&|index| month_first(index).replacen("/2", "/0", 1)).unwrap_err().to_string();
    assert!(message.contains("record.csv:102: column `time`: found `11/05/2026 00:00:00.000`"), "{message}");
    assert!(message.contains("tell the day from the month") && message.contains("2026-11-24"), "{message}");
}

#[test]
fn a_line_that_tells_the_separator_is_no_header_and_other_text_above_it_is_to_be_removed() {
    let folder = tempfile::tempdir().unwrap();
    let rows: Vec<String> = rows()[1..].iter().map(|row| row.replace(',', ";").replace('.', ",")).collect();
    let inspect = |above: &str, rows: &[String]| {
        let header = "Zeit;Soll;Ist";
        fs::write(folder.path().join("record.csv"), [above, header, "\n", &rows.join("\n")].concat()).unwrap();
        actuator(folder.path(), &["inspect", "record.csv", "--columns", "time=Zeit,command=Soll,position=Ist"])
    };
    assert!(inspect("sep=;\r\n", &rows).status.success());
    let mut spoilt = rows.clone();
    spoilt[37] = "0,19;x;0".into();
    assert!(text(&inspect("sep=;\n", &spoilt).stderr).contains("record.csv:40: column `Soll`"));
    let message = text(&inspect("Messung 7\nvom Montag\n", &rows).stderr);
    assert!(message.contains("remove the lines above the header") && !message.contains("--columns"), "{message}");
}

#[test]
fn rows_without_values_end_a_file_and_are_refused_within_it() {
    let folder = tempfile::tempdir().unwrap();
    let inspect = |rows: &[String]| {
        fs::write(folder.path().join("record.csv"), rows.join("\r\n")).unwrap();
        actuator(folder.path(), &["inspect", "record.csv"])
    };
    let mut ended = rows();
    ended.extend([",,".into(), " , ,".into(), "  ".into(), String::new()]);
    let run = inspect(&ended);
    assert!(run.status.success() && text(&run.stdout).contains("3 rows without values at its end"), "{run:?}");
    let mut within = rows();
    within.splice(37..37, [",,".into(), ",,".into()]);
    let run = inspect(&within);
    assert!(text(&run.stderr).contains("record.csv:38: row: found no values"), "{run:?}");
}

#[test]
fn a_workbook_is_called_one_and_all_missing_columns_are_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let inspect = |file: &str, bytes: &[u8]| {
        fs::write(folder.path().join(file), bytes).unwrap();
        text(&actuator(folder.path(), &["inspect", file]).stderr)
    };
    let workbook = inspect("run.xlsx", b"PK\x03\x04\x14\0\x06\0\x08\0\0\0!\0");
    assert!(workbook.contains("run.xlsx: file: found an archive") && workbook.contains("as CSV"), "{workbook}");
    let renamed = rows().join("\n").replace("time,command,position", "t_s,cmd,position");
    let message = inspect("record.csv", renamed.as_bytes());
    assert!(message.contains("record.csv:1: columns `time`, `command`: found only t_s, cmd, position"), "{message}");
    assert!(message.contains("--columns time=NAME,command=NAME"), "{message}");
}

#[test]
fn what_is_given_in_the_place_of_another_is_called_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("unit.fmu"), b"PK\x03\x04\x14\0").unwrap();
    fs::write(folder.path().join("record.csv"), rows().join("\n")).unwrap();
    let simulate = |model: &str, command: &str| text(&actuator(folder.path(), &["simulate", model, command]).stderr);
    let message = simulate("unit.fmu", "record.csv");
    assert!(message.contains("unit.fmu: model file: found an archive") && message.contains("--fmu"), "{message}");
    let message = simulate("record.csv", "te-early-unloaded");
    assert!(
        message.contains("record.csv: model file: found a CSV file") && message.contains("actuator fit"),
        "{message}"
    );
    let message = simulate("te-early-unloaded", "te-late-unloaded");
    assert!(message.contains("te-late-unloaded: command file") && message.contains("the name of a set"), "{message}");
}

#[test]
fn a_record_that_cannot_be_read_hides_no_other_and_leaves_no_page() {
    let folder = tempfile::tempdir().unwrap();
    let mut spoilt = rows();
    spoilt[37] = "0.19,x,0".into();
    for (name, rows) in [("good.csv", rows()), ("bad.csv", spoilt)] {
        fs::write(folder.path().join(name), rows.join("\n")).unwrap();
    }
    let run = actuator(folder.path(), &["inspect", "bad.csv", "good.csv", "-o", "page"]);
    assert_eq!(run.status.code(), Some(2));
    assert!(text(&run.stdout).contains("good.csv: usable") && text(&run.stderr).contains("bad.csv:38"));
    assert!(!folder.path().join("page").exists());
}

#[test]
fn comment_lines_are_read_wherever_they_stand() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let plain = rows();
    for (index, comment) in ["# Ende", "% Ende", "# a, b, c", "% \"a, b, c"].into_iter().enumerate() {
        let mut rows = plain.clone();
        assert!(rows[..2000].join("\n").len() > 1 << 16, "far behind the beginning");
        if index % 2 == 0 {
            rows.insert(2000, comment.to_owned());
        }
        rows.push(comment.to_owned());
        fs::write(&path, rows.join("\n")).unwrap();
        assert_eq!(files::read_record(&path, &Format::default()).unwrap().len(), plain.len() - 1, "{comment}");
    }
}

#[test]
fn a_row_of_units_is_held_against_the_units_in_which_a_record_is_read() {
    let rows: String = (0..300).map(|n| format!("{},{},{}\n", 0.005 * f64::from(n), n % 7, n % 5)).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let read = |units: &str, unit: PositionUnit| {
        fs::write(&path, format!("time,command,position\n{units}\n{rows}")).unwrap();
        let record = files::read_record(&path, &Format { unit, ..Format::default() });
        record.map(|record| record.len()).map_err(|error| error.to_string())
    };
    assert_eq!(read("s,mm,mm", PositionUnit::Millimetre), Ok(300));
    assert_eq!(read("s,V,deg", PositionUnit::Degree), Ok(300));
    let refused = read("s,mm,mm", PositionUnit::Degree).unwrap_err();
    assert!(refused.contains("run.csv:2") && refused.contains("--unit mm"), "{refused}");
    assert!(read("ms,deg,deg", PositionUnit::Degree).unwrap_err().contains("--time-unit ms"));
}

#[test]
fn columns_and_units_are_as_declared() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rad.csv");
    let rows: Vec<String> =
        (0..200).map(|i| format!("{},{},{},7,{i}", f64::from(i) * 0.02, f64::from(i % 2), 0.5)).collect();
    fs::write(&path, format!("t_s, cmd_rad ,pos_rad,other,force\n{}\n", rows.join("\n"))).unwrap();
    let columns = "time=t_s,command=cmd_rad,position=pos_rad,load=force".parse().unwrap();
    let record =
        files::read_record(&path, &Format { columns, unit: PositionUnit::Radian, ..Format::default() }).unwrap();
    assert_eq!(record.unit(), PositionUnit::Radian);
    assert_eq!([record.command()[1], record.position()[7]], [1.0, 0.5]);
    let degrees = record.clone().in_unit(PositionUnit::Degree).unwrap();
    assert!(
        (degrees.command()[1] - 57.295_779_513).abs() < 1e-9 && (degrees.position()[7] - 28.647_889_757).abs() < 1e-9
    );
    let message = record.clone().in_unit(PositionUnit::Metre).unwrap_err().to_string();
    assert!(message.contains("rad.csv") && message.contains("an angle") && message.contains("a length"), "{message}");
    assert_eq!(record.load().unwrap().len(), 200);
    assert!(matches!(record.sampling(), Sampling::Even(interval) if (interval - 0.02).abs() < 1e-12));
    assert_eq!(record.sha256().len(), 64);
    for bad in ["time", "time=", "speed=x", "time=t,"] {
        assert!(bad.parse::<identification::signal::format::Columns>().is_err(), "{bad}");
    }
    let output = actuator(folder.path(), &["fit", "rad.csv", "--unit", "furlong"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("rad, deg, mm, m or 1"));
}

#[test]
fn a_stream_makes_the_response_of_the_whole_record() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let record = Generated { noise: 0.02, ..Generated::new(table()[2].base) }.record();
    let mut csv = Vec::new();
    record.write_csv(&mut csv).unwrap();
    fs::write(&path, csv).unwrap();
    let mut welch = Welch::default();
    let mut stream = files::open_stream(&path, &Format::default(), 777).unwrap();
    welch.add_stream(&mut stream).unwrap();
    let whole = files::read_record(&path, &Format::default()).unwrap();
    assert_eq!(stream.sha256(), whole.sha256());
    assert_eq!(welch.finish().unwrap(), estimate(&[whole], Method::Report).unwrap());
}

#[test]
fn the_hash_of_a_record_is_that_of_its_file_compressed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let plain = format!("\u{feff}{}\n", rows().join("\n"));
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(plain.as_bytes()).unwrap();
    for (name, bytes) in [("plain.csv", plain.into_bytes()), ("packed.csv.gz", encoder.finish().unwrap())] {
        let path = folder.path().join(name);
        fs::write(&path, &bytes).unwrap();
        let expected: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(files::read_record(&path, &Format::default()).unwrap().sha256(), expected, "{name}");
        let mut stream = files::open_stream(&path, &Format::default(), 500).unwrap();
        while stream.next_block().unwrap().is_some() {}
        assert_eq!(stream.sha256(), expected, "{name}");
    }
}
