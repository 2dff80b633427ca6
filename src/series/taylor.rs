//! A signal over one segment: Taylor coefficients and decays.

/// Number of coefficients.
pub const TERMS: usize = 20;

/// Accuracy of series, which limits the length of segments.
#[derive(Debug)]
pub struct Accuracy {
    /// Maximum product of the largest pole represented by Taylor series and the segment length.
    pub longest: f64,
    /// Relative size of the first omitted coefficient, and of the last ones of a series whose convergence is not known.
    pub negligible: f64,
    /// By n, the pole × length above which n coefficients are too few.
    too_long_for: [f64; TERMS],
}

impl Accuracy {
    /// Truncation 1.2^20 / 20! = 2e-17 of the signal, below rounding.
    pub const EXACT: Self = Self::new(1.2, f64::EPSILON / 2.0);
    /// Truncation 3^20 / 20! = 1.4e-9 for motion as fast as the largest pole: for the many simulations of a search.
    pub const APPROXIMATE: Self = Self::new(3.0, 2e-9);

    const fn new(longest: f64, negligible: f64) -> Self {
        Self { longest, negligible, too_long_for: too_long_for(longest, negligible) }
    }

    /// Smallest n, at least 4, with (pole × length)^n / n! negligible: the number of coefficients needed.
    #[must_use]
    pub fn terms_needed(&self, pole_length: f64) -> usize {
        let too_few = self.too_long_for[FEWEST_TERMS..].iter().map(|limit| usize::from(pole_length > *limit));
        FEWEST_TERMS + too_few.sum::<usize>()
    }
}

/// a e^{-k τ}
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Decay {
    /// Value at τ = 0.
    pub amplitude: f64,
    /// Rate times segment length.
    pub exponent: f64,
}

/// Beyond this exponent a decay is zero: e^-45 = 3e-20 of its amplitude, below rounding.
const NEGLIGIBLE_EXPONENT: f64 = 45.0;

impl Decay {
    /// d/dτ
    pub(super) fn derivative(self) -> Self {
        Self { amplitude: -self.amplitude * self.exponent, exponent: self.exponent }
    }

    pub(super) fn at(&self, tau: f64) -> f64 {
        let exponent = self.exponent * tau;
        if self.amplitude == 0.0 || exponent > NEGLIGIBLE_EXPONENT { 0.0 } else { self.amplitude * (-exponent).exp() }
    }
}

/// A signal over one segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series {
    /// Taylor coefficients in τ.
    pub terms: [f64; TERMS],
    /// Number of leading coefficients that may differ from zero.
    pub length: usize,
    /// Decays of the pole p and of the sensor lag.
    pub decays: [Decay; 2],
}

impl Series {
    /// c_0 + c_1 τ + ...
    #[must_use]
    pub fn polynomial(coefficients: &[f64]) -> Self {
        let mut terms = [0.0; TERMS];
        terms[..coefficients.len()].copy_from_slice(coefficients);
        Self { terms, length: coefficients.len(), decays: [Decay::default(); 2] }
    }

