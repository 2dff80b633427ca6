//! Stored simulations of a search, and derivatives obtained from them.
//!
//! After a step that gained what was predicted, the derivatives are updated from the change of the positions (C. G. Broyden, Math. Comp. 19, 1965),
//! which costs no simulation.

use std::sync::{Arc, Mutex, PoisonError};

use super::trace::Simulated;
use crate::linear_least_squares::{dot, subtract};

/// Simulated positions of each record.
pub type Positions = Vec<Simulated>;

/// The latest vectors of a search with their simulated positions: cost, gradient and residual are evaluated at the same vector.
#[derive(Default)]
pub struct SimulationCache {
    positions: Mutex<Vec<(Vec<f64>, Arc<Positions>)>>,
    jacobian: Mutex<Option<Arc<Jacobian>>>,
}

/// ∂(simulated)/∂x of each record at one vector, before whitening.
#[derive(Clone)]
pub struct Jacobian {
    /// The vector.
    pub x: Vec<f64>,
    /// Positions there.
    pub simulated: Arc<Positions>,
    /// By record, parameter and sample, after the settling time.
    pub columns: Vec<Vec<Vec<f64>>>,
    /// Whether computed by differences at this vector, not by an update.
    pub is_exact: bool,
}

impl SimulationCache {
    /// The accepted step and the rejected one.
    const CAPACITY: usize = 2;

    /// A cache in which derivatives are already known.
    pub fn knowing(jacobian: Jacobian) -> Self {
        let positions = vec![(jacobian.x.clone(), jacobian.simulated.clone())];
        Self { positions: Mutex::new(positions), jacobian: Mutex::new(Some(Arc::new(jacobian))) }
    }

    pub fn get(&self, x: &[f64]) -> Option<Arc<Positions>> {
        let known = self.positions.lock().unwrap_or_else(PoisonError::into_inner);
        known.iter().find(|(at, _)| at == x).map(|(_, positions)| positions.clone())
    }

    pub fn keep(&self, x: &[f64], positions: &Arc<Positions>) {
        let mut known = self.positions.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= Self::CAPACITY {
            known.remove(0);
        }
        known.push((x.to_vec(), positions.clone()));
    }

    pub fn jacobian(&self) -> Option<Arc<Jacobian>> {
        self.jacobian.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub fn keep_jacobian(&self, jacobian: Jacobian) -> Arc<Jacobian> {
        let jacobian = Arc::new(jacobian);
        *self.jacobian.lock().unwrap_or_else(PoisonError::into_inner) = Some(jacobian.clone());
        jacobian
    }
}

impl Jacobian {
    /// The same for some of the records.
    pub fn of_records(&self, records: &[usize]) -> Self {
        Self {
            x: self.x.clone(),
            simulated: Arc::new(records.iter().map(|record| self.simulated[*record].clone()).collect()),
            columns: records.iter().map(|record| self.columns[*record].clone()).collect(),
            is_exact: self.is_exact,
        }
    }

    /// The derivatives at the end of a step s that changed the simulated positions by Δ:
    ///
    /// ```text
    /// J + (Δ - J s) s' / (s' s)
    /// ```
    pub fn after_step(&self, x: &[f64], simulated: &Arc<Positions>) -> Option<Self> {
        let step: Vec<f64> = x.iter().zip(&self.x).map(|(new, old)| new - old).collect();
        let length = dot(&step, &step);
        if length == 0.0 {
            return None;
        }
        let update = |(record, columns): (usize, &Vec<Vec<f64>>)| {
            let (now, before) = (&simulated[record].position, &self.simulated[record].position);
            let settling = now.len() - columns.first().map_or(now.len(), Vec::len);
            let mut missed: Vec<f64> =
                now[settling..].iter().zip(&before[settling..]).map(|(now, before)| now - before).collect();
            subtract(&mut missed, columns, &step);
            let mut columns = columns.clone();
            for (column, step) in columns.iter_mut().zip(&step) {
                column.iter_mut().zip(&missed).for_each(|(value, missed)| *value += missed * step / length);
            }
            columns
        };
        let columns = self.columns.iter().enumerate().map(update).collect();
        Some(Self { x: x.to_vec(), simulated: simulated.clone(), columns, is_exact: false })
    }
}
