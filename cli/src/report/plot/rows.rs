//! Horizontal bars, one row for each name: names may be as long as a picture is wide, and the number of rows is not limited.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::{
    axis::{Axis, horizontal},
    path::{Frame, put},
    style::Style,
};

/// Rows of horizontal bars from 0.
#[derive(Debug, Clone)]
pub struct Rows {
    /// Style and name of each bar of a row.
    pub series: Vec<(Style, String)>,
    /// From top to bottom.
    pub rows: Vec<Row>,
    /// A value that bars are compared with, and its name.
    pub limit: Option<(f64, String)>,
}

/// One row: a line of text with its bars below it.
#[derive(Debug, Clone)]
pub struct Row {
    /// At the left.
    pub name: String,
    /// At the right: the values in words.
    pub text: String,
    /// A bar for each series; `None` without a value.
    pub values: Vec<Option<f64>>,
}

/// Space of a line of text [units of the picture].
const TEXT: f64 = 16.0;
/// Height of a bar.
const BAR: f64 = 7.0;
/// Space between rows.
const BETWEEN: f64 = 5.0;
/// Space above the first row, for the name of the limit.
const ABOVE: f64 = 16.0;

impl Rows {
    /// Height of a panel with these rows [units of the picture].
    pub(super) fn height(&self) -> f64 {
        ABOVE + self.rows.len() as f64 * self.pitch()
    }

    fn pitch(&self) -> f64 {
        TEXT + self.series.len() as f64 * BAR + BETWEEN
    }

    /// The part enlarged by a zoom.
    pub(super) fn bars(&self, svg: &mut String, x: &Axis, frame: &Frame) {
        let zero = horizontal(x, frame, 0.0).clamp(frame.left, frame.right);
        for (index, row) in self.rows.iter().enumerate() {
            let top = frame.top + ABOVE + index as f64 * self.pitch() + TEXT;
            for (place, (value, (style, _))) in row.values.iter().zip(&self.series).enumerate() {
                let Some(value) = value.filter(|value| value.is_finite()) else { continue };
                let end = horizontal(x, frame, value).clamp(frame.left, frame.right);
                put!(
                    svg,
                    "<rect class=\"bar f{}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{BAR}\"/>\n",
                    style.colour,
                    zero.min(end),
                    top + place as f64 * BAR,
                    (end - zero).abs()
                );
            }
        }
        if let Some((at, _)) = &self.limit {
            let x = horizontal(x, frame, *at);
            if (frame.left..=frame.right).contains(&x) {
                put!(svg, "<path class=\"limit\" d=\"M{x:.1} {:.1}V{:.1}\"/>\n", frame.top, frame.bottom);
            }
        }
    }

    /// Names and values, and the name of the limit.
    pub(super) fn texts(&self, svg: &mut String, x: &Axis, frame: &Frame) {
        for (index, Row { name, text, .. }) in self.rows.iter().enumerate() {
            let y = frame.top + ABOVE + index as f64 * self.pitch() + TEXT - 4.0;
            let (name, text) = (escape(name.as_str()), escape(text.as_str()));
            put!(svg, "<text class=\"row\" x=\"{:.1}\" y=\"{y:.1}\">{name}</text>", frame.left + 4.0);
            put!(svg, "<text class=\"row\" text-anchor=\"end\" x=\"{:.1}\" y=\"{y:.1}\">{text}</text>\n", frame.right);
        }
        if let Some((at, label)) = &self.limit {
            let x = horizontal(x, frame, *at);
            // On the side with sufficient space.
            let (anchor, x) = if x > 0.5 * (frame.left + frame.right) { ("end", x - 4.0) } else { ("start", x + 4.0) };
            let (y, label) = (frame.top + 11.0, escape(label.as_str()));
            put!(svg, "<text class=\"limit\" text-anchor=\"{anchor}\" x=\"{x:.1}\" y=\"{y:.1}\">{label}</text>\n");
        }
    }
}
