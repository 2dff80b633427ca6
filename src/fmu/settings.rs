//! The parameters and what they select.

use serde::{Deserialize, Serialize};

use crate::{
    actuator::{Actuator, Failure},
    effects::{Effects, PARAMETERS},
    error::Result,
    parameters::{Base, LoadCase, Model, Order, SetName, Stage, Surface, by_number, find},
};

/// Source of k, p, ω and ζ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// A row of the report.
    Table,
    /// The four `custom` values.
    Custom,
}

impl Source {
    /// Both.
    pub const ALL: &'static [Self] = &[Self::Table, Self::Custom];
    /// Their names.
    pub const NAMES: &'static [&'static str] = &["table", "custom"];
}

/// Values of all parameters. Enumerations are item numbers, counted from 1 and checked when set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Item of [`Surface::ALL`].
    pub surface: i32,
    /// Item of [`Stage::ALL`].
    pub stage: i32,
    /// Item of [`LoadCase::ALL`].
    pub load_case: i32,
    /// 0, or the number of a tabulated set.
    pub set_number: i32,
    /// Item of [`Order::ALL`].
    pub order: i32,
    /// Item of [`Source::ALL`].
    pub source: i32,
    /// Custom k, p, ω, ζ.
    pub custom: [f64; 4],
    /// Position at the start \[deg\].
    pub initial_position: f64,
    /// In the order of [`Effects::parameters`].
    #[serde(with = "fixed_length")]
    pub effects: [f64; PARAMETERS],
}

/// Serde supports arrays of up to 32 numbers.
mod fixed_length {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer, const N: usize>(values: &[f64; N], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(values)
    }

    pub fn deserialize<'a, D: Deserializer<'a>, const N: usize>(from: D) -> Result<[f64; N], D::Error> {
        let values = Vec::<f64>::deserialize(from)?;
        values.try_into().map_err(|values: Vec<f64>| D::Error::custom(format!("{} numbers, not {N}", values.len())))
    }
}

/// Item number of a value of an enumeration.
fn item<T: PartialEq>(all: &[T], value: &T) -> i32 {
    all.iter().zip(1..).find(|(other, _)| *other == value).map_or(1, |(_, number)| number)
}

/// The failure with an item number.
pub(super) fn failure(number: i32) -> Failure {
    value(Failure::ALL, number)
}

/// Value with an item number. Numbers are checked when set, so that the fallback to the first item does not occur.
fn value<T: Copy>(all: &[T], number: i32) -> T {
    usize::try_from(number - 1).ok().and_then(|index| all.get(index)).copied().unwrap_or(all[0])
}

impl Default for Settings {
    /// The first row of table 1, third order; the custom values start from the same numbers.
    fn default() -> Self {
        let custom = by_number(1).map_or([1.0, 1e4, 100.0, 1.0], |set| set.base.values());
        let order = item(Order::ALL, &Order::Third);
        Self {
            surface: 1,
            stage: 1,
            load_case: 1,
            set_number: 0,
            order,
            source: 1,
            custom,
            initial_position: 0.0,
            effects: *Effects::default().values(),
        }
    }
}

impl Settings {
    /// Start values of an FMU generated for a model.
    #[must_use]
    pub fn from_model(model: &Model) -> Self {
        Self {
            source: item(Source::ALL, &Source::Custom),
            order: item(Order::ALL, &model.order),
            custom: model.base.values(),
            effects: *model.effects.values(),
            ..Self::default()
        }
    }

    /// Second or third order.
    #[must_use]
    pub fn order(&self) -> Order {
        value(Order::ALL, self.order)
    }

    /// True if the custom values are in use.
    #[must_use]
    pub fn is_custom(&self) -> bool {
        value(Source::ALL, self.source) == Source::Custom
    }

    /// The actuator of these settings.
    ///
    /// # Errors
    /// As [`Settings::base`]; inconsistent parameters of an effect.
    pub fn actuator(&self) -> Result<Actuator> {
        Ok(Actuator::new(self.base()?, self.order(), &Effects::with_values(&self.effects)?))
    }

    /// The parameters in use.
    ///
    /// # Errors
    /// The combination of selectors for which the report has no data.
    pub fn base(&self) -> Result<Base> {
        if self.is_custom() {
            return Base::from_values(self.custom);
        }
        if let Ok(number @ 1..) = usize::try_from(self.set_number) {
            return by_number(number).map(|set| set.base);
        }
        let name = SetName {
            surface: value(Surface::ALL, self.surface),
            stage: value(Stage::ALL, self.stage),
            load_case: value(LoadCase::ALL, self.load_case),
        };
        find(name).map(|set| set.base)
    }
}
