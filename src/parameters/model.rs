//! A model in a file: `[base]`, `[effects.*]`, and provenance.
//!
//! ```toml
//! [base]
//! order = 3
//! k = { value = 1.0198, unit = "deg/deg" }
//! p = { value = 10000.0, unit = "1/s" }
//! omega = { value = 165.26, unit = "rad/s", std_error = 0.4 }
//! zeta = { value = 0.5624, unit = "1" }
//!
//! [effects.backlash]
//! gap = { value = 0.3, unit = "deg" }
//!
//! [provenance]
//! records = ["sweep.csv"]
//! ```

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{base::Base, selection::Order, table::ParameterSet};
use crate::{
    effects::Effects,
    error::{Error, Result},
};

/// A value with its unit and, where it was estimated, its standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// The value, in `unit`.
    pub value: f64,
    /// Unit, spelled as in the contract.
    pub unit: String,
    /// Standard error of an estimate, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
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
    /// How it was estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Date, as given by the caller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
}

/// A model: base dynamics and provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Second or third order.
    pub order: Order,
    /// k, p, ω, ζ.
    pub base: Base,
    /// Effects; neutral ones are not in the file.
    pub effects: Effects,
    /// Standard errors of their parameters, in the order of [`Effects::parameters`], where estimated.
    pub effect_std_errors: Vec<Option<f64>>,
    /// Standard errors in the order of [`Base::PARAMETERS`], where estimated.
    pub std_errors: [Option<f64>; 4],
    /// Provenance.
    pub provenance: Provenance,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    base: BaseTable,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    effects: BTreeMap<String, BTreeMap<String, Quantity>>,
    #[serde(default)]
    provenance: Provenance,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BaseTable {
    order: u8,
    k: Quantity,
    p: Quantity,
    omega: Quantity,
    zeta: Quantity,
}

impl Model {
    /// A model without estimated errors.
    #[must_use]
    pub fn new(base: Base, order: Order) -> Self {
        let effects = Effects::default();
        let effect_std_errors = vec![None; effects.values().len()];
        Self { order, base, std_errors: [None; 4], effects, effect_std_errors, provenance: Provenance::default() }
    }

    /// The third-order model of a row of the report.
    #[must_use]
    pub fn from_set(set: &ParameterSet) -> Self {
        let provenance = Provenance { records: vec![set.source()], ..Provenance::default() };
        Self { provenance, ..Self::new(set.base, Order::Third) }
    }

    /// Reads the text of a model file.
    ///
    /// # Errors
    /// Not TOML, a key that is missing or unknown, a wrong unit, a value outside its range.
    pub fn parse(text: &str) -> Result<Self> {
        let file: File = toml::from_str(text).map_err(|error| {
            Error::new(
                "model file",
                error.to_string().trim().replace('\n', " "),
                "[base] with order = 2 or 3 and k, p, omega, zeta, each { value, unit }; [effects.<effect>]; [provenance]",
            )
        })?;
        let order = match file.base.order {
            2 => Order::Second,
            3 => Order::Third,
            other => return Err(Error::new("base.order", other.to_string(), "2 or 3")),
        };
        let quantities = [file.base.k, file.base.p, file.base.omega, file.base.zeta];
        for (parameter, quantity) in Base::PARAMETERS.iter().zip(&quantities) {
            check_unit(&format!("base.{}", parameter.name), quantity, parameter.unit)?;
        }
        let (effects, effect_std_errors) = read_effects(&file.effects)?;
        Ok(Self {
            order,
            effects,
            effect_std_errors,
            base: Base::from_values(quantities.each_ref().map(|quantity| quantity.value))?,
            std_errors: quantities.map(|quantity| quantity.std_error),
            provenance: file.provenance,
        })
    }

