//! Pictures of what differences depend on: position, rate, time since a reversal, amplitude; and of what each explanation leaves.

use identification::{
    diagnose::{Verdict, regressors::since_reversal_s},
    digits::with_unit,
    signal::record::Record,
};

use crate::{
    gap::{
        Measured,
        dependence::{Class, Pair, Swings, classes, over_amplitude, rates},
    },
    report::plot::{Axis, Mark, Panel, Plot, Row, Rows, Style},
    workflow::account::Account,
};

/// Points of a cloud: more would hide each other.
const MOST_POINTS: usize = 700;

/// Share of the samples that a picture over the time since a reversal shows: what comes later is rest.
const SHOWN_SHARE: f64 = 0.95;

/// An axis of the motion.
struct Dependence {
    caption: &'static str,
    label: String,
    /// Its values at the times of each check record.
    values: Vec<Vec<f64>>,
    /// Whether differences count in the direction of the motion, so that those of both directions do not cancel.
    is_along_motion: bool,
}

/// Caption, remark and picture of the differences over each axis, and of gain and lag over the amplitude.
pub fn pictures(account: &Account) -> Vec<(String, String, Plot)> {
    let first = account.fit.len();
    let of = |function: &dyn Fn(&Record, &[f64]) -> Vec<f64>| -> Vec<Vec<f64>> {
        let motions = account.check.iter().zip(&account.after.simulated[first..]);
        motions.map(|(record, position)| function(record, position)).collect()
    };
    let unit = account.diagnosis.after.unit();
    let axes = [
        Dependence {
            caption: "Residual over position",
            label: with_label("position", unit.name()),
            values: of(&|_, position| position.to_vec()),
            is_along_motion: false,
        },
        Dependence {
            caption: "Residual over rate",
            label: with_label("rate", unit.of_rate()),
            values: of(&|record, position| rates(record.time(), position)),
            is_along_motion: false,
        },
        Dependence {
            caption: "Residual over the time since a reversal",
            label: "time since a reversal, s".into(),
            values: of(&|record, position| since_reversal_s(record.time(), &rates(record.time(), position))),
            is_along_motion: true,
        },
    ];
    let directions = of(&|record, position| directions(&rates(record.time(), position)));
    let charts = axes.iter().filter_map(|axis| {
        let counted = if axis.is_along_motion { " Positive in the direction of motion." } else { "" };
        let remark = format!("Check records; lines: mean and rms over equal numbers of samples.{counted}");
        Some((axis.caption.to_owned(), remark, over(account, axis, &directions)?))
    });
    charts.chain(amplitude(account)).collect()
}

/// 1 where the motion goes up, -1 where it goes down; at rest as it went before.
fn directions(rate: &[f64]) -> Vec<f64> {
    let mut direction = 1.0;
    rate.iter()
        .map(|rate| {
            if *rate != 0.0 {
                direction = rate.signum();
            }
            direction
        })
        .collect()
}

fn with_label(name: &str, unit: &str) -> String {
    if unit == "1" { name.to_owned() } else { format!("{name}, {unit}") }
}

/// Place on an axis and difference, of all samples of the check records that were measured after settling.
fn points(account: &Account, measured: &Measured, axis: &Dependence, directions: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let first = account.fit.len();
    let of_record = |(place, record): (usize, &Record)| {
        let (_, settling) = account.diagnosis.starts[first + place];
        let residuals = &measured.residuals[first + place];
        let sign = |sample: usize| if axis.is_along_motion { directions[place][sample] } else { 1.0 };
        let counted = (settling..record.len()).filter(|sample| record.is_measured(*sample));
        let point = |sample: usize| [axis.values[place][sample], sign(sample) * residuals[sample - settling]];
        counted.map(point).collect::<Vec<[f64; 2]>>()
    };
    account.check.iter().enumerate().flat_map(of_record).collect()
}

/// Without what is rest: the samples longest after a reversal.
fn in_motion(points: &mut Vec<[f64; 2]>) {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count
    points.truncate((SHOWN_SHARE * points.len() as f64) as usize);
}

fn over(account: &Account, axis: &Dependence, directions: &[Vec<f64>]) -> Option<Plot> {
    let of = |measured: &Measured| points(account, measured, axis, directions);
    let (mut before, mut after) = (of(&account.before), of(&account.after));
    if axis.is_along_motion {
        in_motion(&mut before);
        in_motion(&mut after);
    }
    let (mean_before, mean_after) = (classes(&before), classes(&after));
    if mean_before.len() < 2 {
        return None;
    }
    let cloud = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().step_by(points.len().div_ceil(MOST_POINTS).max(1)).copied().collect()
    };
    let line = |classes: &[Class], of: fn(&Class) -> f64| classes.iter().map(|class| [class.at, of(class)]).collect();
    let unit = account.unit();
    let [cloud_before, cloud_after] = [&before, &after].map(|points| cloud(points));
    let values = cloud_before.iter().chain(&cloud_after).map(|point| point[1]);
    let differences = Panel::new(Axis::around(with_label("difference", unit), values))
        .marks(Style::colour(1), "", cloud_before.clone())
        .marks(Style::colour(0), "", cloud_after.clone())
        .line(Style::colour(1), "before", line(&mean_before, |class| class.mean))
        .line(Style::colour(0), "after", line(&mean_after, |class| class.mean))
        .height(170.0);
    let noise = account.diagnosis.noise.rms;
    let sizes = mean_before.iter().chain(&mean_after).map(|class| class.rms).chain([0.0, 1.1 * noise]);
    let sizes = Panel::new(Axis::around(with_label("rms", unit), sizes))
        .line(Style::colour(1), "before", line(&mean_before, |class| class.rms))
        .line(Style::colour(0), "after", line(&mean_after, |class| class.rms))
        .limit(noise, "noise")
        .height(100.0);
    let places = before.iter().map(|point| point[0]);
    let (least, greatest) =
        places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    Some(Plot::new("", Axis::linear(&axis.label, least, greatest)).panel(differences).panel(sizes))
}

