//! Reads and checks the tables of a model file; errors state the line.

use std::{collections::BTreeMap, ops::Range};

use serde::Deserialize;
use toml::Spanned;

use super::{
    base::{Base, BaseParameter},
    model::{Identity, Model, Provenance, converted},
    model_file::{Effect, Quantity, UNUSED_POLE},
    position_unit::PositionUnit,
    selection::Order,
    toml_text::read_toml,
};
use crate::{
    effects::{Effects, Parameter},
    error::{Error, Result},
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    model: ModelTable,
    base: Spanned<BaseTable>,
    #[serde(default)]
    effects: BTreeMap<String, Spanned<Effect<Spanned<Quantity>>>>,
    #[serde(default)]
    provenance: Provenance,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct ModelTable {
    name: Option<Spanned<String>>,
    description: Option<String>,
    unit: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BaseTable {
    order: Spanned<i64>,
    k: Option<Spanned<Quantity>>,
    p: Option<Spanned<Quantity>>,
    omega: Option<Spanned<Quantity>>,
    zeta: Option<Spanned<Quantity>>,
}

const ALLOWED: &str = "[model] with name, description and unit; [base] with order = 2 or 3 and k, p (order 3), omega, zeta, each { value, unit }; \
     [effects.<effect>] with such a table per parameter (`actuator effects` lists them); [provenance]";

impl Model {
    /// Reads the text of a model file.
    ///
    /// # Errors
    /// Not TOML, a missing or unknown key, a unit of another kind, a value outside its range; each with its line.
    pub fn parse(text: &str) -> Result<Self> {
        let reader = Reader { text };
        let file: File = read_toml(text, "model file", ALLOWED)?;
        let identity = reader.identity(file.model)?;
        let place = file.base.span();
        let base = file.base.into_inner();
        let order = match base.order.get_ref() {
            2 => Order::Second,
            3 => Order::Third,
            other => {
                let refused = Error::new("base.order", other.to_string(), "2 or 3");
                return Err(refused
                    .remedy("2 is eq. (6), 3 is eq. (1) with the pole p")
                    .at_line(reader.line(&base.order.span())));
            }
        };
        let (values, std_errors) = reader.base(base, &place, order, identity.unit)?;
        let (effects, effect_std_errors) = reader.effects(&file.effects, identity.unit)?;
        let base = Base::from_values(values).map_err(|error| error.at_line(reader.line(&place)))?;
        Ok(Self { identity, order, base, effects, effect_std_errors, std_errors, provenance: file.provenance })
    }
}

/// Reads the tables of a file; errors state the line.
struct Reader<'a> {
    text: &'a str,
}

impl Reader<'_> {
    fn line(&self, place: &Range<usize>) -> usize {
        1 + self.text.bytes().take(place.start).filter(|byte| *byte == b'\n').count()
    }

    fn identity(&self, table: ModelTable) -> Result<Identity> {
        let unit = match &table.unit {
            None => PositionUnit::default(),
            Some(unit) => unit.get_ref().parse().map_err(|error: Error| {
                error
                    .remedy("it is the unit of positions; what derives from it follows")
                    .at_line(self.line(&unit.span()))
            })?,
        };
        if let Some(name) = &table.name {
            let text = name.get_ref();
            if text.trim().is_empty() || text.chars().any(char::is_control) {
                return Err(Error::new("model.name", format!("{text:?}"), "one line of text")
                    .remedy("give the actuator a name, or remove the line")
                    .at_line(self.line(&name.span())));
            }
        }
        Ok(Identity { name: table.name.map(Spanned::into_inner), description: table.description, unit })
    }

    /// Values and standard errors of k, p, ω, ζ.
    fn base(
        &self,
        table: BaseTable,
        place: &Range<usize>,
        order: Order,
        unit: PositionUnit,
    ) -> Result<([f64; 4], [Option<f64>; 4])> {
        let (mut values, mut std_errors) = ([0.0, UNUSED_POLE, 0.0, 0.0], [None; 4]);
        let quantities = [table.k, table.p, table.omega, table.zeta];
        for (index, (parameter, quantity)) in Base::PARAMETERS.iter().zip(quantities).enumerate() {
            match quantity {
                Some(quantity) => {
                    let at = |error: Error| error.at_line(self.line(&quantity.span()));
                    let scale = |value| base_value(parameter, value, &quantity.get_ref().unit, unit).map_err(at);
                    let value = scale(quantity.get_ref().value)?;
                    let (name, spelled) = (format!("base.{}", parameter.name), unit.derived(parameter.unit));
                    check_range(&name, value, parameter.min, parameter.max, spelled).map_err(at)?;
                    values[index] = value;
                    std_errors[index] = quantity.get_ref().std_error.map(scale).transpose()?.map(f64::abs);
                }
                None if parameter.name == "p" && order == Order::Second => {}
                None => return Err(missing(parameter, order, unit).at_line(self.line(place))),
            }
        }
        Ok((values, std_errors))
    }

    /// Values and standard errors of all effects; those not given are neutral.
    fn effects(
        &self,
        tables: &BTreeMap<String, Spanned<Effect<Spanned<Quantity>>>>,
        unit: PositionUnit,
    ) -> Result<(Effects, Vec<Option<f64>>)> {
        let mut values = Effects::default().values().to_vec();
        let mut std_errors = vec![None; values.len()];
        let known: Vec<&Parameter> = Effects::parameters().map(|(_, parameter)| parameter).collect();
        for (effect, table) in tables {
            let of_table = |error: Error| error.at_line(self.line(&table.span()));
            if table.get_ref().is_empty() {
                let refused = Error::new(format!("effects.{effect}"), "an empty table", "one entry per parameter");
                return Err(of_table(
                    refused.remedy("`actuator effects` lists the parameters; remove the table otherwise"),
                ));
            }
            for (name, quantity) in table.get_ref() {
                let at = |error: Error| error.at_line(self.line(&quantity.span()));
                let unknown = |error: Error| at(error.remedy("`actuator effects` lists all with their meaning"));
                let index = Effects::index(effect, name).map_err(unknown)?;
                let (parameter, Quantity { value, unit: spelled, std_error }) = (known[index], quantity.get_ref());
                let thing = format!("effects.{effect}.{name}");
                let from = unit_of(&thing, parameter, spelled, unit).map_err(at)?;
                values[index] = converted(parameter, *value, from, unit).map_err(at)?;
                let power = PositionUnit::power(parameter.unit);
                std_errors[index] =
                    std_error.map(|error| from.convert_power(error, power, unit)).transpose().map_err(at)?;
                let spelled = unit.derived(parameter.unit);
                check_range(&thing, values[index], parameter.min, parameter.max, spelled).map_err(at)?;
            }
            // Inconsistent values are reported where they are read.
            Effects::with_values(&values).map_err(of_table)?;
        }
        Ok((Effects::with_values(&values)?, std_errors))
    }
}

