//! Hypotheses: which effects a model lacks, whether its base is free, and what they are called.

use actuator_fmu::effects::{self, Effect};

/// Name of the hypothesis that only the parameters of the base are wrong.
pub const PARAMETER_SHIFT: &str = "parameter_shift";

pub const DELAY: &str = "delay";
pub const SENSOR_LAG: &str = "sensor_lag";

/// Effects that lag in the same way as a pole.
pub const LAGS: [&str; 2] = [DELAY, SENSOR_LAG];

/// A set of effects added to those of the given model, and what is free with them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hypothesis {
    /// Effects added, in this order.
    pub effects: Vec<&'static str>,
    /// Whether k, ω and ζ are free, and with them the effects of the given model.
    pub base_free: bool,
    /// Whether the effects of the given model are held all the same.
    pub given_held: bool,
    /// Whether p is free as well, near the given one: for a base with a wrong pole rather than a lag.
    pub pole_free: bool,
    /// Whether the base may leave the neighbourhood of the given one: wide ranges, p free, and a level in each record.
    pub wide: bool,
}

impl Hypothesis {
    /// Names of the effects, joined; without effects, what is free.
    pub fn name(&self) -> String {
        match (self.effects.as_slice(), self.base_free) {
            ([], false) => "none".to_owned(),
            ([], true) => PARAMETER_SHIFT.to_owned(),
            (effects, _) => effects.join(" + "),
        }
    }

    /// Its delay or lag, the first where there are two.
    pub fn lag(&self) -> Option<&'static Effect> {
        self.effects.iter().find(|effect| LAGS.contains(effect)).and_then(|name| effects::find(name))
    }

    /// Family of the effect that was added last.
    pub fn family(&self) -> &'static str {
        match (self.effects.last(), self.base_free) {
            (None, false) => "none",
            (None, true) => family(PARAMETER_SHIFT),
            (Some(effect), _) => family(effect),
        }
    }
}

/// Family of an effect.
pub fn family(effect: &str) -> &'static str {
    if effect == PARAMETER_SHIFT {
        return "lag";
    }
    effects::find(effect).map_or("", |effect| effect.family.name())
}

/// Effects that are added to the measurement, with factors that are free in each record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasurementTerm {
    /// `sensor_bias`: 1 and t.
    Bias,
    /// `chatter`: sine and cosine of a common frequency.
    Chatter,
    /// The level of a record: 1. No effect, and free in each record.
    Level,
}

impl MeasurementTerm {
    /// The measurement term of an effect, if it is one.
    pub fn of(effect: &str) -> Option<Self> {
        match effect {
            "sensor_bias" => Some(Self::Bias),
            "chatter" => Some(Self::Chatter),
            _ => None,
        }
    }

    /// Parameters counted in the BIC, once for all records.
    pub fn parameters(self) -> usize {
        match self {
            Self::Bias | Self::Chatter => 2,
            Self::Level => 1,
        }
    }
}
