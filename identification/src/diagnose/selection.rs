//! Model structure selection: the given model, the fitted records and the hold-out records.

use std::time::Instant;

use super::{
    adequacy::{self, Misfit},
    candidates::restart,
    fitted::{Fitted, SearchEffort},
    hypothesis::Hypothesis,
    measured_noise::MeasuredNoise,
    quantiser::Quantiser,
    space::Space,
    trace::Trace,
};
use crate::{progress::Work, signal::record::Record};
use actuator_fmu::parameters::Model;

/// How far a search of the structure goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Single effects, forward selection and pairs.
    All,
    /// Single effects.
    Singles,
}

/// What hypotheses are fitted to and judged on.
pub struct StructureSelection<'a> {
    /// The given model.
    pub given: &'a Model,
    /// Records to fit.
    pub fit: Vec<Trace<'a>>,
    /// Records to check.
    pub check: Vec<Trace<'a>>,
    /// Noise of both, fitted records first.
    pub noise: MeasuredNoise,
    /// When the search is to end with the best so far.
    pub deadline: Option<Instant>,
    /// Who hears how much of the search is done.
    pub work: &'a Work<'a>,
    /// How far it goes.
    pub extent: Extent,
    /// Of the variance of the position, what the given model leaves of the healthy reference records; none without such records.
    pub healthy_share: Option<f64>,
}

impl<'a> StructureSelection<'a> {
    /// Of a model, records to fit and records to check, and the noise of both.
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

    /// Takes the measurements to have come through a quantiser, or through none.
    pub fn quantise(&mut self, quantiser: Option<Quantiser>) {
        self.fit.iter_mut().chain(&mut self.check).for_each(|trace| trace.quantiser = quantiser);
    }

    /// A hypothesis fitted from a start.
    pub fn fit(&self, hypothesis: Hypothesis, start: &Model) -> Option<Fitted> {
        Fitted::search(Space::new(hypothesis, start, &self.given.base, 0.0), &self.fit, SearchEffort::Full)
    }

    /// Fitted to the tight tolerance; where a misfit stays, with the base free as well: the coarse search with a free base may not have
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

    /// On the fitted records, and on the hold-out records with θ updated within its uncertainty.
    pub fn misfit(&self, fitted: &Fitted) -> Option<Misfit> {
        let mut there = adequacy::misfit(&fitted.on(&self.check)?, &self.check);
        if !there.is_noise()
            && let Some(updated) = fitted.updated_with(&self.check, &self.fit)
        {
            there = adequacy::misfit(&updated, &self.check);
        }
        Some(adequacy::misfit(fitted, &self.fit).greater(there))
    }
}
