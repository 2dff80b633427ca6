//! Axes: from values to positions, and the ticks.

use super::path::Frame;

/// A horizontal or vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(super) label: String,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) ticks: Vec<Tick>,
    /// Exponent of the power of ten that is moved from the tick texts to the label.
    pub(super) tens: i32,
    scale: Scale,
    is_of_names: bool,
}

/// A tick: value and text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub text: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scale {
    Linear,
    Logarithmic,
}

/// Default maximum number of intervals of an axis.
const INTERVALS: f64 = 6.0;

impl Axis {
    /// From and to these values, with round ticks in between.
    #[must_use]
    pub fn linear(label: impl Into<String>, from: f64, to: f64) -> Self {
        let (from, to) = in_order(from, to);
        let step = round_step((to - from) / INTERVALS);
        let (ticks, tens) = round_ticks(from, to, step);
        Self { label: label.into(), from, to, ticks, tens, scale: Scale::Linear, is_of_names: false }
    }

    /// Covers all finite values, from tick to tick.
    #[must_use]
    pub fn around(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let (least, greatest) = extremes(values);
        let (from, to) = if least < greatest { (least, greatest) } else { (least - 0.5, greatest + 0.5) };
        let step = round_step((to - from) / INTERVALS);
        Self::linear(label, (from / step).floor() * step, (to / step).ceil() * step)
    }

    /// Logarithmic, with ticks at 1, 2 and 5 of each decade, or at the decades only if there are many. Both ends must be positive;
    /// otherwise it is one decade from 1.
    #[must_use]
    pub fn logarithmic(label: impl Into<String>, from: f64, to: f64) -> Self {
        let (from, to) = if from > 0.0 && to > 0.0 { in_order(from, to) } else { (1.0, 10.0) };
        let decades = from.log10().floor() as i32..=to.log10().ceil() as i32;
        let many = decades.end() - decades.start() > 3;
        let factors: &[f64] = if many { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let ticks = decades
            .flat_map(|decade| factors.iter().map(move |factor| factor * 10_f64.powi(decade)))
            .filter(|at| (from * 0.999_999..=to * 1.000_001).contains(at))
            .map(|at| Tick { at, text: at.to_string() })
            .collect();
        Self { label: label.into(), from, to, ticks, tens: 0, scale: Scale::Logarithmic, is_of_names: false }
    }

    /// One position for each name.
    #[must_use]
    pub fn categories(label: impl Into<String>, names: &[&str]) -> Self {
        let ticks = names.iter().zip(0_u32..).map(|(name, at)| Tick { at: f64::from(at), text: (*name).into() });
        Self {
            label: label.into(),
            from: -0.5,
            to: names.len().max(1) as f64 - 0.5,
            ticks: ticks.collect(),
            tens: 0,
            scale: Scale::Linear,
            is_of_names: true,
        }
    }

    /// With ticks at these values instead.
    #[must_use]
    pub fn ticks(mut self, at: &[f64]) -> Self {
        self.ticks = at.iter().map(|at| Tick { at: *at, text: at.to_string() }).collect();
        self.tens = 0;
        self
    }

    /// The label, with the power of ten of the ticks before the unit.
    pub(super) fn shown_label(&self) -> String {
        if self.tens == 0 {
            return self.label.clone();
        }
        let power = format!("10{}", superscript(self.tens));
        match self.label.rsplit_once(", ") {
            Some((name, unit)) => format!("{name}, {power}\u{a0}{unit}"),
            None => format!("{}, {power}", self.label),
        }
    }

    /// In the form for a page's script.
    pub(super) fn kind(&self) -> &'static str {
        match self.scale {
            Scale::Linear if self.is_of_names => "categories",
            Scale::Linear => "linear",
            Scale::Logarithmic => "log",
        }
    }

    /// Position of a value: 0 at `from`, 1 at `to`; outside beyond them.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.from) / (self.to - self.from),
            Scale::Logarithmic => (value / self.from).ln() / (self.to / self.from).ln(),
        }
    }
}

/// Position of a value along a horizontal axis [units of the picture].
pub(super) fn horizontal(axis: &Axis, frame: &Frame, value: f64) -> f64 {
    frame.left + (frame.right - frame.left) * axis.place(value)
}

/// Position of a value along a vertical axis [units of the picture].
pub(super) fn vertical(axis: &Axis, frame: &Frame, value: f64) -> f64 {
    frame.bottom - (frame.bottom - frame.top) * axis.place(value)
}

