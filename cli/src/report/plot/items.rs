//! Items of a panel: lines, marks, error bars, areas, bars, limits.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::{
    axis::{Axis, horizontal, vertical},
    chart::{Item, Panel},
    path::{Frame, path, put},
    style::{Dash, Mark, Style},
};

/// Half width of a mark.
pub(super) const MARK_SIZE: f64 = 3.0;

pub(super) fn items(svg: &mut String, x: &Axis, panel: &Panel, frame: &Frame) {
    let place = |point: [f64; 2]| [horizontal(x, frame, point[0]), vertical(&panel.y, frame, point[1])];
    let groups = panel.items.iter().filter(|item| matches!(item, Item::Bars { .. })).count();
    let mut group = 0;
    for item in &panel.items {
        match item {
            Item::Line { style, points, label } => {
                let points: Vec<[f64; 2]> = points.iter().map(|point| place(*point)).collect();
                let (class, name) = (line_class(*style), escape(label.as_str()));
                put!(svg, "<path class=\"{class}\" data-name=\"{name}\" d=\"{}\"/>\n", path(&points, frame));
            }
            Item::Marks { style, points, label } => {
                let inside = points.iter().map(|point| place(*point)).filter(|point| frame.contains(*point));
                if style.mark == Mark::Dot {
                    // One path for all: there may be thousands.
                    let data: String = inside.map(|[x, y]| format!("M{x:.1} {y:.1}h0")).collect();
                    let name = escape(label.as_str());
                    put!(svg, "<path class=\"dots c{}\" data-name=\"{name}\" d=\"{data}\"/>", style.colour);
                } else {
                    inside.for_each(|point| mark(svg, *style, point, MARK_SIZE));
                }
                svg.push('\n');
            }
            Item::ErrorBars { style, points } => {
                for [at, value, error] in points {
                    let ends = [place([*at, value - error]), place([*at, value + error])];
                    put!(svg, "<path class=\"error c{}\" d=\"{}\"/>", style.colour, path(&ends, frame));
                }
                svg.push('\n');
            }
            Item::Area { style, points, .. } => area(svg, *style, points, &place, frame),
            Item::Bars { style, values, errors, .. } => {
                bars(svg, *style, values, errors, (group, groups), &place, frame);
                group += 1;
            }
            Item::Limit { at, .. } => {
                let y = vertical(&panel.y, frame, *at);
                if (frame.top..=frame.bottom).contains(&y) {
                    put!(svg, "<path class=\"limit\" d=\"M{:.1} {y:.1}H{:.1}\"/>\n", frame.left, frame.right);
                }
            }
            Item::Rows(rows) => rows.bars(svg, x, frame),
            Item::Span { .. } => {}
        }
    }
}

/// Texts in a panel: names of limits and of rows. They are not enlarged by a zoom.
pub(super) fn texts(svg: &mut String, x: &Axis, panel: &Panel, frame: &Frame) {
    for item in &panel.items {
        if let Item::Rows(rows) = item {
            rows.texts(svg, x, frame);
        }
        let Item::Limit { at, label } = item else { continue };
        let y = vertical(&panel.y, frame, *at);
        if !label.is_empty() && (frame.top..=frame.bottom).contains(&y) {
            let (x, y, label) = (frame.left + 5.0, y - 4.0, escape(label.as_str()));
            put!(svg, "<text class=\"limit own\" x=\"{x:.1}\" y=\"{y:.1}\">{label}</text>\n");
        }
    }
}

fn area(svg: &mut String, style: Style, points: &[[f64; 3]], place: &impl Fn([f64; 2]) -> [f64; 2], frame: &Frame) {
    let inside = |[x, y]: [f64; 2]| [x.clamp(frame.left, frame.right), y.clamp(frame.top, frame.bottom)];
    let finite = points.iter().filter(|point| point.iter().all(|value| value.is_finite()));
    let lower = finite.clone().map(|[x, lower, _]| inside(place([*x, *lower])));
    let upper = finite.map(|[x, _, upper]| inside(place([*x, *upper])));
    let outline: Vec<String> = lower.chain(upper.rev()).map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
    if !outline.is_empty() {
        put!(svg, "<path class=\"area f{}\" d=\"M{}Z\"/>\n", style.colour, outline.join("L"));
    }
}

