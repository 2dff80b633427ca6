//! A line in the recorded command that the actuator did not receive: hum of a logger in that channel. The model responds to it and the position does
//! not, so that the difference has a line of one frequency that looks like an oscillation of the actuator.

use std::f64::consts::TAU;

use super::{
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::family,
    leading_oscillation::CHATTER,
    plain_fit::{PlainFit, mean_square},
    selection::StructureSelection,
    trace::Trace,
};
use crate::{
    linear_least_squares::{solve, subtract},
    signal::record::{Record, without_mean},
};
use actuator_fmu::{effects::find, parameters::Model};

/// Reduction of the mean square of each record by removing the line from the command, over that by the oscillation, at least. This also removes what
/// the command itself has at this frequency.
const AS_MUCH: f64 = 0.9;

impl StructureSelection<'_> {
    /// An oscillation that is hum in the recorded command, as a lead to be listed; none otherwise.
    pub fn hum_of_command(&self, found: &Fitted) -> Option<Lead> {
        if !found.space.hypothesis.effects.contains(&CHATTER) {
            return None;
        }
        let frequency_hz = found.space.chatter_hz(&found.x);
        let model = Model { effects: found.model.effects.without(find(CHATTER)?), ..found.model.clone() };
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let records: Vec<(Record, f64)> = traces.iter().map(|trace| without_line(trace.record, frequency_hz)).collect();
        let clean: Vec<Trace<'_>> =
            records.iter().map(|(record, _)| Trace::new(record, &self.given.base).part_of(self.work)).collect();
        let [before, after] = [&traces, &clean].map(|traces| PlainFit::beside_levels(&model, traces));
        let there = found.on(&self.check)?;
        let with = found.residuals.iter().chain(&there.residuals).map(|left| mean_square(&without_mean(left)));
        let (before, after) = (before?.mean_squares(), after?.mean_squares());
        let mut records_left = before.iter().zip(&after).zip(with);
        if !records_left.all(|((before, after), with)| before - after >= AS_MUCH * (before - with)) {
            return None;
        }
        #[allow(clippy::cast_precision_loss)] // a count of records
        let amplitude = records.iter().map(|(_, amplitude)| amplitude).sum::<f64>() / records.len() as f64;
        let check_rms = PlainFit::as_it_is(&model, &clean[self.fit.len()..])?.mean_square().sqrt();
        Some(Lead {
            name: CHATTER,
            family: family(CHATTER),
            share: None,
            nonlinear_share: None,
            check_rms: Some(check_rms),
            parameters: [("amplitude", amplitude), ("frequency", frequency_hz)].into(),
            only_in: None,
            why_not: "the recorded commands contain this line and the positions do not follow it: hum in the recorded command. Without that line the model \
                      needs no oscillation: filter it out of the records, or record the command upstream of it"
                .to_owned(),
        })
    }
}

/// A record with the line of this frequency removed from its command, and the amplitude of the line.
fn without_line(record: &Record, frequency_hz: f64) -> (Record, f64) {
    let phases = || record.time().iter().map(|t| TAU * frequency_hz * t);
    let columns = [phases().map(f64::sin).collect(), phases().map(f64::cos).collect()];
    let factors = solve(&columns, &without_mean(record.command()));
    let mut command = record.command().to_vec();
    subtract(&mut command, &columns, &factors);
    (record.clone().with_command(command), factors[0].hypot(factors[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{
        Verdict, diagnose,
        three_records::{measured_as, three_records_of},
    };
    use actuator_fmu::parameters::table;

    fn records() -> (Model, Vec<Record>) {
        let given = Model::from_set(&table()[0]);
        let records = three_records_of(&given, 3.0, 6.0);
        (given, records)
    }

    fn humming(record: &Record, amplitude: f64) -> Record {
        // The records began at unrelated times.
        let phase = record.command().iter().sum::<f64>();
        let hum = |t: &f64| amplitude * (TAU * 23.3 * t + phase).sin();
        let command = record.time().iter().map(hum).zip(record.command()).map(|(hum, command)| hum + command).collect();
        record.clone().with_command(command)
    }

    #[test]
    fn the_line_of_a_command_is_taken_out_of_it() {
        let (_, records) = records();
        for record in &records {
            let (clean, amplitude) = without_line(&humming(record, 5.0), 23.3);
            assert!((amplitude - 5.0).abs() < 0.5, "{amplitude}");
            let left = clean.command().iter().zip(record.command()).map(|(clean, command)| (clean - command).abs());
            assert!(left.fold(0.0, f64::max) < 0.5);
        }
    }

    #[test]
    fn hum_in_the_column_of_the_command_is_no_oscillation_and_one_of_the_position_is() {
        let (given, records) = records();
        let said = |records: Vec<Record>| {
            let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
            (diagnosis.verdict, diagnosis.findings.first().map(|found| found.name), diagnosis.leads)
        };
        let (verdict, found, leads) = said(records.iter().map(|record| humming(record, 1.0)).collect());
        assert_eq!((verdict, found), (Verdict::Unexplained, None));
        assert!(leads[0].name == CHATTER && (leads[0].parameters["amplitude"] - 1.0).abs() < 0.1, "{leads:?}");
        assert!(
            (leads[0].parameters["frequency"] - 23.3).abs() < 0.01 && leads[0].why_not.contains("hum"),
            "{leads:?}"
        );
        let of_position = |record: &Record| measured_as(record, |t, position| position + 0.1 * (TAU * 23.3 * t).sin());
        let (verdict, found, _) = said(records.iter().map(of_position).collect());
        assert_eq!((verdict, found), (Verdict::Named, Some(CHATTER)));
    }
}
