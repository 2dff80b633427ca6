//! Summary of a fit: numbers that can be stored, read again and combined.

use nalgebra::{DMatrix, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use actuator_fmu::parameters::{Base, Identity, Model, Order, PositionUnit};
use identification::{
    compare::Set,
    estimate::{Fit, Pole},
};

/// A fit in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitSummary {
    /// 2 or 3.
    pub order: u8,
    /// k, p, ω, ζ.
    pub values: [f64; 4],
    /// Their standard errors, if any.
    pub std_errors: [Option<f64>; 4],
    /// Covariance of ln |k|, ln ω, ln ζ, the lag 1/p \[s\] and the delay \[s\], if the method gives one.
    pub covariance: Option<[[f64; 5]; 5]>,
    /// Lower 95 % bound of p [1/s]; `None` if p was identified or if the method gives none.
    pub pole_above: Option<f64>,
    /// Delay \[s\], declared or estimated.
    pub delay_s: f64,
    /// Converged to a minimum.
    pub converged: bool,
    /// How it ended, in words.
    pub ending: String,
    /// Parameters at a bound.
    pub at_bound: Vec<String>,
    /// What the records do not determine.
    pub not_identifiable: Vec<String>,
    /// Unit of positions.
    #[serde(default)]
    pub unit: PositionUnit,
    /// Rms of measured minus modelled position, in this unit.
    pub residual_rms: f64,
    /// Notes.
    pub notes: Vec<String>,
}

/// Positions of k, ω and ζ among the base's parameters.
pub const IDENTIFIABLE: [usize; 3] = [0, 2, 3];

impl FitSummary {
    /// From a fit.
    #[must_use]
    pub fn of(fit: &Fit) -> Self {
        let order = match fit.model.order {
            Order::Second => 2,
            Order::Third => 3,
        };
        let above = match fit.pole {
            Pole::Above(bound) => Some(bound).filter(|bound| bound.is_finite()),
            Pole::Found | Pole::Untold => None,
        };
        Self {
            order,
            values: fit.model.base.values(),
            std_errors: fit.model.std_errors,
            covariance: fit.covariance.filter(|rows| rows.iter().flatten().all(|value| value.is_finite())),
            pole_above: above,
            delay_s: fit.delay_s,
            converged: fit.converged,
            ending: fit.ending.clone(),
            at_bound: fit.at_bound.clone(),
            not_identifiable: fit.not_identifiable.clone(),
            unit: fit.model.unit(),
            residual_rms: fit.residual_rms,
            notes: fit.notes.clone(),
        }
    }

    /// The model; `None` if the numbers are out of range, which those of a fit are not.
    #[must_use]
    pub fn model(&self) -> Option<Model> {
        let order = if self.order == 2 { Order::Second } else { Order::Third };
        let base = Base::from_values(self.values).ok()?;
        let identity = Identity { unit: self.unit, ..Identity::default() };
        Some(Model { identity, std_errors: self.std_errors, ..Model::new(base, order) })
    }

    /// As a set for comparison.
    #[must_use]
    pub fn set(&self, label: impl Into<String>) -> Option<Set> {
        Some(Set { delay_s: self.delay_s, covariance: self.covariance, ..Set::new(label, self.model()?) })
    }

    /// ln |k|, ln ω, ln ζ.
    #[must_use]
    pub fn logarithms(&self) -> Vector3<f64> {
        Vector3::from(IDENTIFIABLE.map(|index| self.values[index].abs().ln()))
    }

    /// Covariance of ln k, ln ω and ln ζ, marginal over lag and delay.
    #[must_use]
    pub fn covariance_of_all_lags(&self) -> Option<Matrix3<f64>> {
        self.covariance.map(|rows| Matrix3::from_fn(|row, column| rows[row][column]))
    }

    /// Covariance of ln k, ln ω and ln ζ given lag and delay: C - B D⁻¹ B', with B the cross-covariance and D that of lag and delay.
    #[must_use]
    pub fn covariance_at_one_lag(&self) -> Option<Matrix3<f64>> {
        let rows = self.covariance?;
        let unknown: Vec<usize> = (3..5).filter(|place| rows[*place][*place] > 0.0).collect();
        let own = DMatrix::from_fn(unknown.len(), unknown.len(), |row, column| rows[unknown[row]][unknown[column]]);
        let with_others = DMatrix::from_fn(3, unknown.len(), |row, column| rows[row][unknown[column]]);
        let all = DMatrix::from_fn(3, 3, |row, column| rows[row][column]);
        let left = all - &with_others * own.try_inverse()? * with_others.transpose();
        Some(Matrix3::from_fn(|row, column| left[(row, column)]))
    }
}
