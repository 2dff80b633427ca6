//! Words and numbers that the text and the page of a comparison share.

use identification::compare::{Comparison, Difference, Extreme, LIMITS, Limits, Statement, Verdict};

/// The nonempty tables, with their titles.
pub fn sections(comparison: &Comparison) -> impl Iterator<Item = (&'static str, &[Difference])> {
    [
        ("Wear: a later stage against an earlier one", comparison.wear.as_slice()),
        ("Load: loaded against unloaded", &comparison.load),
        ("Against the first", &comparison.against_first),
    ]
    .into_iter()
    .filter(|(_, differences)| !differences.is_empty())
}

/// Number of pairs that exceed a limit within 0.5-12 Hz, and total.
pub fn beyond_limits(comparison: &Comparison) -> (usize, usize) {
    let pairs = || sections(comparison).flat_map(|(_, differences)| differences);
    (pairs().filter(|pair| !pair.data_band.within_limits).count(), pairs().count())
}

/// As above in a sentence, with the maximum differences.
pub fn limits_sentence(comparison: &Comparison) -> String {
    let (beyond, all) = beyond_limits(comparison);
    let Limits { magnitude, phase_deg } = LIMITS;
    let greatest = |of: fn(&Difference) -> f64| {
        sections(comparison).flat_map(|(_, differences)| differences).map(of).fold(0.0, f64::max)
    };
    let (worst_magnitude, worst_phase) =
        (greatest(|pair| pair.data_band.magnitude.max), greatest(|pair| pair.data_band.phase_deg.max));
    let unit = comparison.gain_unit();
    format!(
        "{beyond} of {all} pairs exceed {magnitude} {unit} or {phase_deg} deg within 0.5-12 Hz; the greatest differences are \
         {worst_magnitude:.4} {unit} and {worst_phase:.2} deg"
    )
}

/// For each set with effects that no linear response shows: these effects.
pub fn left_out(comparison: &Comparison) -> impl Iterator<Item = String> {
    let with_effects = comparison.sets.iter().filter(|set| !set.left_out().is_empty());
    with_effects.map(|set| {
        format!("{}: without {}, which no linear response shows (simulate does)", set.label, set.left_out().join(", "))
    })
}

/// Frequency from which a limit is exceeded [Hz].
pub fn passed(first: Option<f64>) -> String {
    first.map_or_else(|| "nowhere".into(), |frequency| format!("{frequency:.2}"))
}

/// ± half width of the 95 % interval, if the sets are estimated.
pub fn interval(extreme: &Extreme, decimals: usize) -> String {
    extreme.std_error.map_or_else(String::new, |error| format!("±{:.decimals$}", TWO_SIDED_95 * error))
}

/// Half width of a 95 % interval in standard errors.
const TWO_SIDED_95: f64 = 1.96;

/// The set with the largest difference between second and third order.
pub fn worst_order(comparison: &Comparison) -> Option<&Difference> {
    comparison.order.iter().max_by(|a, b| a.data_band.phase_deg.max.total_cmp(&b.data_band.phase_deg.max))
}

/// Figure 7 in a sentence; the set it shows, if present, and the worst.
pub fn order_sentence(comparison: &Comparison, worst: &Difference) -> String {
    let shown = comparison.order.iter().find(|pair| pair.from == "ls-early-unloaded");
    let part = |pair: &Difference| {
        let (phase, magnitude) = (&pair.data_band.phase_deg, &pair.data_band.magnitude);
        let unit = comparison.gain_unit();
        format!("{} {:.3} deg at {:.2} Hz and {:.1e} {unit}", pair.from, phase.max, phase.at_hz, magnitude.max)
    };
    let shown = shown.map_or_else(String::new, |pair| format!("{} (figure 7); at most ", part(pair)));
    format!("Second order instead of third: {shown}{}", part(worst))
}

/// Number of statements of the report that hold.
pub fn count_sentence(statements: &[Statement]) -> String {
    let count = |verdict| statements.iter().filter(|statement| statement.verdict == verdict).count();
    format!(
        "Statements of the report against its own tables: {} agree, {} are contradicted, {} cannot be checked",
        count(Verdict::Agrees),
        count(Verdict::Contradicted),
        count(Verdict::CannotBeChecked)
    )
}