fn in_order(from: f64, to: f64) -> (f64, f64) {
    match from.partial_cmp(&to) {
        Some(std::cmp::Ordering::Less) if from.is_finite() && to.is_finite() => (from, to),
        Some(std::cmp::Ordering::Greater) if from.is_finite() && to.is_finite() => (to, from),
        _ if from.is_finite() => (from, from + 1.0),
        _ => (0.0, 1.0),
    }
}

fn extremes(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let found = finite.fold(None, |found: Option<(f64, f64)>, value| {
        Some(found.map_or((value, value), |(least, greatest)| (least.min(value), greatest.max(value))))
    });
    found.unwrap_or((0.0, 1.0))
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`.
fn round_step(least: f64) -> f64 {
    let decade = 10_f64.powf(least.abs().max(f64::MIN_POSITIVE).log10().floor());
    // One in a million for the rounding of the preceding division.
    let step = [1.0, 2.0, 5.0].into_iter().map(|factor| factor * decade).find(|step| *step * 1.000_001 >= least);
    step.unwrap_or(10.0 * decade)
}

/// Maximum number of characters of a tick between a vertical axis and its label.
const LONGEST_TICK: usize = 6;

/// Ticks, and the exponent of the power of ten omitted from their texts if they would otherwise be too long.
fn round_ticks(from: f64, to: f64, step: f64) -> (Vec<Tick>, i32) {
    let first = (from / step - 1e-6).ceil();
    let count = ((to / step + 1e-6).floor() - first).clamp(0.0, 100.0) as u32;
    let with = |tens: i32| -> Vec<Tick> {
        let decimals = (f64::from(tens) - step.log10().floor()).clamp(0.0, 12.0) as usize;
        let written = |at: f64| format!("{:.decimals$}", at / 10_f64.powi(tens)).replace('-', "\u{2212}");
        (0..=count)
            .map(|index| (first + f64::from(index)) * step)
            .map(|at| if at == 0.0 { 0.0 } else { at }) // not -0
            .map(|at| Tick { at, text: written(at) })
            .collect()
    };
    let longest = |ticks: &[Tick]| ticks.iter().map(|tick| tick.text.chars().count()).max().unwrap_or(0);
    let tens = from.abs().max(to.abs()).log10().floor() as i32;
    let (plain, short) = (with(0), with(tens));
    if longest(&plain) > LONGEST_TICK && longest(&short) < longest(&plain) { (short, tens) } else { (plain, 0) }
}

fn superscript(exponent: i32) -> String {
    let raised = |letter: char| match letter.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|tick| tick.text.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_and_inside_the_axis() {
        assert_eq!(texts(&Axis::linear("", 0.0, 1.5)), ["0.0", "0.5", "1.0", "1.5"]);
        assert_eq!(texts(&Axis::linear("", -50.0, 0.0)), ["−50", "−40", "−30", "−20", "−10", "0"]);
        assert_eq!(texts(&Axis::logarithmic("", 0.5, 12.0)), ["0.5", "1", "2", "5", "10"]);
        let around = Axis::around("", [0.013, f64::NAN, 0.181]);
        assert_eq!((around.from, around.to), (0.0, 0.2));
    }

    #[test]
    fn what_makes_ticks_too_long_stands_in_the_label() {
        let small = Axis::around("difference, deg", [-1.3e-13, 1.1e-13]);
        assert_eq!(texts(&small), ["−1.5", "−1.0", "−0.5", "0.0", "0.5", "1.0", "1.5"]);
        assert_eq!(small.shown_label(), "difference, 10⁻¹³\u{a0}deg");
        let large = Axis::linear("p", 0.0, 2e10);
        assert_eq!((texts(&large)[1], large.shown_label().as_str()), ("0.5", "p, 10¹⁰"));
        for (from, to) in [(-50.0, 100.0), (0.0, 1e5), (-0.005, 0.005), (1_000_000.0, 1_000_001.0)] {
            assert_eq!(Axis::linear("time, s", from, to).shown_label(), "time, s", "{from} to {to}");
        }
        assert_eq!(Axis::linear("x, s", 0.0, 1e-9).ticks(&[0.0]).shown_label(), "x, s");
    }

    #[test]
    fn no_values_make_an_axis_that_cannot_be_drawn() {
        for (from, to) in [(1.0, 1.0), (f64::NAN, 2.0), (2.0, f64::INFINITY), (3.0, -3.0)] {
            let axis = Axis::linear("", from, to);
            assert!(axis.from < axis.to && axis.place(axis.to) == 1.0, "{axis:?}");
        }
        assert!(Axis::around("", []).from < Axis::around("", [7.0]).to);
        assert!(Axis::logarithmic("", 0.0, 5.0).from > 0.0);
    }
}
