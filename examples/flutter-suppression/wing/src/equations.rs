//! The equations: a rigid wing that plunges and pitches on springs in quasi-steady flow, and its control law.
//!
//! Plunge h is positive down, pitch θ nose up, both at the elastic axis, deflection δ trailing edge down, gust w up, force F
//! down. With dynamic pressure q, speed U, area S, chord c:
//!
//! ```text
//! m ḧ + S_hθ θ̈ + D_h ḣ + K_h h = -q S C_L + F
//! S_hθ ḧ + I θ̈ + D_θ θ̇ + K_θ θ = q S c C_m
//! C_L = C_Lα (α + w/U) + c/(2U) (C_Lα̇ α̇ + C_Lq θ̇) + C_Lδ δ,   α = θ + ḣ/U,   C_m alike
//! ```
//!
//! Control law, command \[deg\] from pitch \[rad\]: command = -C(s) θ, C(s) = -(b₀ s² + b₁ s + b₂) / (s² + a₁ s), here with two
//! states ẋ = e, ė = θ - a₁ e:
//!
//! ```text
//! command = b₀ θ + (b₁ - a₁ b₀) e + b₂ x
//! ```
//!
//! Numbers, equations and control law: the MathWorks flutter-suppression example for the BACT; the wing agrees with Waszak,
//! NASA/TP-1998-206270. The sign of S_hθ is not confirmed there.

use nalgebra::{Matrix2, RowSVector, SMatrix, Vector2};

/// States: h \[ft\], θ \[rad\], ḣ, θ̇, x, e.
pub const STATES: usize = 6;
/// Inputs: deflection \[deg\], gust [ft/s], force \[lb\].
pub const INPUTS: usize = 3;

/// Rows of the states.
pub const PLUNGE: usize = 0;
/// Pitch.
pub const PITCH: usize = 1;

const MASS_SLUG: f64 = 6.08;
const INERTIA_SLUG_FT2: f64 = 2.80;
const COUPLING_SLUG_FT: f64 = -0.0142;
const PLUNGE_STIFFNESS_LB_FT: f64 = 2686.0;
const PITCH_STIFFNESS_FT_LB: f64 = 3000.0;
/// Damping ratio 0.0014 at 21.01 rad/s [lb s/ft].
const PLUNGE_DAMPING: f64 = 2.0 * 0.0014 * MASS_SLUG * 21.01;
/// Damping ratio 0.0010 at 32.71 rad/s [ft lb s].
const PITCH_DAMPING: f64 = 2.0 * 0.0010 * INERTIA_SLUG_FT2 * 32.71;
const AREA_FT2: f64 = 3.55;
const CHORD_FT: f64 = 1.33;

/// Derivatives of lift and moment coefficients by one quantity [1/rad]; the moment is about the elastic axis.
struct Derivatives {
    lift: f64,
    moment: f64,
}

const ATTACK: Derivatives = Derivatives { lift: 4.584, moment: 1.490 };
const ATTACK_RATE: Derivatives = Derivatives { lift: -3.1064, moment: -2.6505 };
const PITCH_RATE: Derivatives = Derivatives { lift: 2.5625, moment: -0.4035 };
const DEFLECTION: Derivatives = Derivatives { lift: 0.63, moment: -0.0246 };

/// b₀, b₁, b₂ of the control law [deg/rad and powers of 1/s].
const NUMERATOR: [f64; 3] = [10_393.798_954, 80_183.687_475, 565_082.359_817];
/// a₁ of the control law [1/s].
const POLE: f64 = 100.0;

/// Flow condition and gain of the loop.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Condition {
    /// Dynamic pressure \[psf\].
    pub pressure_psf: f64,
    /// Speed [ft/s].
    pub speed_ft_s: f64,
    /// The command is multiplied by this: 1 closes the loop, 0 opens it.
    pub gain: f64,
}

/// ż = A z + B u, command = c z.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// A.
    pub states: SMatrix<f64, STATES, STATES>,
    /// B.
    pub inputs: SMatrix<f64, STATES, INPUTS>,
    /// c \[deg\].
    pub command: RowSVector<f64, STATES>,
}

