//! A model in a file: `[model]`, `[base]`, `[effects.*]`, and provenance.
//!
//! ```toml
//! [model]
//! name = "Rudder"
//! description = "Rudder servo of the test rig, new"
//! unit = "mm"                                # of positions: deg (default), rad, mm, m or 1
//!
//! [base]
//! order = 3                                  # 2 needs no p
//! k = { value = 1.0198, unit = "mm/mm" }
//! p = { value = 10000.0, unit = "1/s" }
//! omega = { value = 165.26, unit = "rad/s", std_error = 0.4 }
//! zeta = { value = 0.5624, unit = "1" }
//!
//! [effects.backlash]
//! gap = { value = 0.3, unit = "mm" }
//!
//! [provenance]
//! records = ["sweep.csv"]
//! ```
//!
//! A value may be in another unit of the same kind (a gap in mm in a model whose positions are in m); it is converted when read.

use std::{collections::BTreeMap, ops::Range};

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::{
    base::{Base, BaseParameter},
    model::{Identity, Model, Provenance, converted},
    position_unit::PositionUnit,
    selection::Order,
};
use crate::{
    effects::{Effects, Parameter},
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

type Effect<Q> = BTreeMap<String, Q>;

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

/// p of a second-order model, which does not use it.
const UNUSED_POLE: f64 = Base::PARAMETERS[1].nominal;

impl Model {
    /// Reads the text of a model file.
    ///
    /// # Errors
    /// Not TOML, a key that is missing or unknown, a unit of another kind, a value outside its range; each with its line.
    pub fn parse(text: &str) -> Result<Self> {
        let reader = Reader { text };
        let file: File = toml::from_str(text).map_err(|error| {
            let refused = Error::new("model file", error.message().trim().replace('\n', " "), ALLOWED)
                .remedy("correct or remove what is named");
            error.span().map_or(refused.clone(), |place| refused.at_line(reader.line(&place)))
        })?;
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

    /// The text of its file.
    ///
    /// # Errors
    /// None in practice; the TOML writer's own.
    pub fn to_toml(&self) -> Result<String> {
        #[derive(Serialize)]
        struct File<'a> {
            model: ModelTable<'a>,
            base: BaseTable,
            #[serde(skip_serializing_if = "BTreeMap::is_empty")]
            effects: BTreeMap<&'static str, Effect<Quantity>>,
            provenance: &'a Provenance,
        }
        #[derive(Serialize)]
        struct ModelTable<'a> {
            #[serde(skip_serializing_if = "Option::is_none")]
            name: Option<&'a str>,
            #[serde(skip_serializing_if = "Option::is_none")]
            description: Option<&'a str>,
            unit: PositionUnit,
        }
        #[derive(Serialize)]
        struct BaseTable {
            order: u8,
            k: Quantity,
            #[serde(skip_serializing_if = "Option::is_none")]
            p: Option<Quantity>,
            omega: Quantity,
            zeta: Quantity,
        }
        let quantity = |index: usize| Quantity {
            value: self.base.values()[index],
            unit: self.unit().derived(Base::PARAMETERS[index].unit).into(),
            std_error: self.std_errors[index],
        };
        let order = match self.order {
            Order::Second => 2,
            Order::Third => 3,
        };
        let has_pole = self.order == Order::Third || self.base.p() != UNUSED_POLE;
        let base = BaseTable {
            order,
            k: quantity(0),
            p: has_pole.then(|| quantity(1)),
            omega: quantity(2),
            zeta: quantity(3),
        };
        let Identity { name, description, unit } = &self.identity;
        let model = ModelTable { name: name.as_deref(), description: description.as_deref(), unit: *unit };
        toml::to_string(&File { model, base, effects: self.effect_tables(), provenance: &self.provenance })
            .map_err(|error| Error::new("model", error.to_string(), "values that TOML can hold"))
    }

    fn effect_tables(&self) -> BTreeMap<&'static str, Effect<Quantity>> {
        let mut tables: BTreeMap<&'static str, Effect<Quantity>> = BTreeMap::new();
        let values = self.effects.values().iter().zip(&self.effect_std_errors);
        for ((effect, parameter), (value, std_error)) in Effects::parameters().zip(values) {
            if self.effects.active().any(|(active, _)| active.name == effect.name) {
                let unit = self.unit().derived(parameter.unit).into();
                let quantity = Quantity { value: *value, unit, std_error: *std_error };
                tables.entry(effect.name).or_default().insert(parameter.name.to_owned(), quantity);
            }
        }
        tables
    }
}

/// Reads the tables of a file, with the lines of what it refuses.
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
                    values[index] = scale(quantity.get_ref().value)?;
                    std_errors[index] = quantity.get_ref().std_error.map(scale).transpose()?.map(f64::abs);
                }
                None if parameter.name == "p" && order == Order::Second => {}
                None => return Err(missing(parameter, order, unit).at_line(self.line(place))),
            }
        }
        for (parameter, value) in Base::PARAMETERS.iter().zip(values) {
            check_range(
                &format!("base.{}", parameter.name),
                value,
                parameter.min,
                parameter.max,
                unit.derived(parameter.unit),
            )
            .map_err(|error| error.at_line(self.line(place)))?;
        }
        Ok((values, std_errors))
    }

    /// Values and standard errors of all effects; those that are not named are neutral.
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
            // What is inconsistent is found where it is read.
            Effects::with_values(&values).map_err(of_table)?;
        }
        Ok((Effects::with_values(&values)?, std_errors))
    }
}