/// A base parameter that is required for this order.
fn missing(parameter: &BaseParameter, order: Order, unit: PositionUnit) -> Error {
    let (name, meaning, unit) = (parameter.name, parameter.meaning, unit.derived(parameter.unit));
    let allowed = format!("{name}, the {meaning}, for order = {}", order.short());
    let line = format!("add `{name} = {{ value = ..., unit = \"{unit}\" }}`");
    let error = Error::new(format!("base.{name}"), "nothing", allowed);
    if name == "p" { error.remedy(format!("{line}, or set order = 2, which has no pole")) } else { error.remedy(line) }
}

/// The value of a base parameter in the model's units. A gain is a ratio and may be given in any pair of units of the model's kind.
fn base_value(parameter: &BaseParameter, value: f64, spelled: &str, unit: PositionUnit) -> Result<f64> {
    let own = unit.derived(parameter.unit);
    let ratio = own != parameter.unit || parameter.unit == PositionUnit::default().of_gain();
    if spelled == own || ratio && spelled == "1" {
        return Ok(value);
    }
    if ratio {
        let units = spelled.split_once('/').and_then(|(out, by)| Some((out.parse().ok()?, by.parse().ok()?)));
        if let Some((out, by)) = units
            .filter(|(out, by): &(PositionUnit, PositionUnit)| out.kind() == unit.kind() && by.kind() == unit.kind())
        {
            return out.convert(value, by);
        }
    }
    Err(wrong_unit(&format!("base.{}", parameter.name), spelled, own, unit))
}

/// The position unit in which an effect parameter is given: the model's, or another of its kind.
fn unit_of(thing: &str, parameter: &Parameter, spelled: &str, unit: PositionUnit) -> Result<PositionUnit> {
    let stated = |other: PositionUnit| other.kind() == unit.kind() && other.derived(parameter.unit) == spelled;
    std::iter::once(unit)
        .chain(PositionUnit::ALL)
        .find(|other| stated(*other))
        .ok_or_else(|| wrong_unit(thing, spelled, unit.derived(parameter.unit), unit))
}

fn wrong_unit(thing: &str, spelled: &str, own: &str, unit: PositionUnit) -> Error {
    Error::new(format!("unit of {thing}"), format!("`{spelled}`"), format!("`{own}`, since positions are in {unit}"))
        .remedy("convert the value and name the unit it is then in, or state the unit of positions in [model] unit")
}

fn check_range(thing: &str, value: f64, min: f64, max: f64, unit: &str) -> Result<()> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(Error::new(thing, format!("{value} {unit}"), format!("{min} to {max} {unit}")).remedy("correct the value"))
}