    fn effect_tables(&self) -> BTreeMap<String, BTreeMap<String, Quantity>> {
        let mut tables = BTreeMap::new();
        let values = self.effects.values().iter().zip(&self.effect_std_errors);
        for ((effect, parameter), (value, std_error)) in Effects::parameters().zip(values) {
            if self.effects.active().any(|(active, _)| active.name == effect.name) {
                let quantity = Quantity { value: *value, unit: parameter.unit.into(), std_error: *std_error };
                let table: &mut BTreeMap<_, _> = tables.entry(effect.name.to_owned()).or_default();
                table.insert(parameter.name.to_owned(), quantity);
            }
        }
        tables
    }

    /// The text of its file.
    ///
    /// # Errors
    /// None in practice; the TOML writer's own.
    pub fn to_toml(&self) -> Result<String> {
        let quantity = |index: usize| Quantity {
            value: self.base.values()[index],
            unit: Base::PARAMETERS[index].unit.into(),
            std_error: self.std_errors[index],
        };
        let order = match self.order {
            Order::Second => 2,
            Order::Third => 3,
        };
        let base = BaseTable { order, k: quantity(0), p: quantity(1), omega: quantity(2), zeta: quantity(3) };
        toml::to_string(&File { base, effects: self.effect_tables(), provenance: self.provenance.clone() })
            .map_err(|error| Error::new("model", error.to_string(), "values that TOML can hold"))
    }
}

/// Values and standard errors of all effects; those that are not named are neutral.
fn read_effects(tables: &BTreeMap<String, BTreeMap<String, Quantity>>) -> Result<(Effects, Vec<Option<f64>>)> {
    let mut values = Effects::default().values().to_vec();
    let mut std_errors = vec![None; values.len()];
    for (effect, table) in tables {
        for (name, quantity) in table {
            let index = Effects::index(effect, name)?;
            if let Some((_, parameter)) = Effects::parameters().nth(index) {
                check_unit(&format!("effects.{effect}.{name}"), quantity, parameter.unit)?;
            }
            values[index] = quantity.value;
            std_errors[index] = quantity.std_error;
        }
    }
    Ok((Effects::with_values(&values)?, std_errors))
}

fn check_unit(name: &str, quantity: &Quantity, unit: &str) -> Result<()> {
    if quantity.unit == unit {
        return Ok(());
    }
    Err(Error::new(format!("unit of {name}"), format!("`{}`", quantity.unit), format!("`{unit}`"))
        .remedy("convert the value and name the unit it is then in"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::table;

    #[test]
    fn a_model_survives_its_file_to_the_bit() {
        for set in table() {
            let mut model = Model::from_set(set);
            model.std_errors = [Some(0.1 + f64::EPSILON), None, Some(1e-300), None];
            let index = Effects::index("rate_limit", "down").unwrap();
            model.effects =
                model.effects.with(crate::effects::find("rate_limit").unwrap(), &[100.0, 0.1 + 0.2]).unwrap();
            model.effect_std_errors[index] = Some(0.3);
            assert_eq!(Model::parse(&model.to_toml().unwrap()).unwrap(), model);
        }
    }

    #[test]
    fn wrong_keys_units_and_orders_are_refused_by_name() {
        let good = Model::from_set(&table()[0]).to_toml().unwrap();
        for (from, to, names) in [
            ("order = 3", "order = 4", "base.order"),
            ("rad/s", "Hz", "base.omega"),
            ("[base.k]", "[base.gain]", "gain"),
            ("[base]", "[basis]", "order"),
            ("[base]", "[effects.backlash]\ngap = { value = 0.1, unit = \"rad\" }\n[base]", "effects.backlash.gap"),
            ("[base]", "[effects.slack]\ngap = { value = 0.1, unit = \"deg\" }\n[base]", "slack"),
            ("[base]", "[effects.backlash]\ngap = { value = -0.1, unit = \"deg\" }\n[base]", "backlash.gap"),
        ] {
            let message = Model::parse(&good.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(names), "{message}");
        }
    }
}