/// Fraction of a category's width filled by its bars.
const BARS: f64 = 0.9;

fn bars(
    svg: &mut String,
    style: Style,
    values: &[Option<f64>],
    errors: &[Option<f64>],
    (group, groups): (usize, usize),
    place: &impl Fn([f64; 2]) -> [f64; 2],
    frame: &Frame,
) {
    let share = BARS / groups as f64;
    for (index, value) in values.iter().enumerate() {
        let from = index as f64 - 0.5 * BARS + group as f64 * share;
        let [left, zero] = place([from, 0.0]);
        let Some(value) = value else {
            let [middle, _] = place([from + 0.5 * share, 0.0]);
            put!(
                svg,
                "<text class=\"soft\" text-anchor=\"middle\" x=\"{middle:.1}\" y=\"{:.1}\">N/A</text>",
                frame.bottom - 5.0
            );
            continue;
        };
        let [right, y] = place([from + 0.94 * share, *value]);
        let (zero, y) = (zero.clamp(frame.top, frame.bottom), y.clamp(frame.top, frame.bottom));
        let middle = 0.5 * (left + right);
        put!(
            svg,
            "<rect class=\"bar f{}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            style.colour,
            y.min(zero),
            right - left,
            (y - zero).abs()
        );
        let mut top = y;
        if let Some(error) = errors.get(index).copied().flatten() {
            let ends = [place([from, value - error]), place([from, value + error])].map(|[_, y]| [middle, y]);
            put!(svg, "<path class=\"whisker\" d=\"{}\"/>", path(&ends, frame));
            top = top.min(ends[1][1]).max(frame.top);
        }
        put!(
            svg,
            "<text class=\"value\" text-anchor=\"middle\" x=\"{middle:.1}\" y=\"{:.1}\">{}</text>\n",
            (top - 4.0).max(frame.top + 9.0),
            four_digits(*value)
        );
    }
}

fn four_digits(value: f64) -> String {
    let before_point = value.abs().max(1.0).log10().floor();
    let decimals = (3.0 - before_point).clamp(0.0, 3.0) as usize;
    format!("{value:.decimals$}")
}

pub(super) fn line_class(style: Style) -> String {
    let dash = match style.dash {
        Dash::Solid => "",
        Dash::Dashed => " dashed",
        Dash::Dotted => " dotted",
    };
    format!("line c{}{dash}{}", style.colour, if style.faint { " faint" } else { "" })
}

pub(super) fn mark(svg: &mut String, style: Style, [x, y]: [f64; 2], size: f64) {
    let colour = style.colour;
    match style.mark {
        Mark::Dot => {
            put!(svg, "<path class=\"dots c{colour}\" d=\"M{x:.1} {y:.1}h0\"/>");
        }
        Mark::Ring => {
            put!(svg, "<circle class=\"ring c{colour}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{size}\"/>");
        }
        Mark::Square => {
            let (left, top, side) = (x - size, y - size, 2.0 * size);
            put!(svg, "<rect class=\"f{colour}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{side}\" height=\"{side}\"/>");
        }
        Mark::Triangle => {
            let (left, bottom, side) = (x - size, y + size, 2.0 * size);
            put!(svg, "<path class=\"f{colour}\" d=\"M{left:.1} {bottom:.1}h{side}L{x:.1} {:.1}Z\"/>", y - 1.2 * size);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_at_a_bar_has_four_digits_as_in_the_tables() {
        assert_eq!([165.26, 0.5624, 1.0198, 10000.0].map(four_digits), ["165.3", "0.562", "1.020", "10000"]);
    }
}
