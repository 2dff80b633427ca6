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

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{
    base::Base,
    model::{Identity, Model, Provenance},
    position_unit::PositionUnit,
    selection::Order,
};
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
    /// Unit, as spelled in the table of parameters.
    pub unit: String,
    /// Standard error of an estimate, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
}

/// An effect of a file: its parameters by name.
pub(super) type Effect<Q> = BTreeMap<String, Q>;

/// p of a second-order model, which does not use it.
pub(super) const UNUSED_POLE: f64 = Base::PARAMETERS[1].nominal;

impl Model {
    /// The text of its file.
    ///
    /// # Errors
    /// None in practice; those of the TOML writer.
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
            ("zeta = { value = 0.7", "zeta = { value = -0.7", "line 10: base.zeta: found -0.7 1; allowed: 0 to 1000 1"),
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
