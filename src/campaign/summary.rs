//! What of a fit is kept: numbers that can be written down, read again and combined.

use nalgebra::{Complex, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    estimate::{Fit, Pole},
    frequency::response,
    parameters::{Base, Model, Order},
};

/// A fit in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitSummary {
    /// 2 or 3.
    pub order: u8,
    /// k, p, ω, ζ.
    pub values: [f64; 4],
    /// Their standard errors, where there are any.
    pub std_errors: [Option<f64>; 4],
    /// Covariance of ln |k|, ln ω, ln ζ and the lag 1/p [s], where the method states one.
    pub covariance: Option<[[f64; 4]; 4]>,
    /// With 95 % confidence p is above this [1/s]; none where p was found or where the method cannot tell.
    pub pole_above: Option<f64>,
    /// Delay [s], declared or estimated.
    pub delay_s: f64,
    /// Ended at a minimum.
    pub converged: bool,
    /// How it ended, in words.
    pub ending: String,
    /// Parameters at the edge of what is allowed.
    pub at_bound: Vec<String>,
    /// What the records cannot tell.
    pub not_identifiable: Vec<String>,
    /// Rms of measured less modelled position, in the unit of the records.
    pub residual_rms: f64,
    /// What to keep in mind.
    pub notes: Vec<String>,
}

/// Positions of k, ω and ζ among the base's parameters.
pub const IDENTIFIABLE: [usize; 3] = [0, 2, 3];

impl FitSummary {
    /// Of a fit.
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
            residual_rms: fit.residual_rms,
            notes: fit.notes.clone(),
        }
    }

    /// The model; none if the numbers are not allowed, which those of a fit are.
    #[must_use]
    pub fn model(&self) -> Option<Model> {
        let order = if self.order == 2 { Order::Second } else { Order::Third };
        let base = Base::from_values(self.values).ok()?;
        Some(Model { std_errors: self.std_errors, ..Model::new(base, order) })
    }

    /// Its response, delay included.
    #[must_use]
    pub fn response(&self, frequency_hz: f64) -> Option<Complex<f64>> {
        let model = self.model()?;
        let lag = Complex::from_polar(1.0, -std::f64::consts::TAU * frequency_hz * self.delay_s);
        Some(response(&model.base, model.order, frequency_hz) * lag)
    }

    /// ln |k|, ln ω, ln ζ.
    #[must_use]
    pub fn logarithms(&self) -> Vector3<f64> {
        Vector3::from(IDENTIFIABLE.map(|index| self.values[index].abs().ln()))
    }

    /// Covariance of ln k, ln ω and ln ζ, whatever the lag.
    #[must_use]
    pub fn covariance_of_all_lags(&self) -> Option<Matrix3<f64>> {
        self.covariance.map(|rows| Matrix3::from_fn(|row, column| rows[row][column]))
    }

    /// Covariance of ln k, ln ω and ln ζ if the lag were known.
    #[must_use]
    pub fn covariance_at_one_lag(&self) -> Option<Matrix3<f64>> {
        let rows = self.covariance?;
        let carried = Vector3::new(rows[0][3], rows[1][3], rows[2][3]);
        let all = self.covariance_of_all_lags()?;
        Some(if rows[3][3] > 0.0 { all - carried * carried.transpose() / rows[3][3] } else { all })
    }
}
