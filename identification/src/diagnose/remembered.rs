//! What was found for the fitted hypothesis that was judged last: a search asks several times.

use std::sync::Mutex;

use super::{fitted::Fitted, hypothesis::Hypothesis};
use crate::parallel::locked;
use actuator_fmu::parameters::Model;

/// What distinguishes fitted hypotheses on the same records: hypothesis, θ, model and BIC.
type Key = (Hypothesis, Vec<f64>, Model, f64);

/// A finding, and the fitted hypothesis that it is for.
pub struct Remembered<T>(Mutex<Option<(Key, T)>>);

impl<T> Default for Remembered<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T: Copy> Remembered<T> {
    /// The finding for a fitted hypothesis, made if it is not the last one.
    pub fn of(&self, fitted: &Fitted, find: impl FnOnce() -> T) -> T {
        let Fitted { space, x, model, bic, .. } = fitted;
        let is_same = |key: &Key| key.0 == space.hypothesis && key.1 == *x && key.2 == *model && key.3 == *bic;
        if let Some((key, known)) = locked(&self.0).as_ref()
            && is_same(key)
        {
            return *known;
        }
        let found = find();
        *locked(&self.0) = Some(((space.hypothesis.clone(), x.clone(), model.clone(), *bic), found));
        found
    }

    /// For when the records change.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{space::Space, three_records::three_records, trace::Trace};
    use actuator_fmu::parameters::{Base, table};

    #[test]
    fn the_last_finding_is_remembered_for_its_own_hypothesis_only() {
        let given = Model::from_set(&table()[0]);
        let records = three_records(&given, 3.0);
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &given.base)).collect();
        let fitted = |model: &Model| {
            Fitted::at_start(Space::new(Hypothesis::default(), model, &given.base, 0.0), &traces).unwrap()
        };
        let stiffer = Base::new(given.base.k(), given.base.p(), 1.1 * given.base.omega(), given.base.zeta()).unwrap();
        let (one, other) = (fitted(&given), fitted(&Model { base: stiffer, ..given.clone() }));
        let mut remembered = Remembered::default();
        assert_eq!(remembered.of(&one, || 1), 1);
        assert_eq!(remembered.of(&one, || 2), 1);
        assert_eq!(remembered.of(&other, || 3), 3);
        assert_eq!(remembered.of(&one, || 4), 4);
        remembered.forget();
        assert_eq!(remembered.of(&one, || 5), 5);
    }
}
