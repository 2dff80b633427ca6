//! The page of a fit.

use identification::{
    digits::{significant, with_unit},
    estimate::{Estimate, Evidence, Pole, RecordFit, StartResult},
    signal::record::Record,
};

use super::{Account, charts};
use crate::report::{
    head::{FileRow, Head, file_name},
    page::{Cell, Page, Tone},
};

/// Correlation above which two parameters are hardly distinguishable.
const STRONG_CORRELATION: f64 = 0.95;

impl Account<'_> {
    /// The page.
    #[must_use]
    pub fn html(&self) -> String {
        let (tone, verdict) = self.verdict();
        let of_role = |records: &[Record], role: &str| -> Vec<FileRow> {
            records.iter().map(|record| FileRow::of(record, role)).collect()
        };
        let head = Head {
            title: "The identified model".into(),
            tone,
            verdict,
            sentence: self.sentence(),
            evidence: self.fit.ending.clone(),
            model: self.model_file.clone().unwrap_or_else(|| "not written to a file".into()),
            files: [of_role(self.records, "fit"), of_role(self.others, "check")].concat(),
            invocation: self.invocation,
        };
        let mut page = self.warned(head.page());
        page = self.parameters(page);
        page = self.correlations(page);
        page = page.heading("Measured and model").captioned(&charts::figures(self));
        page = self.left(page);
        self.search(page).html()
    }

    fn verdict(&self) -> (Tone, String) {
        let fit = self.fit;
        if !fit.converged {
            return (Tone::Bad, "not converged".into());
        }
        match (fit.at_bound.is_empty(), self.warnings.is_empty() && fit.not_identifiable.is_empty()) {
            (false, _) => (Tone::Bad, format!("at a bound: {}", fit.at_bound.join(", "))),
            (true, false) => (Tone::Open, "converged, with doubts".into()),
            (true, true) => (Tone::Good, "converged".into()),
        }
    }

    fn sentence(&self) -> String {
        let fit = self.fit;
        let values = fit.estimates.iter().map(|estimate| {
            let error = estimate.std_error.map_or(String::new(), |error| format!(" ± {}", significant(error, 2)));
            let unit = if estimate.unit == "1" { String::new() } else { format!(" {}", estimate.unit) };
            format!("{} {}{error}{unit}", estimate.name, significant(estimate.value, 5))
        });
        let predicted = self.checks.iter().map(|check| {
            let (name, rms) = (file_name(check.source.as_ref()), with_unit(check.residual_rms, 3, fit.unit));
            format!("; {rms} rms on {name}")
        });
        format!(
            "order {}, {}; residual {} rms on the fitted records{}.",
            fit.model.order.short(),
            values.collect::<Vec<String>>().join(", "),
            with_unit(fit.residual_rms, 3, fit.unit),
            predicted.collect::<String>()
        )
    }

    fn warned(&self, page: Page) -> Page {
        let doubts = self.warnings.iter().map(|warning| (Tone::Open, "warning".to_owned(), warning));
        let unsure = self.fit.not_identifiable.iter().map(|what| (Tone::Open, "not identifiable".to_owned(), what));
        let notes = self.fit.notes.iter().map(|note| (Tone::Open, "note".to_owned(), note));
        let rows: Vec<_> = doubts
            .chain(unsure)
            .chain(notes)
            .map(|(tone, word, what)| (tone, word, format!("{what}."), String::new(), String::new()))
            .collect();
        if rows.is_empty() { page } else { page.heading("Warnings and notes").verdicts(&rows) }
    }

    fn parameters(&self, page: Page) -> Page {
        let row = |estimate: &Estimate| {
            let error = estimate.std_error.map_or("-".into(), |error| significant(error, 2));
            let interval = estimate
                .interval_95
                .map_or("-".into(), |[low, high]| format!("{} to {}", significant(low, 5), significant(high, 5)));
            vec![
                Cell::text(estimate.name),
                Cell::number(significant(estimate.value, 6)),
                Cell::number(error),
                Cell::number(interval),
                Cell::text(estimate.unit),
                Cell::judged(if estimate.at_bound { "at its bound" } else { "" }, estimate.at_bound),
            ]
        };
        let rows: Vec<Vec<Cell>> = self.fit.estimates.iter().map(row).collect();
        let heads = ["parameter", "value", "standard error", "95 % interval", "unit", ""];
        let page = page.heading("Parameters").table(&heads, &rows);
        match self.fit.pole {
            Pole::Above(bound) => page
                .remark(&format!("p: a lower limit only, above {} 1/s with 95 % confidence.", significant(bound, 3))),
            Pole::Found | Pole::Untold => page,
        }
    }

    fn correlations(&self, page: Page) -> Page {
        let fit = self.fit;
        if fit.correlations.len() < 2 {
            return page;
        }
        let names: Vec<&str> = fit.estimates.iter().map(|estimate| estimate.name).collect();
        let row = |(name, values): (&&str, &Vec<f64>)| -> Vec<Cell> {
            let cells = values.iter().zip(&names).map(|(value, other)| {
                Cell::judged(format!("{value:.3}"), name != other && value.abs() > STRONG_CORRELATION)
            });
            std::iter::once(Cell::text(*name)).chain(cells).collect()
        };
        let rows: Vec<Vec<Cell>> = names.iter().zip(&fit.correlations).map(row).collect();
        let heads: Vec<&str> = std::iter::once("correlation").chain(names.iter().copied()).collect();
        page.subheading("Correlations of the estimates").table(&heads, &rows)
    }

    /// The residual of each record.
    fn left(&self, page: Page) -> Page {
        let row = |record: &RecordFit, role: &str| {
            vec![
                Cell::text(file_name(record.source.as_ref())),
                Cell::text(role),
                Cell::number(significant(record.residual_rms, 4)),
                Cell::number(format!("{:.2}", 100.0 * record.residual_share)),
                Cell::number(significant(record.offset, 3)),
            ]
        };
        let fitted = self.fit.records.iter().map(|record| row(record, "fit"));
        let rows: Vec<Vec<Cell>> = fitted.chain(self.checks.iter().map(|record| row(record, "check"))).collect();
        let unit = self.fit.unit;
        let heads =
            ["record", "role", &format!("residual, {unit} rms"), "% of the position", &format!("offset, {unit}")];
        let worth = format!("equivalent to {:.0} samples of white noise.", self.fit.effective_samples);
        let noise = match self.fit.noise_order {
            None => String::new(),
            Some(0) => format!(" It is white, {worth}"),
            Some(order) => format!(" It is coloured, of order {order}, {worth}"),
        };
        page.heading("Residual").table(&heads, &rows).remark(&format!(
            "Residual: measured minus modelled position; the start and a constant offset are free in each record.{noise}"
        ))
    }

    /// Convergence of the search.
    fn search(&self, mut page: Page) -> Page {
        let fit = self.fit;
        page = page.heading("Search");
        if !fit.evidence.is_empty() {
            let row = |row: &Evidence| {
                let behind = Cell::number(significant(row.delta_bic, 4));
                vec![Cell::text(&row.model), Cell::number(row.parameters.to_string()), behind]
            };
            let rows: Vec<Vec<Cell>> = fit.evidence.iter().map(row).collect();
            page = page.table(&["model", "numbers estimated", "BIC behind"], &rows);
        }
        let row = |start: &StartResult| {
            let [k, p, omega, zeta] = start.end;
            let values = [k, p, omega, zeta].map(|value| Cell::number(significant(value, 5)));
            let begin = start.start.map(|value| significant(value, 3)).join(", ");
            let ended = [
                Cell::number(significant(start.cost, 4)),
                Cell::number(start.iterations.to_string()),
                Cell::text(if start.at_best { "yes" } else { "no" }),
                Cell::long(&start.ending),
            ];
            std::iter::once(Cell::text(begin)).chain(values).chain(ended).collect::<Vec<Cell>>()
        };
        let rows: Vec<Vec<Cell>> = fit.starts.iter().map(row).collect();
        let heads = ["start: k, p, ω, ζ", "k", "p, 1/s", "ω, rad/s", "ζ", "cost", "iterations", "best end", "ending"];
        page.long_table(&heads, &rows)
    }
}
