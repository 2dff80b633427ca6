//! Start values of the variables.

use fmi_export::Value;

use super::{settings::Settings, variables::Slot};

/// Start value of an input or parameter; none for calculated variables.
pub fn start_value(slot: Slot, settings: &Settings) -> Option<Value> {
    Some(match slot {
        Slot::Command | Slot::Load => Value::Real(0.0),
        Slot::Failure => Value::Integer(1),
        Slot::Surface => Value::Integer(settings.surface),
        Slot::Stage => Value::Integer(settings.stage),
        Slot::LoadCase => Value::Integer(settings.load_case),
        Slot::SetNumber => Value::Integer(settings.set_number),
        Slot::Order => Value::Integer(settings.order),
        Slot::Source => Value::Integer(settings.source),
        Slot::Custom(index) => Value::Real(settings.custom[index]),
        Slot::InitialPosition => Value::Real(settings.initial_position),
        Slot::Effect(index) => Value::Real(settings.effects[index]),
        Slot::Position
        | Slot::Deflection
        | Slot::Rate
        | Slot::Saturated
        | Slot::Active(_)
        | Slot::State(_)
        | Slot::Slope(_) => {
            return None;
        }
    })
}