/// A base parameter that a file of this order has to state.
fn missing(parameter: &BaseParameter, order: Order, unit: PositionUnit) -> Error {
    let (name, meaning, unit) = (parameter.name, parameter.meaning, unit.derived(parameter.unit));
    let allowed = format!("{name}, the {meaning}, for order = {}", order.short());
    let line = format!("add `{name} = {{ value = ..., unit = \"{unit}\" }}`");
    let error = Error::new(format!("base.{name}"), "nothing", allowed);
    if name == "p" { error.remedy(format!("{line}, or set order = 2, which has no pole")) } else { error.remedy(line) }
}

/// The value of a base parameter in the model's units. A gain is a ratio: any pair of units of the model's kind states it.
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

/// The unit of positions in which a parameter of an effect is stated: the model's, or another of its kind.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{effects::find, parameters::table};

    #[test]
    fn a_model_survives_its_file_to_the_bit() {
        for (set, unit) in table().iter().zip(PositionUnit::ALL.into_iter().cycle()) {
            let mut model = Model::from_set(set);
            model.identity.unit = unit;
            model.identity.description = Some("of \"steel\",\n with <oil>".into());
            model.std_errors = [Some(0.1 + f64::EPSILON), None, Some(1e-300), None];
            let index = Effects::index("rate_limit", "down").unwrap();
            model.effects = model.effects.with(find("rate_limit").unwrap(), &[100.0, 0.1 + 0.2]).unwrap();
            model.effect_std_errors[index] = Some(0.3);
            assert_eq!(Model::parse(&model.to_toml().unwrap()).unwrap(), model);
            model.order = Order::Second;
            assert_eq!(Model::parse(&model.to_toml().unwrap()).unwrap(), model);
        }
    }

    const GOOD: &str = "[model]\nname = \"Rudder\"\nunit = \"mm\"\n\n[base]\norder = 3\nk = { value = 1.0, unit = \"mm/mm\" }\n\
        p = { value = 1e4, unit = \"1/s\" }\nomega = { value = 100.0, unit = \"rad/s\" }\nzeta = { value = 0.7, unit = \"1\" }\n\n\
        [effects.backlash]\ngap = { value = 0.1, unit = \"mm\" }\n";

    #[test]
    fn what_is_wrong_is_refused_with_line_what_is_allowed_and_a_remedy() {
        assert!(Model::parse(GOOD).is_ok());
        for (from, to, words) in [
            ("order = 3", "order = 4", "line 6: base.order: found 4; allowed: 2 or 3"),
            ("rad/s", "Hz", "line 9: unit of base.omega: found `Hz`; allowed: `rad/s`"),
            ("p = { value = 1e4, unit = \"1/s\" }\n", "", "line 5: base.p: found nothing"),
            ("p = { value = 1e4, unit = \"1/s\" }\n", "", "or set order = 2"),
            ("zeta = { value = 0.7, unit = \"1\" }\n", "", "base.zeta: found nothing"),
            ("zeta = { value = 0.7", "zeta = { value = -0.7", "base.zeta: found -0.7 1; allowed: 0 to 1000 1"),
            ("k = {", "gain = {", "line 7: model file: found unknown field `gain`"),
            ("k = { value = 1.0, unit = \"mm/mm\" }", "k = 1.0", "line 7: model file"),
            (
                "\"mm/mm\"",
                "\"deg/deg\"",
                "line 7: unit of base.k: found `deg/deg`; allowed: `mm/mm`, since positions are in mm",
            ),
            ("unit = \"mm\"\n\n", "unit = \"inch\"\n\n", "line 3: unit: found `inch`; allowed: rad, deg, mm, m or 1"),
            ("unit = \"mm\"\n\n", "unit = \"deg\"\n\n", "unit of base.k: found `mm/mm`; allowed: `deg/deg`"),
            ("\"Rudder\"", "\"\"", "line 2: model.name"),
            ("name =", "title =", "line 2: model file: found unknown field `title`"),
            (
                "gap = { value = 0.1, unit = \"mm\" }",
                "gap = { value = 0.1, unit = \"rad\" }",
                "line 13: unit of effects.backlash.gap",
            ),
            ("gap = { value = 0.1", "gap = { value = -0.1", "line 13: effects.backlash.gap: found -0.1 mm"),
            ("gap =", "play =", "line 13: effect parameter: found backlash.play; allowed: gap"),
            ("[effects.backlash]", "[effects.slack]", "effect parameter: found slack.gap"),
            ("[base]", "[basis]", "unknown field `basis`"),
        ] {
            let message = Model::parse(&GOOD.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(message.contains(words), "{message}\n{words}");
            assert!(message.matches("; ").count() >= 2, "no remedy: {message}");
        }
    }

    #[test]
    fn values_in_other_units_of_the_same_kind_are_converted() {
        let metres = GOOD.replace("unit = \"mm\"\n\n", "unit = \"m\"\n\n");
        let model = Model::parse(&metres).unwrap();
        assert_eq!(model.effects.values()[Effects::index("backlash", "gap").unwrap()], 1e-4);
        for (spelled, k) in [("mm/mm", 1.0), ("m/m", 1.0), ("1", 1.0), ("mm/m", 1e-3), ("m/mm", 1e3)] {
            assert_eq!(Model::parse(&GOOD.replace("mm/mm", spelled)).unwrap().base.k(), k, "{spelled}");
        }
    }

    #[test]
    fn second_order_needs_no_pole() {
        let text = GOOD.replace("order = 3", "order = 2").replace("p = { value = 1e4, unit = \"1/s\" }\n", "");
        let model = Model::parse(&text).unwrap();
        assert_eq!(model.order, Order::Second);
        assert!(!model.to_toml().unwrap().contains("[base.p]"));
        assert_eq!(Model::parse(&model.to_toml().unwrap()).unwrap(), model);
    }
}
