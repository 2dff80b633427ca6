//! `actuator fit`

use std::{fmt::Write as _, path::PathBuf};

use crate::{
    files,
    invocation::Invocation,
    output,
    progress::{Progress, estimate::Expectation},
    report::fit as report,
};
use actuator_fmu::{Error, Result, parameters::Order};
use clap::ValueEnum;
use identification::{
    digits::with_unit,
    estimate::{
        self, DelayChoice, Estimate, Evidence, Fit, LagPrior, OrderChoice, PhaseUnit, Pole, RecordFit, Settings,
        StartResult,
    },
    inspect::ExpectedGain,
};
use serde::Serialize;

use super::records::RecordArguments;

/// Identify a parameter set from records
#[derive(clap::Args)]
#[command(
    after_help = "Several records are fitted together. The model file is what simulate, build and diagnose take.\n\n\
Examples:\n  actuator fit sweep.csv random.csv -o model.toml\n  \
actuator fit sweep.csv --method report --phase-unit rad -o model.toml\n  \
actuator fit chirp.csv --columns time=t_s,command=cmd_mm,position=pos_mm --unit mm --order 2 --delay free \
--check other.csv -o model.toml --report fit.html"
)]
pub struct Arguments {
    #[command(flatten)]
    records: RecordArguments,
    /// Estimation method
    #[arg(long, value_enum, default_value_t = MethodArgument::Likelihood)]
    method: MethodArgument,
    /// Second order (eq. (6)), third (eq. (1)), or the order favoured by the evidence
    #[arg(long, value_enum, default_value_t = OrderArgument::Auto)]
    order: OrderArgument,
    /// Delay between command and actuator, s, or `free` to estimate it
    #[arg(long, value_name = "free|S", default_value = "0", value_parser = delay)]
    delay: DelayChoice,
    /// Unit of phase errors in the cost of --method report
    #[arg(long, value_enum, default_value_t = PhaseArgument::Deg)]
    phase_unit: PhaseArgument,
    /// If the records do not determine p, do not assume that its lag 1/p is small
    #[arg(long)]
    no_prior: bool,
    /// State how well the model predicts this record, which is not fitted; may be given several times
    #[arg(long, value_name = "RECORD.csv")]
    check: Vec<PathBuf>,
    /// Write the model here
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Write a page here: parameters, measured and modelled response, residual, prediction of --check records
    #[arg(long, value_name = "PAGE.html")]
    report: Option<PathBuf>,
    /// Name of the actuator, for the model file and its FMU [default: MODEL.toml without its extension]
    #[arg(long, value_name = "TEXT")]
    name: Option<String>,
    /// Date for the model file
    #[arg(long, value_name = "TEXT")]
    date: Option<String>,
    /// Overwrite MODEL.toml and PAGE.html
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodArgument {
    /// Maximum likelihood on the records
    Likelihood,
    /// The report's: weighted errors of magnitude and phase
    Report,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OrderArgument {
    /// Second
    #[value(name = "2")]
    Second,
    /// Third
    #[value(name = "3")]
    Third,
    /// By evidence
    Auto,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PhaseArgument {
    /// Degrees
    Deg,
    /// Radians
    Rad,
}

fn delay(text: &str) -> std::result::Result<DelayChoice, String> {
    if text == "free" {
        return Ok(DelayChoice::Free);
    }
    match text.parse::<f64>() {
        Ok(delay) if delay.is_finite() && delay >= 0.0 => Ok(DelayChoice::Declared(delay)),
        _ => Err("`free` or a number of seconds from 0 on".into()),
    }
}

#[derive(Serialize)]
struct Json<'a> {
    method: estimate::Method,
    order: u8,
    estimates: &'a [Estimate],
    correlations: &'a [Vec<f64>],
    p: Pole,
    delay_s: f64,
    converged: bool,
    ending: &'a str,
    at_bound: &'a [String],
    not_identifiable: &'a [String],
    unit: &'a str,
    residual_rms: f64,
    innovation_rms: f64,
    noise_order: Option<usize>,
    effective_samples: f64,
    records: &'a [RecordFit],
    checks: &'a [RecordFit],
    evidence: &'a [Evidence],
    starts: &'a [StartResult],
    notes: &'a [String],
    warnings: &'a [String],
    model: String,
    output: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, invocation: &Invocation) -> Result<()> {
    let mut written = arguments.output.iter().chain(&arguments.report);
    written.try_for_each(|path| files::refuse_existing(path, arguments.force))?;
    if let Some(path) = arguments.output.as_ref().filter(|path| arguments.report.as_ref() == Some(path)) {
        return Err(Error::new("output file", "one file for the model and the page", "two").at(path, None));
    }
    let progress = Progress::new("reading the records", Expectation::Usual(0.0));
    let (records, others, warnings) = arguments.records.read_admitted(&arguments.check, ExpectedGain::Positive)?;
    progress.step("fitting", Expectation::shares(None));
    let settings = Settings {
        method: match arguments.method {
            MethodArgument::Likelihood => estimate::Method::Likelihood,
            MethodArgument::Report => estimate::Method::Report,
        },
        order: match arguments.order {
            OrderArgument::Second => OrderChoice::Second,
            OrderArgument::Third => OrderChoice::Third,
            OrderArgument::Auto => OrderChoice::Auto,
        },
        delay: arguments.delay,
        phase_unit: match arguments.phase_unit {
            PhaseArgument::Deg => PhaseUnit::Degree,
            PhaseArgument::Rad => PhaseUnit::Radian,
        },
        lag_prior: if arguments.no_prior { LagPrior::Flat } else { LagPrior::Small },
        ..Settings::default()
    };
    let mut fit = estimate::fit_reporting(&records, &settings, Some(&|done| progress.share(done.share)))?;
    fit.model.provenance.date.clone_from(&arguments.date);
    let stem = || arguments.output.as_deref()?.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    fit.model.identity.name = arguments.name.clone().or_else(stem);
    let checks = others.iter().map(|record| fit.prediction_of(record)).collect::<Result<Vec<_>>>()?;
    if let Some(method) = &mut fit.model.provenance.method {
        for check in &checks {
            let rms = with_unit(check.residual_rms, 4, fit.unit);
            let _ = write!(method, "; predicts {} to {rms} rms", check.source);
        }
    }
    drop(progress);
    let toml = fit.model.to_toml()?;
    let page = report::Account {
        fit: &fit,
        records: &records,
        others: &others,
        checks: &checks,
        warnings: &warnings,
        model_file: arguments.output.as_ref().map(|path| path.display().to_string()),
        invocation,
    };
    let html = arguments.report.as_ref().map(|_| page.html());
    let model_file = arguments.output.iter().map(|path| (path.clone(), toml.as_bytes()));
    let page_file = arguments.report.iter().cloned().zip(html.iter().map(String::as_bytes));
    let files: Vec<(PathBuf, &[u8])> = model_file.chain(page_file).collect();
    files::write_together(&files, arguments.force)?;
    if arguments.json {
        return output::print_json(&Json {
            method: fit.method,
            order: order(&fit),
            estimates: &fit.estimates,
            correlations: &fit.correlations,
            p: fit.pole,
            delay_s: fit.delay_s,
            converged: fit.converged,
            ending: &fit.ending,
            at_bound: &fit.at_bound,
            not_identifiable: &fit.not_identifiable,
            unit: fit.unit,
            residual_rms: fit.residual_rms,
            innovation_rms: fit.innovation_rms,
            noise_order: fit.noise_order,
            effective_samples: fit.effective_samples,
            records: &fit.records,
            checks: &checks,
            evidence: &fit.evidence,
            starts: &fit.starts,
            notes: &fit.notes,
            warnings: &warnings,
            model: toml,
            output: arguments.output.clone(),
            report: arguments.report.clone(),
        });
    }
    let warned: String = warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    output::print(&(text(&fit, &checks, arguments) + &warned))
}

fn order(fit: &Fit) -> u8 {
    match fit.model.order {
        Order::Second => 2,
        Order::Third => 3,
    }
}

fn text(fit: &Fit, checks: &[RecordFit], arguments: &Arguments) -> String {
    let mut lines = vec![format!("order {}; {}", order(fit), fit.ending)];
    for estimate in &fit.estimates {
        let error = estimate.std_error.map_or(String::new(), |error| format!(" +- {error:.5}"));
        let bound = if estimate.at_bound { "  (at its bound)" } else { "" };
        lines.push(format!("{:>6} {:12.5}{error} {}{bound}", estimate.name, estimate.value, estimate.unit));
    }
    if fit.correlations.len() > 1 {
        let pairs = (0..fit.estimates.len()).flat_map(|a| (0..a).map(move |b| (b, a)));
        let words: Vec<String> = pairs
            .map(|(a, b)| format!("{}-{} {:.2}", fit.estimates[a].name, fit.estimates[b].name, fit.correlations[a][b]))
            .collect();
        lines.push(format!("correlations: {}", words.join(", ")));
    }
    lines.extend(fit.not_identifiable.iter().map(|what| format!("not identifiable: {what}")));
    let noise = match fit.noise_order {
        None => String::new(),
        Some(0) => format!(", white, {:.0} effective samples", fit.effective_samples),
        Some(order) => format!(", coloured, order {order}, {:.0} effective samples", fit.effective_samples),
    };
    lines.push(format!("residual {} rms{noise}", with_unit(fit.residual_rms, 4, fit.unit)));
    let explained = |record: &RecordFit| {
        let (rms, share) = (with_unit(record.residual_rms, 4, fit.unit), 100.0 * record.residual_share);
        format!("{}: {rms} rms, {share:.2} % of the position", record.source)
    };
    lines.extend(fit.records.iter().map(|record| format!("  {}", explained(record))));
    lines.extend(checks.iter().map(|record| format!("predicts {}", explained(record))));
    for row in &fit.evidence {
        lines.push(format!("evidence: {} {} behind", row.model, rounded(row.delta_bic)));
    }
    lines.extend(starts(fit));
    lines.extend(fit.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(arguments.output.iter().map(|path| format!("written to {}", path.display())));
    lines.extend(arguments.report.iter().map(|path| format!("open {}", path.display())));
    lines.join("\n") + "\n"
}

/// One decimal, or four significant digits for a number of overwhelming evidence.
fn rounded(value: f64) -> String {
    if value < 1e6 { format!("{value:.1}") } else { format!("{value:.3e}") }
}

/// The table of convergence for the report's method, one line for the other.
fn starts(fit: &Fit) -> Vec<String> {
    let share = |count: usize| 100.0 * count as f64 / fit.starts.len().max(1) as f64;
    let converged = share(fit.starts.iter().filter(|start| start.converged).count());
    let best = share(fit.starts.iter().filter(|start| start.at_best).count());
    let mut lines = Vec::new();
    let same = match fit.method {
        estimate::Method::Report => "k, omega, zeta within 1 %",
        estimate::Method::Likelihood => "k, omega, zeta within 1 %, or less than a standard error away",
    };
    if fit.method == estimate::Method::Report {
        lines.push("start: p, omega, zeta -> end: k, p, omega, zeta (weighted error; iterations)".to_owned());
        for start in &fit.starts {
            let ([_, p, omega, zeta], [end_k, end_p, end_omega, end_zeta]) = (start.start, start.end);
            let ending = if start.converged { String::new() } else { format!("; {}", start.ending) };
            lines.push(format!(
                "  {p:7.0} {omega:6.1} {zeta:5.2} -> {end_k:7.4} {end_p:9.1} {end_omega:8.3} {end_zeta:7.4} ({:.3e}; {}{ending})",
                start.cost, start.iterations
            ));
        }
    }
    // For maximum likelihood a start is only the beginning of a search, whose end is in the first line.
    let converged = match fit.method {
        estimate::Method::Report => format!("{converged:.0} % converged, "),
        estimate::Method::Likelihood => String::new(),
    };
    lines.push(format!("{} starts: {converged}{best:.0} % to the best end ({same})", fit.starts.len()));
    lines
}
