//! θ, the vector of search variables: (ln |k|, ln ω, ln ζ, 1/p, T), of which the last two may be known.
//!
//! The pole enters by its lag 1/p: the response is smooth in it down to zero, where p is infinite, and a lack of information on p appears
//! as a large standard error of 1/p.

use crate::frequency::DelayedModel;
use actuator_fmu::parameters::{Base, Order};

/// The pole's lag 1/p in a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lag {
    /// Eq. (6): no pole.
    None,
    /// Free.
    Free,
    /// Known [s].
    Fixed(f64),
}

/// Which parameters are estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// 1/p.
    pub lag: Lag,
    /// A known delay [s]; `None` if it is estimated.
    pub declared_delay_s: Option<f64>,
    /// Sign of k.
    pub sign: f64,
}

/// Indices in θ.
pub const LN_K: usize = 0;
/// ln ω
pub const LN_OMEGA: usize = 1;
/// ln ζ
pub const LN_ZETA: usize = 2;

/// A lag 1/p below this [s] turns the phase at 12 Hz by 4e-9 deg: p is infinite.
pub const NO_LAG_S: f64 = 1e-12;

/// Upper bound of lag and delay [s]: slower than any actuator of a control surface.
pub const GREATEST_LAG_S: f64 = 1.0;

/// Bounds of the search: |k|, ζ, and minimum ω [rad/s], each far beyond any actuator; maximum ω from the sampling
/// (`output_error::greatest_omega`).
pub const GAINS: [f64; 2] = [1e-3, 800.0];
pub const ZETAS: [f64; 2] = [LEAST_ZETA, 100.0];
pub const LEAST_OMEGA: f64 = 0.1;
const LEAST_ZETA: f64 = 1e-3;

impl Layout {
    /// Index of T.
    pub fn delay_place(&self) -> Option<usize> {
        self.declared_delay_s.is_none().then_some(3 + usize::from(self.lag == Lag::Free))
    }

    /// Length of θ.
    pub fn len(&self) -> usize {
        3 + usize::from(self.lag == Lag::Free) + usize::from(self.declared_delay_s.is_none())
    }

    /// The model for θ; `None` outside the range of its parameters.
    pub fn model(&self, x: &[f64]) -> Option<DelayedModel> {
        let lag = match self.lag {
            Lag::None => 0.0,
            Lag::Free => x[3],
            Lag::Fixed(lag) => lag,
        };
        let order = if self.lag == Lag::None { Order::Second } else { Order::Third };
        let delay_s = self.declared_delay_s.unwrap_or_else(|| x[x.len() - 1]);
        let base =
            Base::new(self.sign * x[LN_K].exp(), 1.0 / lag.max(NO_LAG_S), x[LN_OMEGA].exp(), x[LN_ZETA].exp()).ok()?;
        Some(DelayedModel { base, order, delay_s })
    }

    /// θ of a model, restricted to the entries of this layout.
    pub fn vector(&self, model: &DelayedModel) -> Vec<f64> {
        let base = &model.base;
        let zeta = base.zeta().max(LEAST_ZETA);
        let mut x = vec![base.k().abs().ln(), base.omega().ln(), zeta.ln()];
        if self.lag == Lag::Free {
            x.push(match model.order {
                Order::Second => 0.0,
                Order::Third => 1.0 / base.p(),
            });
        }
        if self.declared_delay_s.is_none() {
            x.push(model.delay_s);
        }
        x
    }
}
