//! Bounds of f = Q + Σ D_i, polynomial and decays minus a limit, from its values at one instant: they exclude most crossings.
//!
//! With Q at most a parabola of second derivative B from there on, f at a time s later is at most each of
//!
//! ```text
//! Q + Σ D_i + (Q' + Σ D_i') s + (B + Σ' D_i'') s² / 2             tangents; Σ' over decays that fall to 0 from above
//! Q + Σ' D_i + Q' s + B s² / 2                                    decays frozen, or at 0 where they rise to it
//! tangents + Σ" D_i'' e^-2 s² / 2                                 up to s = 2 / k; Σ" over decays that rise to 0, the fastest with k
//! ```

use super::{
    range::Range,
    root::Point,
    taylor::{BEYOND_PARABOLA, BEYOND_PARABOLA_OF_DERIVATIVE, Decay, Series, TURN},
};

/// A signal at τ = 0, with bounds of its distance from its parabola there.
pub(super) struct Outline {
    polynomial: f64,
    slope: f64,
    second: f64,
    /// Sums of the positive and of the negative coefficients of the polynomial beyond the third one, at least 0.
    beyond: [f64; 2],
    decays: [Decay; 2],
}

impl Outline {
    fn new([polynomial, slope, second]: [f64; 3], (sum, magnitude): (f64, f64), decays: [Decay; 2]) -> Self {
        Self { polynomial, slope, second, beyond: [0.5 * (magnitude + sum), 0.5 * (magnitude - sum)], decays }
    }

    #[inline]
    pub fn of(series: &Series) -> Self {
        let terms = &series.terms;
        let sums = series.signed_and_absolute_sum(&BEYOND_PARABOLA);
        Self::new([terms[0], terms[1], 2.0 * terms[2]], sums, series.decays)
    }

    pub fn of_derivative(series: &Series) -> Self {
        let terms = &series.terms;
        let sums = series.signed_and_absolute_sum(&BEYOND_PARABOLA_OF_DERIVATIVE);
        Self::new([terms[1], 2.0 * terms[2], 6.0 * terms[3]], sums, series.decays.map(Decay::derivative))
    }

    /// f = sign × (signal - limit) at τ = 0.
    #[inline]
    pub fn local(&self, sign: f64, limit: f64) -> Local {
        let mut local = Local::polynomial(sign * (self.polynomial - limit), sign * self.slope);
        for decay in self.decays.iter().filter(|decay| decay.amplitude != 0.0) {
            local.add(sign * decay.amplitude, decay.exponent);
        }
        local
    }

    /// Up to this τ, at most 1, the polynomial of f is below the parabola from τ = 0 with this second derivative: τ^n is at most τ² ×
    /// until.
    pub fn bend(&self, sign: f64, until: f64) -> f64 {
        sign * self.second + 2.0 * until * self.beyond[usize::from(sign < 0.0)]
    }

    /// True if bounds exclude a crossing of the upper limit, and of the lower one, up to this τ.
    pub fn stays_in(&self, limits: Range, until: f64) -> [bool; 2] {
        // An infinite limit is never reached.
        [(1.0, limits.high), (-1.0, limits.low)].map(|(sign, limit)| {
            limit == sign * f64::INFINITY || self.local(sign, limit).stays(self.bend(sign, until), until)
        })
    }
}

/// Time ahead of τ = 0, at most `until`, for which f = sign × (signal - limit) is at or below 0 because its third derivative is not
/// positive; 0 if this cannot be shown. A signal leaves a limit on which it lay with zero slope and second derivative, far from any bound
/// by the second derivative:
///
/// ```text
/// f''' <= T - Σ' |D_i'''| e^(-k τ)      T polynomial and decays that rise, at most; Σ' over decays that fall, the fastest with k
/// ```
pub(super) fn reach_by_third_derivative(series: &Series, sign: f64, limit: f64, until: f64) -> f64 {
    let terms = &series.terms;
    let start = [sign * (terms[0] - limit), sign * terms[1], 2.0 * sign * terms[2]];
    let [mut value, mut slope, mut bend] = start;
    let (sum, magnitude) = series.signed_and_absolute_sum(&TURN);
    let mut most = 6.0 * sign * terms[3] + 0.5 * until * (magnitude + sign * sum);
    let (mut falling, mut rate) = (0.0, 0.0_f64);
    for Decay { amplitude, exponent } in series.decays.iter().filter(|decay| decay.amplitude != 0.0) {
        let [by_value, by_slope] = [sign * amplitude, -sign * amplitude * exponent];
        let by_bend = -exponent * by_slope;
        (value, slope, bend) = (value + by_value, slope + by_slope, bend + by_bend);
        if by_value > 0.0 {
            (falling, rate) = (falling + exponent * by_bend, rate.max(*exponent));
        } else {
            most -= exponent * by_bend;
        }
    }
    if value > 0.0 || slope > 0.0 || bend > 0.0 || most > falling {
        0.0
    } else if most <= 0.0 {
        until
    } else {
        ((falling / most).ln() / rate).min(until)
    }
}

/// a + b s + c s² / 2
struct Parabola {
    value: f64,
    slope: f64,
    bend: f64,
}

impl Parabola {
    /// The polynomial from s on.
    fn from(&self, s: f64) -> Self {
        let Self { value, slope, bend } = self;
        Self { value: value + (slope + 0.5 * bend * s) * s, slope: slope + bend * s, bend: *bend }
    }

    /// True if it is at or below 0 for this long.
    fn stays(&self, long: f64) -> bool {
        let Self { value, slope, bend } = *self;
        let ends_below = value + (slope + 0.5 * bend * long) * long <= 0.0;
        // One that opens upward is highest at an end, otherwise possibly at its vertex.
        value <= 0.0
            && if bend >= 0.0 || slope + bend * long >= 0.0 {
                ends_below
            } else {
                slope <= 0.0 || slope * slope <= 2.0 * value * bend
            }
    }