    /// Value at τ = 0.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.terms[0] + self.decays[0].amplitude + self.decays[1].amplitude
    }

    /// Value at τ.
    #[must_use]
    pub fn at(&self, tau: f64) -> f64 {
        // At the end of a segment, the most frequent case, all powers are 1 and the terms can be summed without products.
        let sum = if tau == 1.0 && self.length > LANES { sum(&self.terms) } else { self.polynomial_at(tau).0 };
        sum + self.decays[0].at(tau) + self.decays[1].at(tau)
    }

    /// Value and d/dτ at τ.
    #[must_use]
    #[inline]
    pub fn with_slope_at(&self, tau: f64) -> (f64, f64) {
        let (mut value, mut slope) = self.polynomial_at(tau);
        for decay in self.decays.iter().filter(|decay| decay.amplitude != 0.0) {
            let rest = decay.at(tau);
            value += rest;
            slope -= decay.exponent * rest;
        }
        (value, slope)
    }

    /// Polynomial part and its d/dτ at τ, as four polynomials in τ⁴, by Horner's scheme for value and derivative:
    ///
    /// ```text
    /// Q = Σ τ^l V_l(τ⁴),    Q' = Σ l τ^(l-1) V_l + 4 τ³ Σ τ^l V_l'(τ⁴)
    /// ```
    #[must_use]
    #[inline]
    pub(super) fn polynomial_at(&self, tau: f64) -> (f64, f64) {
        let squared = tau * tau;
        if self.length <= LANES {
            let [c0, c1, c2, c3] = [self.terms[0], self.terms[1], self.terms[2], self.terms[3]];
            let value = (c0 + tau * c1) + squared * (c2 + tau * c3);
            return (value, (c1 + 2.0 * tau * c2) + 3.0 * squared * c3);
        }
        let fourth = squared * squared;
        let mut values: [f64; LANES] = std::array::from_fn(|lane| self.terms[TERMS - LANES + lane]);
        let mut slopes = [0.0; LANES];
        // Over all coefficients, zeros among them: a loop of known length has no mispredicted branches.
        for chunk in (0..TERMS / LANES - 1).rev() {
            for lane in 0..LANES {
                slopes[lane] = slopes[lane] * fourth + values[lane];
                values[lane] = values[lane] * fourth + self.terms[LANES * chunk + lane];
            }
        }
        let value = (values[0] + tau * values[1]) + squared * (values[2] + tau * values[3]);
        let inner = (slopes[0] + tau * slopes[1]) + squared * (slopes[2] + tau * slopes[3]);
        let slope = (values[1] + 2.0 * tau * values[2]) + squared * (3.0 * values[3] + 4.0 * tau * inner);
        (value, slope)
    }

    /// d/dτ at τ = 0.
    #[must_use]
    pub fn slope_at_start(&self) -> f64 {
        self.terms[1] - self.decays.iter().map(|decay| decay.amplitude * decay.exponent).sum::<f64>()
    }

    /// d/dτ
    #[must_use]
    pub fn derivative(&self) -> Self {
        let mut terms = [0.0; TERMS];
        for n in 1..TERMS {
            terms[n - 1] = NUMBER[n] * self.terms[n];
        }
        Self { terms, length: self.length.max(2) - 1, decays: self.decays.map(Decay::derivative) }
    }

    /// d/dτ at τ.
    #[must_use]
    pub fn slope_at(&self, tau: f64) -> f64 {
        self.with_slope_at(tau).1
    }

    /// self + constant
    #[must_use]
    pub fn shifted(mut self, constant: f64) -> Self {
        self.terms[0] += constant;
        self
    }

    /// self × factor
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.terms.iter_mut().for_each(|term| *term *= factor);
        self.decays.iter_mut().for_each(|decay| decay.amplitude *= factor);
        self
    }

    /// self + factor × other; the decays of both have the same rates.
    #[must_use]
    pub fn plus(mut self, factor: f64, other: &Self) -> Self {
        self.length = self.length.max(other.length);
        for (term, more) in self.terms.iter_mut().zip(&other.terms) {
            *term += factor * more;
        }
        for (decay, more) in self.decays.iter_mut().zip(&other.decays) {
            if more.amplitude != 0.0 {
                *decay = Decay { amplitude: decay.amplitude + factor * more.amplitude, exponent: more.exponent };
            }
        }
        self
    }

    /// Bounds of all values for τ in [0, 1].
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        let (sum, magnitude) = self.signed_and_absolute_sum(&[1.0; TERMS]);
        let first = self.terms[0];
        let middle = 0.5 * (sum + first);
        let half = 0.5 * (magnitude - first.abs());
        let rises = self.decays.map(|decay| decay.amplitude.max(0.0));
        let falls = self.decays.map(|decay| decay.amplitude.min(0.0));
        (middle - half + falls[0] + falls[1], middle + half + rises[0] + rises[1])
    }

    /// Σ w_n c_n and Σ |w_n c_n|.
    pub(super) fn signed_and_absolute_sum(&self, weights: &[f64; TERMS]) -> (f64, f64) {
        let (mut sums, mut magnitudes) = ([0.0; LANES], [0.0; LANES]);
        // The first few, or all of them, zeros among them: loops of known length.
        for chunk in 0..if self.length <= LANES { 1 } else { TERMS / LANES } {
            for lane in 0..LANES {
                let term = weights[LANES * chunk + lane] * self.terms[LANES * chunk + lane];
                sums[lane] += term;
                magnitudes[lane] += term.abs();
            }
        }
        (total(sums), total(magnitudes))
    }
}

/// Number of coefficients processed in parallel (SIMD).
const LANES: usize = 4;

const _: () = assert!(TERMS.is_multiple_of(LANES));

fn sum(terms: &[f64; TERMS]) -> f64 {
    let mut sums = [0.0; LANES];
    for n in 0..TERMS {
        sums[n % LANES] += terms[n];
    }
    total(sums)
}

fn total(lanes: [f64; LANES]) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// n, for derivatives.
pub(super) const NUMBER: [f64; TERMS] = {
    let mut table = [0.0; TERMS];
    let mut n = 0;
    while n < TERMS {
        table[n] = n as f64;
        n += 1;
    }
    table
};

