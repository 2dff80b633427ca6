//! Selection of the model structure: the given model, the fit records and the check records.

use std::time::Instant;

use super::{
    adequacy::{self, Misfit},
    candidates::restart,
    fitted::{Fitted, SearchEffort},
    hypothesis::Hypothesis,
    measured_noise::MeasuredNoise,
    predictable::Predictable,
    quantiser::Quantiser,
    remembered::Remembered,
    space::Space,
    trace::Trace,
};
use crate::{progress::Work, signal::record::Record};
use actuator_fmu::parameters::Model;

/// Extent of a search for the structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Single effects, forward selection and pairs.
    All,
    /// Single effects.
    Singles,
}

/// The model and the records of a selection.
pub struct StructureSelection<'a> {
    /// The given model.
    pub given: &'a Model,
    /// Fit records.
    pub fit: Vec<Trace<'a>>,
    /// Check records.
    pub check: Vec<Trace<'a>>,
    /// Noise of both, fit records first.
    pub noise: MeasuredNoise,
    /// Time at which the search ends with the best result so far.
    pub deadline: Option<Instant>,
    /// Progress of the search.
    pub work: &'a Work<'a>,
    /// Extent of the search.
    pub extent: Extent,
    /// Sum of squares of the given model's residual over that of the positions, on healthy reference records; none without such records.
    pub healthy_share: Option<f64>,
    /// Misfit, and the part of the residual that the motion predicts, of the hypothesis for which it was asked last.
    misfits: Remembered<Option<Misfit>>,
    pub(super) predictables: Remembered<Option<Predictable>>,
}

impl<'a> StructureSelection<'a> {
    /// A selection from a model, fit and check records, and the noise of both.
    pub fn new(
        given: &'a Model,
        fit: &'a [Record],
        check: &'a [Record],
        noise: MeasuredNoise,
        deadline: Option<Instant>,
        work: &'a Work<'a>,
    ) -> Self {
        let traces = |records: &'a [Record]| {
            records.iter().map(|record| Trace::new(record, &given.base).part_of(work)).collect()
        };
        Self {
            given,
            fit: traces(fit),
            check: traces(check),
            noise,
            deadline,
            work,
            extent: Extent::All,
            healthy_share: None,
            misfits: Remembered::default(),
            predictables: Remembered::default(),
        }
    }
}

impl StructureSelection<'_> {
    /// Whether the time for the search is over.
    pub fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// The quantiser of all its records, where there is one.
    pub fn quantiser(&self) -> Option<Quantiser> {
        self.fit.first().and_then(|trace| trace.quantiser)
    }

    /// Sets the quantiser of all measurements, or none.
    pub fn quantise(&mut self, quantiser: Option<Quantiser>) {
        self.fit.iter_mut().chain(&mut self.check).for_each(|trace| trace.quantiser = quantiser);
        self.misfits.forget();
        self.predictables.forget();
    }

    /// A hypothesis fitted from a start model.
    pub fn fit(&self, hypothesis: Hypothesis, start: &Model) -> Option<Fitted> {
        Fitted::search(Space::new(hypothesis, start, &self.given.base, 0.0), &self.fit, SearchEffort::Full)
    }

    /// Fitted to the tight tolerance; where a misfit remains, with the base free as well, since the coarse search with a free base may not have
    /// converged.
    pub fn refined(&self, fitted: Fitted) -> Fitted {
        let further = |fitted: Fitted, base_free: bool| {
            let fine = Fitted::search(restart(&fitted, base_free), &self.fit, SearchEffort::Full);
            fine.filter(|fine| fine.bic <= fitted.bic).unwrap_or(fitted)
        };
        let base_free = fitted.space.hypothesis.base_free;
        let fine = further(fitted, base_free);
        if base_free || adequacy::misfit(&fine, &self.fit).is_noise() { fine } else { further(fine, true) }
    }

    /// The larger misfit of those on the fit records and on the check records, there with θ updated within its uncertainty.
    pub fn misfit(&self, fitted: &Fitted) -> Option<Misfit> {
        self.misfits.of(fitted, || self.find_misfit(fitted))
    }

    fn find_misfit(&self, fitted: &Fitted) -> Option<Misfit> {
        let mut there = adequacy::misfit(&fitted.on(&self.check)?, &self.check);
        if !there.is_noise()
            && let Some(updated) = fitted.updated_with(&self.check, &self.fit)
        {
            there = adequacy::misfit(&updated, &self.check);
        }
        Some(adequacy::misfit(fitted, &self.fit).greater(there))
    }
}