/// Gain and lag of the measurement against the FMUs before and after, over the amplitude of the motion.
fn amplitude(account: &Account) -> Option<(String, String, Plot)> {
    let records: Vec<&Record> = account.fit.iter().chain(&account.check).collect();
    let of = |measured: &Measured| -> Vec<Swings> {
        let pairs: Vec<Pair<'_>> = records
            .iter()
            .zip(&measured.simulated)
            .zip(&account.diagnosis.starts)
            .filter(|((record, _), _)| (0..record.len()).all(|sample| record.is_measured(sample)))
            .map(|((record, simulated), (_, settling))| Pair {
                time: &record.time()[*settling..],
                measured: &record.position()[*settling..],
                simulated: &simulated[*settling..],
            })
            .collect();
        over_amplitude(&pairs)
    };
    let (before, after) = (of(&account.before), of(&account.after));
    if before.is_empty() {
        return None;
    }
    let series = [(Style::colour(1), "before", &before), (Style::colour(0).mark(Mark::Square), "after", &after)];
    let panel = |label: &str, neutral: f64, of: &dyn Fn(&Swings) -> [f64; 2]| {
        let values = before.iter().chain(&after).map(of).flat_map(|[value, error]| [value - error, value + error]);
        let values: Vec<f64> = values.chain([neutral]).collect();
        series.iter().fold(
            Panel::new(Axis::around(label, values)).limit(neutral, ""),
            |panel, (style, name, swings)| {
                let bars = swings.iter().map(|one| [one.amplitude, of(one)[0], of(one)[1]]).collect();
                let line: Vec<[f64; 2]> = swings.iter().map(|one| [one.amplitude, of(one)[0]]).collect();
                panel.error_bars(*style, bars).marks(*style, "", line.clone()).line(*style, *name, line)
            },
        )
    };
    let gain = panel("gain", 1.0, &|swings| swings.gain);
    let lag = panel("lag, ms", 0.0, &|swings| swings.lag_s.map(|lag| 1e3 * lag));
    let greatest = before.iter().chain(&after).map(|swings| swings.amplitude).fold(0.0, f64::max);
    let axis = Axis::around(with_label("amplitude of a swing", account.unit()), [0.0, greatest]);
    Some((
        "Gain and lag over amplitude".to_owned(),
        "All records: gain and lag of the measurement relative to the FMU, between its reversals; bars: one standard error, for white noise."
            .to_owned(),
        Plot::new("", axis).panel(gain).panel(lag),
    ))
}

/// Explanations that a picture of the evidence shows.
const EXPLANATIONS: usize = 14;

/// A bar that is longer than so many times what the given model leaves is cut.
const LONGEST: f64 = 2.0;

/// What each explanation leaves of the records that it was not fitted to.
pub fn evidence(account: &Account) -> Option<Plot> {
    let diagnosis = &account.diagnosis;
    let unit = account.unit();
    let row = |name: String, rms: f64| Row { name, text: with_unit(rms, 3, unit), values: vec![Some(rms)] };
    let candidates = diagnosis.candidates.iter().take(EXPLANATIONS);
    let mut rows: Vec<Row> = candidates.map(|candidate| row(spoken(&candidate.name), candidate.check_rms)).collect();
    let leads = diagnosis.leads.iter().filter(|_| diagnosis.verdict != Verdict::Named);
    rows.extend(leads.filter_map(|lead| Some(row(format!("lead: {}", lead.name), lead.check_rms?))));
    rows.retain(|row| row.values.iter().flatten().all(|value| value.is_finite()));
    let given = account.before.gap.check_rms;
    let greatest = rows.iter().flat_map(|row| &row.values).flatten().copied().fold(diagnosis.noise.rms, f64::max);
    let axis = Axis::around(format!("residual on check records, {unit} rms"), [0.0, greatest.min(LONGEST * given)]);
    let series = vec![(Style::colour(0), String::new())];
    let limit = Some((diagnosis.noise.rms, "noise".to_owned()));
    (!rows.is_empty())
        .then(|| Plot::new("Residual of each explanation", axis).panel(Panel::of_rows(Rows { series, rows, limit })))
}

/// A hypothesis as a picture names it.
fn spoken(name: &str) -> String {
    match name {
        "none" => "none: the given model".to_owned(),
        "parameter_shift" => "parameter_shift: the refitted base".to_owned(),
        name => name.to_owned(),
    }
}
