//! Tables 1 and 2 of NASA/TM-1998-208452, compared, with the report's statements checked.

use super::{comparison::Comparison, set::Set, statements};
use actuator_fmu::parameters::{Model, SOURCE, table};

impl Comparison {
    /// Tables 1 and 2 of the report.
    #[must_use]
    pub fn of_tables() -> Self {
        let sets = table()
            .iter()
            .map(|set| Set {
                label: set.name.to_string(),
                condition: Some(set.name.into()),
                ..Set::new("", Model::from_set(set))
            })
            .collect();
        let mut comparison = Self::of(SOURCE, sets);
        comparison.statements = statements::of(&comparison);
        comparison
    }
}
