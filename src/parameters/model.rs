//! A model: an identified actuator with its name, parameters and provenance. Its file is in `model_file`.

use serde::{Deserialize, Serialize};

use super::{
    base::Base,
    position_unit::PositionUnit,
    selection::{Order, Surface},
    table::ParameterSet,
};
use crate::{
    effects::{Effects, Parameter},
    error::Result,
};

/// Name of a model, and the unit of its positions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Identity {
    /// One line; the name of its FMU.
    pub name: Option<String>,
    /// Description.
    pub description: Option<String>,
    /// Unit of command, position and load.
    pub unit: PositionUnit,
}

/// Provenance of a model. The date is given by the caller: the library reads no clock.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Records, or the report's table and row.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub records: Vec<String>,
    /// SHA-256 of each record.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hashes: Vec<String>,
    /// Estimation method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Date, as given by the caller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
}

/// A model: base dynamics, effects and provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Name, description, unit of positions.
    pub identity: Identity,
    /// Second or third order.
    pub order: Order,
    /// k, p, ω, ζ. Second order does not use p.
    pub base: Base,
    /// Effects; neutral ones are not written to the file.
    pub effects: Effects,
    /// Standard errors of their parameters, in the order of [`Effects::parameters`], where estimated.
    pub effect_std_errors: Vec<Option<f64>>,
    /// Standard errors in the order of [`Base::PARAMETERS`], where estimated.
    pub std_errors: [Option<f64>; 4],
    /// Provenance.
    pub provenance: Provenance,
}

impl Model {
    /// A model without name and estimated errors, with positions in deg.
    #[must_use]
    pub fn new(base: Base, order: Order) -> Self {
        let effects = Effects::default();
        let effect_std_errors = vec![None; effects.values().len()];
        Self {
            identity: Identity::default(),
            order,
            base,
            std_errors: [None; 4],
            effects,
            effect_std_errors,
            provenance: Provenance::default(),
        }
    }

    /// The third-order model of a row of the report.
    #[must_use]
    pub fn from_set(set: &ParameterSet) -> Self {
        let provenance = Provenance { records: vec![set.source()], ..Provenance::default() };
        let name = set.name;
        let surface = match name.surface {
            Surface::TrailingEdge => "Trailing-edge",
            Surface::UpperSpoiler => "Upper-spoiler",
            Surface::LowerSpoiler => "Lower-spoiler",
        };
        let (stage, load_case, source) = (name.stage.name(), name.load_case.name(), set.source());
        let description =
            format!("{surface} actuator of the BACT wind-tunnel model, {stage} in the test, {load_case} ({source})");
        let identity =
            Identity { name: Some(name.to_string()), description: Some(description), unit: PositionUnit::Degree };
        Self { identity, provenance, ..Self::new(set.base, Order::Third) }
    }

    /// Unit of command, position and load.
    #[must_use]
    pub fn unit(&self) -> PositionUnit {
        self.identity.unit
    }

    /// The same actuator in another position unit of the same kind.
    ///
    /// # Errors
    /// A unit of another kind; a value that is outside its range in the other unit.
    pub fn in_unit(&self, unit: PositionUnit) -> Result<Self> {
        let own = self.unit();
        let values: Vec<f64> = Effects::parameters()
            .zip(self.effects.values())
            .map(|((_, parameter), value)| converted(parameter, *value, own, unit))
            .collect::<Result<_>>()?;
        let errors: Vec<Option<f64>> = Effects::parameters()
            .zip(&self.effect_std_errors)
            .map(|((_, parameter), error)| {
                error.map(|error| own.convert_power(error, PositionUnit::power(parameter.unit), unit)).transpose()
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            identity: Identity { unit, ..self.identity.clone() },
            effects: Effects::with_values(&values)?,
            effect_std_errors: errors,
            ..self.clone()
        })
    }
}

/// A parameter's value in another position unit. A neutral value is neutral in every unit.
pub(super) fn converted(parameter: &Parameter, value: f64, from: PositionUnit, to: PositionUnit) -> Result<f64> {
    let power = PositionUnit::power(parameter.unit);
    if value == parameter.neutral && from.kind() == to.kind() {
        Ok(value)
    } else {
        from.convert_power(value, power, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::table;

    #[test]
    fn a_model_in_another_unit_has_the_same_effects_in_that_unit() {
        let mut model = Model::from_set(&table()[0]);
        model.identity.unit = PositionUnit::Millimetre;
        let mut values = model.effects.values().to_vec();
        let index = |effect, name| Effects::index(effect, name).unwrap();
        values[index("backlash", "gap")] = 0.3;
        values[index("amplitude_gain", "cubic")] = 2e-3;
        values[index("delay", "time")] = 0.01;
        model.effects = Effects::with_values(&values).unwrap();
        let metres = model.in_unit(PositionUnit::Metre).unwrap();
        let value = |effect, name| metres.effects.values()[index(effect, name)];
        assert_eq!(
            [value("backlash", "gap"), value("amplitude_gain", "cubic"), value("delay", "time")],
            [3e-4, 2e3, 0.01]
        );
        assert_eq!(value("rate_limit", "up"), 1e9);
        assert_eq!(metres.in_unit(PositionUnit::Millimetre).unwrap(), model);
        assert!(model.in_unit(PositionUnit::Degree).is_err());
    }
}
