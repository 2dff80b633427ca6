//! A record that stands apart: its residual is many times that of any other record. An unplugged sensor, another rig, jumps of the level: nothing
//! that the records share explains it, and it is no noise.

use super::{fitted::Fitted, selection::StructureSelection, trace::Trace};
use crate::{
    digits::{significant, with_unit},
    inspect::deviation,
};

/// Deviation of a residual over that of any other record, also relative to the motion, and over the noise of its record, at least.
const APART: f64 = 4.0;

impl StructureSelection<'_> {
    /// A note on the record that stands apart from the others with an explanation; none where there is no such record.
    pub fn record_apart(&self, best: &Fitted, checked: &Fitted) -> Option<String> {
        let traces: Vec<&Trace<'_>> = self.fit.iter().chain(&self.check).collect();
        let left: Vec<f64> = best.residuals.iter().chain(&checked.residuals).map(|left| deviation(left)).collect();
        let of_motion = left.iter().zip(&traces).map(|(left, trace)| left / deviation(trace.record.position()));
        let of_motion: Vec<f64> = of_motion.collect();
        let place = (0..left.len()).max_by(|one, other| left[*one].total_cmp(&left[*other]))?;
        let beyond_others = |of: &[f64]| {
            let others = of.iter().enumerate().filter(|(other, _)| *other != place);
            of[place] / others.map(|(_, left)| *left).fold(f64::MIN_POSITIVE, f64::max)
        };
        let noise = self.noise.records.get(place).map_or(0.0, |noise| noise.rms);
        let times = beyond_others(&left);
        let is_apart = left.len() > 1 && times.min(beyond_others(&of_motion)) > APART && left[place] > APART * noise;
        is_apart.then(|| {
            let file = traces[place].record.source().display();
            let left = with_unit(left[place], 3, best.model.unit().name());
            format!(
                "the residual of {file}, {left} rms, is {} times that of any other record: check what was recorded there, or leave it out",
                significant(times, 2)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use std::slice::from_ref;

    use crate::{
        diagnose::{
            Diagnosis, Verdict, diagnose,
            three_records::{measured_as, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::parameters::{Model, table};

    fn diagnosis(records: &[Record]) -> Diagnosis {
        let (check, fit) = records.split_last().unwrap();
        diagnose(&Model::from_set(&table()[0]), fit, from_ref(check), &[], None).unwrap()
    }

    fn three() -> Vec<Record> {
        three_records_of(&Model::from_set(&table()[0]), 3.0, 6.0)
    }

    #[test]
    fn a_record_whose_level_jumps_time_and_again_is_said_and_is_no_noise() {
        // Up by 1, down by 2, up by 3.
        let jumping = |t: f64| {
            if t < 1.5 {
                0.0
            } else if t < 3.0 {
                1.0
            } else if t < 4.5 {
                -1.0
            } else {
                2.0
            }
        };
        for place in [0, 2] {
            let mut records = three();
            records[place] = measured_as(&records[place], |t, position| position + jumping(t));
            let diagnosis = diagnosis(&records);
            assert_eq!(diagnosis.verdict, Verdict::Unexplained, "{place}");
            assert!(
                diagnosis.notes.iter().any(|note| note.contains("times that of any other record")),
                "{place}: {:?}",
                diagnosis.notes
            );
        }
        let healthy = diagnosis(&three());
        assert_eq!((healthy.verdict, healthy.notes), (Verdict::NothingMissing, Vec::new()));
    }

    #[test]
    fn a_load_that_is_written_and_is_none_takes_nothing_from_the_answer() {
        let unloaded = |record: Record| {
            let none = vec![0.0; record.len()];
            record.with_load(Some(none))
        };
        let records: Vec<Record> = three().into_iter().map(unloaded).collect();
        assert_eq!(diagnosis(&records).verdict, Verdict::NothingMissing);
    }

    /// A position in inch, and in revolutions, beside a model in mm and in deg.
    #[test]
    fn another_unit_is_no_lag_that_is_longer_than_the_records() {
        for factor in [1.0 / 25.4, 1.0 / 360.0] {
            let records: Vec<Record> =
                three().iter().map(|record| measured_as(record, |_, position| factor * position)).collect();
            let diagnosis = diagnosis(&records);
            assert_eq!(diagnosis.verdict, Verdict::Unexplained, "{factor}: {:?}", diagnosis.findings);
        }
    }
}