impl Condition {
    /// The linear system of this condition. `None` where the mass matrix is singular, which no admissible
    /// flow condition causes.
    #[must_use]
    pub fn system(&self) -> Option<System> {
        let load = |d: &Derivatives| self.pressure_psf * AREA_FT2 * Vector2::new(-d.lift, CHORD_FT * d.moment);
        let half_chord_time = CHORD_FT / (2.0 * self.speed_ft_s);
        // α = θ + ḣ/U and α̇ = θ̇ + ḧ/U, by state.
        let by_acceleration = load(&ATTACK_RATE) * (half_chord_time / self.speed_ft_s);
        let by_plunge_rate = load(&ATTACK) / self.speed_ft_s;
        let by_pitch_rate = (load(&ATTACK_RATE) + load(&PITCH_RATE)) * half_chord_time;

        let mut mass = Matrix2::new(MASS_SLUG, COUPLING_SLUG_FT, COUPLING_SLUG_FT, INERTIA_SLUG_FT2);
        mass.set_column(0, &(mass.column(0) - by_acceleration));
        let mut damping = Matrix2::new(PLUNGE_DAMPING, 0.0, 0.0, PITCH_DAMPING);
        damping.set_column(0, &(damping.column(0) - by_plunge_rate));
        damping.set_column(1, &(damping.column(1) - by_pitch_rate));
        let mut stiffness = Matrix2::new(PLUNGE_STIFFNESS_LB_FT, 0.0, 0.0, PITCH_STIFFNESS_FT_LB);
        stiffness.set_column(1, &(stiffness.column(1) - load(&ATTACK)));
        let inverse_mass = mass.try_inverse()?;

        let mut states = SMatrix::<f64, STATES, STATES>::zeros();
        states.fixed_view_mut::<2, 2>(0, 2).fill_with_identity();
        states.fixed_view_mut::<2, 2>(2, 0).copy_from(&(-inverse_mass * stiffness));
        states.fixed_view_mut::<2, 2>(2, 2).copy_from(&(-inverse_mass * damping));
        // x and e of the control law.
        states[(4, 5)] = 1.0;
        states[(5, PITCH)] = 1.0;
        states[(5, 5)] = -POLE;

        let mut inputs = SMatrix::<f64, STATES, INPUTS>::zeros();
        for (column, loads) in
            [load(&DEFLECTION) * 1.0_f64.to_radians(), load(&ATTACK) / self.speed_ft_s, Vector2::new(1.0, 0.0)]
                .into_iter()
                .enumerate()
        {
            inputs.fixed_view_mut::<2, 1>(2, column).copy_from(&(inverse_mass * loads));
        }
        let [b0, b1, b2] = NUMERATOR;
        let command = RowSVector::from([0.0, b0, 0.0, 0.0, b2, b1 - POLE * b0]) * self.gain;
        Some(System { states, inputs, command })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn modes(pressure_psf: f64) -> Vec<(f64, f64)> {
        let system = Condition { pressure_psf, speed_ft_s: 385.0, gain: 1.0 }.system().unwrap();
        let wing = system.states.fixed_view::<4, 4>(0, 0).into_owned();
        let mut modes: Vec<_> = wing
            .complex_eigenvalues()
            .iter()
            .filter(|root| root.im > 0.0)
            .map(|root| (root.re.hypot(root.im), root))
            .map(|(size, root)| (size / std::f64::consts::TAU, -root.re / size))
            .collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes
    }

    #[test]
    fn without_wind_the_modes_are_those_of_the_mount() {
        let modes = modes(0.0);
        for ((frequency_hz, damping), (expected_hz, expected)) in modes.iter().zip([(3.345, 0.0014), (5.210, 0.0010)]) {
            assert!((frequency_hz - expected_hz).abs() < 0.001, "{frequency_hz} Hz");
            assert!((damping - expected).abs() < 1e-5, "{damping}");
        }
    }

    /// Damping ratios of the critical mode, computed apart from this code, to the four digits that they were given with.
    #[test]
    fn the_critical_mode_loses_its_damping_near_146_psf() {
        for (pressure_psf, expected) in [
            (100.0, 0.0086),
            (140.0, 0.0020),
            (150.0, -0.0018),
            (160.0, -0.0067),
            (175.0, -0.0160),
            (200.0, -0.0339),
            (225.0, -0.0500),
        ] {
            let damping = modes(pressure_psf)[1].1;
            assert!((damping - expected).abs() < 0.6e-4, "{pressure_psf} psf: {damping}, expected {expected}");
        }
    }
}
