//! The transfer functions of the report, and their responses.

use nalgebra::Complex;

use actuator_fmu::parameters::{Base, Order};

/// Eq. (1) or (6) of NASA/TM-1998-208452 at a frequency \[Hz\]:
/// H = k p ω² / ((s + p)(s² + 2ζω s + ω²)) or k ω² / (s² + 2ζω s + ω²), s = 2πj f.
#[must_use]
pub fn response(base: &Base, order: Order, frequency_hz: f64) -> Complex<f64> {
    let s = Complex::new(0.0, std::f64::consts::TAU * frequency_hz);
    let omega2 = base.omega() * base.omega();
    let second = Complex::from(base.k() * omega2) / (s * s + s * (2.0 * base.zeta() * base.omega()) + omega2);
    match order {
        Order::Second => second,
        // Divided by p before addition to s: p = 2.97e8 keeps the digits of s.
        Order::Third => second / (s / base.p() + 1.0),
    }
}

/// Angle of a response \[deg\].
#[must_use]
pub fn phase_deg(response: Complex<f64>) -> f64 {
    response.arg().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::parameters::find;

    #[test]
    fn leaving_out_the_pole_turns_the_phase_as_figure_seven_shows() {
        // Lower spoiler, early, unloaded: atan(2π 12 / p) = 0.432 deg at 12 Hz and 3e-5 in magnitude.
        let set = find("ls-early-unloaded".parse().unwrap()).unwrap();
        let (third, second) = (response(&set.base, Order::Third, 12.0), response(&set.base, Order::Second, 12.0));
        assert!((phase_deg(second * third.conj()) - 0.432).abs() < 5e-4);
        assert!(((second.norm() - third.norm()) - 3e-5).abs() < 1e-5);
    }
}
