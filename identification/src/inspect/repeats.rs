//! Several records together: the same data twice, and repeats of one motion.

use super::{
    copies::is_copy,
    finding::{Finding, Severity},
    inspection::Inspection,
    noise,
};
use crate::signal::record::Record;

/// Inspects several records together: duplicates, and repeats of one motion, which determine the noise of both.
pub fn compare_records(records: &[&Record], inspections: &mut [Inspection]) {
    for second in 1..records.len() {
        for first in 0..second {
            let (one, other) = (records[first], records[second]);
            if is_copy(one, other) {
                let sentence = format!("it holds the same data as {}", one.source().display());
                let remedy = "give each record once: a copy adds no evidence, and checks nothing";
                inspections[second].findings.insert(0, Finding::warning("duplicate", sentence, remedy));
                continue;
            }
            // Without a response, a difference gives no information on its noise.
            if [first, second].iter().any(|index| inspections[*index].severity() == Severity::Refusal) {
                continue;
            }
            let repeat = noise::of_repeat(one.command(), one.position(), other.command(), other.position());
            if let Some(noise) = repeat {
                for index in [first, second] {
                    let known = &mut inspections[index].noise;
                    let smaller = known.source == noise::Source::Repeats && known.rms <= noise.rms;
                    *known = if smaller { *known } else { noise };
                }
            }
        }
    }
}