/// n (n - 1), for second derivatives.
pub(super) const BEND: [f64; TERMS] = {
    let mut table = [0.0; TERMS];
    let mut n = 1;
    while n < TERMS {
        table[n] = NUMBER[n] * NUMBER[n - 1];
        n += 1;
    }
    table
};

/// n (n - 1) (n - 2) from n = 4 on, for the part of a third derivative beyond its start value.
pub(super) const TURN: [f64; TERMS] = {
    let mut table = [0.0; TERMS];
    let mut n = 4;
    while n < TERMS {
        table[n] = BEND[n] * NUMBER[n - 2];
        n += 1;
    }
    table
};

/// 1 from n = 3 on, for the part of a series beyond its parabola.
pub(super) const BEYOND_PARABOLA: [f64; TERMS] = {
    let mut table = [1.0; TERMS];
    (table[0], table[1], table[2]) = (0.0, 0.0, 0.0);
    table
};

/// n from n = 4 on, for the part of a derivative beyond its parabola.
pub(super) const BEYOND_PARABOLA_OF_DERIVATIVE: [f64; TERMS] = {
    let mut table = NUMBER;
    (table[1], table[2], table[3]) = (0.0, 0.0, 0.0);
    table
};

/// 1 / n, for recurrences, where divisions would dominate the cost.
pub const RECIPROCAL: [f64; TERMS + 1] = {
    let mut table = [0.0; TERMS + 1];
    let mut n = 1;
    while n <= TERMS {
        table[n] = 1.0 / n as f64;
        n += 1;
    }
    table
};

/// n!, from coefficients to derivatives.
pub const FACTORIAL: [f64; TERMS] = factorials(false);

/// 1 / n!, from derivatives to coefficients.
pub const INVERSE_FACTORIAL: [f64; TERMS] = factorials(true);

const fn factorials(inverse: bool) -> [f64; TERMS] {
    let (mut table, mut product, mut n) = ([1.0; TERMS], 1.0, 1);
    while n < TERMS {
        product *= n as f64;
        table[n] = if inverse { 1.0 / product } else { product };
        n += 1;
    }
    table
}

/// Minimum number of coefficients; the lowest ones are products of two polynomials.
const FEWEST_TERMS: usize = 4;

/// x^n / n!
const fn term(x: f64, n: usize) -> f64 {
    let (mut term, mut factor) = (1.0, 1);
    while factor <= n {
        term *= x * RECIPROCAL[factor];
        factor += 1;
    }
    term
}

/// By n, the pole × length up to `longest` above which n coefficients are too few, found by bisection.
const fn too_long_for(longest: f64, negligible: f64) -> [f64; TERMS] {
    let mut table = [0.0; TERMS];
    let mut n = FEWEST_TERMS;
    while n < TERMS {
        let (mut few, mut many) = (0.0, longest);
        let mut halvings = 0;
        while halvings < 60 {
            let middle = 0.5 * (few + many);
            if term(middle, n) < negligible {
                few = middle;
            } else {
                many = middle;
            }
            halvings += 1;
        }
        table[n] = few;
        n += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivative_and_sums_are_those_of_calculus() {
        let mut series = Series::polynomial(&[1.0, 2.0, 3.0]);
        series.decays[0] = Decay { amplitude: 0.5, exponent: 7.0 };
        let derivative = series.derivative();
        for tau in [0.0_f64, 0.3, 1.0] {
            let expected = 2.0 + 6.0 * tau - 3.5 * (-7.0_f64 * tau).exp();
            assert!((derivative.at(tau) - expected).abs() < 1e-14);
            let sum = series.plus(-2.0, &series.scaled(0.5));
            assert!(sum.at(tau).abs() < 1e-14);
        }
    }

    #[test]
    fn the_first_coefficient_left_out_is_negligible_and_the_one_before_it_is_not() {
        for accuracy in [Accuracy::EXACT, Accuracy::APPROXIMATE] {
            let negligible = accuracy.negligible;
            for step in 0..=10_000 {
                let pole_length = 1e-4 * f64::from(step) * accuracy.longest;
                let count = accuracy.terms_needed(pole_length);
                assert!(count == TERMS || term(pole_length, count) < negligible, "{pole_length}: {count}");
                assert!(count == FEWEST_TERMS || term(pole_length, count - 1) >= negligible, "{pole_length}: {count}");
            }
            assert!(term(accuracy.longest, TERMS) < negligible);
            assert_eq!(accuracy.terms_needed(2.0 * accuracy.longest), TERMS);
        }
    }
}