    /// Time ahead for which it is at or below 0; infinite if always.
    fn reach(&self) -> f64 {
        let Self { value, slope, bend } = *self;
        if value > 0.0 {
            return 0.0;
        }
        let square = slope * slope - 2.0 * value * bend;
        if slope > 0.0 && square >= 0.0 {
            -2.0 * value / (slope + square.sqrt())
        } else if slope <= 0.0 && bend > 0.0 {
            (square.sqrt() - slope) / bend
        } else {
            f64::INFINITY
        }
    }
}

/// Value and slope of f at an instant, in parts.
#[derive(Clone, Copy)]
pub(super) struct Local {
    pub polynomial: f64,
    pub slope: f64,
    /// Decays that fall to 0 from above: value, slope (negative), second derivative.
    pub falling: [f64; 3],
    /// Decays that rise to 0 from below: value (negative), slope, second derivative (negative).
    pub rising: [f64; 3],
    /// Largest rate of these.
    rate: f64,
}

/// Number of time constants after which the second derivative of a decay is [`REST`] of its initial value.
const TIME_CONSTANTS: f64 = 2.0;
/// e^-2
const REST: f64 = 0.135_335_283_236_612_7;

impl Local {
    pub fn polynomial(value: f64, slope: f64) -> Self {
        Self { polynomial: value, slope, falling: [0.0; 3], rising: [0.0; 3], rate: 0.0 }
    }

    /// Adds a decay with this value and rate.
    pub fn add(&mut self, value: f64, rate: f64) {
        let into = if value > 0.0 { &mut self.falling } else { &mut self.rising };
        let slope = -rate * value;
        *into = [into[0] + value, into[1] + slope, into[2] - rate * slope];
        self.rate = if value > 0.0 { self.rate } else { self.rate.max(rate) };
    }

    pub fn value(&self) -> f64 {
        self.polynomial + self.falling[0] + self.rising[0]
    }

    pub fn total_slope(&self) -> f64 {
        self.slope + self.falling[1] + self.rising[1]
    }

    pub fn point(&self, tau: f64) -> Point {
        Point { tau, value: self.value(), slope: self.total_slope(), decaying: self.rising[1] - self.falling[1] }
    }

    fn tangents(&self, bend: f64) -> Parabola {
        Parabola { value: self.value(), slope: self.total_slope(), bend: bend + self.falling[2] }
    }

    fn frozen(&self, bend: f64) -> Parabola {
        Parabola { value: self.polynomial + self.falling[0], slope: self.slope, bend }
    }

    /// The bound up to two time constants of the rising decays, and that time.
    fn curved(&self, bend: f64) -> (Parabola, f64) {
        let tangents = self.tangents(bend);
        (Parabola { bend: tangents.bend + REST * self.rising[2], ..tangents }, TIME_CONSTANTS / self.rate)
    }

    /// True if f is at or below 0 for this long, with its polynomial below the parabola of this second derivative.
    #[inline]
    pub fn stays(&self, bend: f64, long: f64) -> bool {
        if self.tangents(bend).stays(long) || self.frozen(bend).stays(long) {
            return true;
        }
        if self.rising[0] == 0.0 {
            return false;
        }
        let (curved, short) = self.curved(bend);
        curved.stays(short.min(long)) && (short >= long || self.frozen(bend).from(short).stays(long - short))
    }

    /// Time ahead for which f is at or below 0, likewise.
    pub fn reach(&self, bend: f64) -> f64 {
        let reach = self.frozen(bend).reach().max(self.tangents(bend).reach());
        if self.rising[0] == 0.0 {
            return reach;
        }
        let (curved, short) = self.curved(bend);
        let first = curved.reach();
        reach.max(if first < short { first } else { short + self.frozen(bend).from(short).reach() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ÿ of a surface leaving a stop, when the force that held it passes 0: T τ - K (1 - e^(-k τ)) / k etc., with zero value, slope and
    /// second derivative.
    fn leaving(third: f64, decaying: f64, exponent: f64) -> Series {
        let amplitude = decaying / exponent.powi(3);
        let [slope, bend] = [amplitude * exponent, amplitude * exponent * exponent];
        let mut series = Series::polynomial(&[-amplitude, slope, -0.5 * bend, third / 6.0]);
        series.decays[0] = Decay { amplitude, exponent };
        series
    }

    #[test]
    fn what_leaves_its_limit_without_slope_and_bend_is_seen_to_stay_while_its_third_derivative_is_negative() {
        let limit = 1e-12;
        // Its third derivative is 0.015 - 0.84 e^(-48 τ): below 0 up to ln(56) / 48.
        let series = leaving(0.015, 0.84, 48.0);
        let reach = reach_by_third_derivative(&series, 1.0, limit, 1.0);
        assert!((reach - 56_f64.ln() / 48.0).abs() < 1e-12, "{reach}");
        // Decays only: up to the end.
        assert_eq!(reach_by_third_derivative(&leaving(-0.015, 0.84, 48.0), 1.0, limit, 0.7), 0.7);
        // It rises from the start, or is beyond the limit: nothing can be shown.
        assert_eq!(reach_by_third_derivative(&leaving(0.9, 0.84, 48.0), 1.0, limit, 1.0), 0.0);
        assert_eq!(reach_by_third_derivative(&series, 1.0, -limit, 1.0), 0.0);
        assert_eq!(reach_by_third_derivative(&series, -1.0, -limit, 1.0), 0.0);
    }
}
