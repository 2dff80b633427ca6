//! From a [`Plot`] to SVG.
//!
//! From top to bottom: title, note, legend, the panels, the label of the horizontal axis. Widths of texts are estimated,
//! since nothing here knows a font.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::{
    Axis, Dash, Item, Mark, Panel, Plot, STYLE, Style, WIDTH,
    path::{Frame, path},
};

/// Space left of the panels, for tick texts and the label [units of the picture].
const LEFT: f64 = 52.0;
/// Space right of the panels: half of the last tick text.
const RIGHT: f64 = 14.0;
/// From one line of text to the next.
const LINE: f64 = 15.0;
/// Space between panels.
const GAP: f64 = 12.0;
/// Space under the last panel: tick texts and the label.
const BELOW: f64 = 36.0;
/// Mean width of a letter as a share of the font size, for sans-serif fonts.
const LETTER: f64 = 0.54;
/// Font sizes of the style sheet.
const TITLE_SIZE: f64 = 13.0;
const TEXT_SIZE: f64 = 11.0;
/// Half width of a mark.
const MARK_SIZE: f64 = 3.0;
/// Width of the sample that a legend entry starts with.
const SAMPLE: f64 = 22.0;

/// Writing to a String cannot fail.
macro_rules! put {
    ($to:expr, $($format:tt)*) => { let _ = write!($to, $($format)*); };
}

pub(super) fn one(plot: &Plot) -> String {
    let (body, height) = content(plot);
    element(&body, WIDTH, height, &plot.title, "")
}

pub(super) fn row(plots: &[Plot]) -> String {
    let drawn: Vec<(String, f64)> = plots.iter().map(content).collect();
    let height = drawn.iter().map(|(_, height)| *height).fold(0.0, f64::max);
    let mut body = String::new();
    for ((one, _), index) in drawn.iter().zip(0_u32..) {
        put!(body, "<g transform=\"translate({} 0)\">{one}</g>\n", f64::from(index) * WIDTH);
    }
    let titles: Vec<&str> = plots.iter().map(Plot::title).collect();
    element(&body, plots.len() as f64 * WIDTH, height, &titles.join("; "), &format!("<style>{STYLE}</style>\n"))
}

fn element(body: &str, width: f64, height: f64, title: &str, style: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" role=\"img\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n<title>{}</title>\n{style}<rect class=\"paper\" width=\"{width}\" \
         height=\"{height}\"/>\n{body}</svg>\n",
        escape(title)
    )
}

/// Title, note and legend, and where they end.
fn head(plot: &Plot) -> (String, f64) {
    let mut svg = String::new();
    let mut y = 4.0;
    for line in wrapped(&plot.title, (WIDTH - 20.0) / (TITLE_SIZE * LETTER)) {
        y += LINE;
        put!(svg, "<text class=\"title\" x=\"10\" y=\"{y}\">{}</text>\n", escape(line.as_str()));
    }
    for line in wrapped(&plot.note, (WIDTH - 20.0) / (TEXT_SIZE * LETTER)) {
        y += LINE;
        put!(svg, "<text class=\"soft\" x=\"10\" y=\"{y}\">{}</text>\n", escape(line.as_str()));
    }
    y = legend(&mut svg, plot, y) + 10.0;
    (svg, y)
}

pub(super) fn head_height(plot: &Plot) -> f64 {
    head(plot).1
}

/// The picture without its outermost element, and its height.
fn content(plot: &Plot) -> (String, f64) {
    let (mut svg, y) = head(plot);
    let mut y = y.max(plot.least_head);
    for (index, panel) in plot.panels.iter().enumerate() {
        if index > 0 {
            y += GAP;
        }
        let frame = Frame { left: LEFT, top: y, right: WIDTH - RIGHT, bottom: y + panel.height };
        let last = index + 1 == plot.panels.len();
        axes(&mut svg, &plot.x, panel, &frame, index == 0);
        items(&mut svg, &plot.x, panel, &frame);
        put!(
            svg,
            "<path class=\"frame\" d=\"M{:.1} {:.1}V{:.1}H{:.1}\"/>\n",
            frame.left,
            frame.top,
            frame.bottom,
            frame.right
        );
        if last {
            horizontal_texts(&mut svg, &plot.x, &frame);
        }
        y = frame.bottom;
    }
    (svg, (y + BELOW).ceil())
}

/// Lines of at most so many letters, broken between words.
fn wrapped(text: &str, letters: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if ((line.chars().count() + 1 + word.chars().count()) as f64) <= letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn legend(svg: &mut String, plot: &Plot, mut y: f64) -> f64 {
    let mut shown: Vec<(&str, Style, &str)> = Vec::new();
    for item in plot.panels.iter().flat_map(|panel| &panel.items) {
        let (label, style, kind) = match item {
            Item::Line { style, label, .. } => (label, style, "line"),
            Item::Marks { style, label, .. } => (label, style, "mark"),
            Item::Area { style, label, .. } | Item::Bars { style, label, .. } => (label, style, "area"),
            Item::ErrorBars { .. } | Item::Limit { .. } | Item::Span { .. } => continue,
        };
        if !label.is_empty() && !shown.iter().any(|(text, known, of)| text == label && known == style && *of == kind) {
            shown.push((label, *style, kind));
        }
    }
    let mut x = WIDTH;
    for (label, style, kind) in shown {
        let width = SAMPLE + 6.0 + label.chars().count() as f64 * TEXT_SIZE * LETTER + 14.0;
        if x + width > WIDTH {
            x = 10.0;
            y += LINE + 1.0;
        }
        let middle = y - 4.0;
        match kind {
            "line" => {
                put!(svg, "<path class=\"{}\" d=\"M{x} {middle}h{SAMPLE}\"/>", line_class(style));
            }
            "mark" => {
                [0.2, 0.5, 0.8].iter().for_each(|share| mark(svg, style, [x + share * SAMPLE, middle], MARK_SIZE))
            }
            _ => {
                put!(
                    svg,
                    "<rect class=\"bar f{}\" x=\"{}\" y=\"{}\" width=\"12\" height=\"9\"/>",
                    style.colour,
                    x + 5.0,
                    middle - 4.5
                );
            }
        }
        put!(svg, "<text x=\"{}\" y=\"{y}\">{}</text>\n", x + SAMPLE + 6.0, escape(label));
        x += width;
    }
    y
}

fn line_class(style: Style) -> String {
    let dash = match style.dash {
        Dash::Solid => "",
        Dash::Dashed => " dashed",
        Dash::Dotted => " dotted",
    };
    format!("line c{}{dash}{}", style.colour, if style.faint { " faint" } else { "" })
}

fn mark(svg: &mut String, style: Style, [x, y]: [f64; 2], size: f64) {
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

fn horizontal(axis: &Axis, frame: &Frame, value: f64) -> f64 {
    frame.left + (frame.right - frame.left) * axis.place(value)
}

fn vertical(axis: &Axis, frame: &Frame, value: f64) -> f64 {
    frame.bottom - (frame.bottom - frame.top) * axis.place(value)
}

fn has_bars(panel: &Panel) -> bool {
    panel.items.iter().any(|item| matches!(item, Item::Bars { .. }))
}

fn axes(svg: &mut String, x: &Axis, panel: &Panel, frame: &Frame, first: bool) {
    for item in &panel.items {
        if let Item::Span { from, to, label } = item {
            let left = horizontal(x, frame, *from).max(frame.left);
            let right = horizontal(x, frame, *to).min(frame.right);
            put!(
                svg,
                "<rect class=\"span\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>\n",
                frame.top,
                (right - left).max(0.0),
                frame.bottom - frame.top
            );
            if first {
                let middle = 0.5 * (left + right);
                put!(
                    svg,
                    "<text class=\"soft\" text-anchor=\"middle\" x=\"{middle:.1}\" y=\"{:.1}\">{}</text>\n",
                    frame.top + 12.0,
                    escape(label.as_str())
                );
            }
        }
    }
    if !has_bars(panel) {
        for tick in &x.ticks {
            put!(
                svg,
                "<path class=\"grid\" d=\"M{:.1} {:.1}V{:.1}\"/>",
                horizontal(x, frame, tick.at),
                frame.top,
                frame.bottom
            );
        }
    }
    for tick in &panel.y.ticks {
        let y = vertical(&panel.y, frame, tick.at);
        put!(svg, "<path class=\"grid\" d=\"M{:.1} {y:.1}H{:.1}\"/>", frame.left, frame.right);
        put!(
            svg,
            "<text text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
            frame.left - 5.0,
            y + 3.8,
            escape(tick.text.as_str())
        );
    }
    let middle = 0.5 * (frame.top + frame.bottom);
    put!(
        svg,
        "<text text-anchor=\"middle\" transform=\"rotate(-90 12 {middle:.1})\" x=\"12\" y=\"{middle:.1}\">{}</text>\n",
        escape(panel.y.label.as_str())
    );
}

fn horizontal_texts(svg: &mut String, x: &Axis, frame: &Frame) {
    for tick in &x.ticks {
        put!(
            svg,
            "<text text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            horizontal(x, frame, tick.at),
            frame.bottom + 14.0,
            escape(tick.text.as_str())
        );
    }
    put!(
        svg,
        "\n<text text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
        0.5 * (frame.left + frame.right),
        frame.bottom + 29.0,
        escape(x.label.as_str())
    );
}

fn items(svg: &mut String, x: &Axis, panel: &Panel, frame: &Frame) {
    let place = |point: [f64; 2]| [horizontal(x, frame, point[0]), vertical(&panel.y, frame, point[1])];
    let groups = panel.items.iter().filter(|item| matches!(item, Item::Bars { .. })).count();
    let mut group = 0;
    for item in &panel.items {
        match item {
            Item::Line { style, points, .. } => {
                let points: Vec<[f64; 2]> = points.iter().map(|point| place(*point)).collect();
                put!(svg, "<path class=\"{}\" d=\"{}\"/>\n", line_class(*style), path(&points, frame));
            }
            Item::Marks { style, points, .. } => {
                let inside = points.iter().map(|point| place(*point)).filter(|point| frame.contains(*point));
                if style.mark == Mark::Dot {
                    // One path for all: there may be thousands.
                    let data: String = inside.map(|[x, y]| format!("M{x:.1} {y:.1}h0")).collect();
                    put!(svg, "<path class=\"dots c{}\" d=\"{data}\"/>", style.colour);
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
            Item::Limit { at, label } => {
                let y = vertical(&panel.y, frame, *at);
                if (frame.top..=frame.bottom).contains(&y) {
                    put!(svg, "<path class=\"limit\" d=\"M{:.1} {y:.1}H{:.1}\"/>", frame.left, frame.right);
                    put!(
                        svg,
                        "<text class=\"limit\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                        frame.left + 5.0,
                        y - 4.0,
                        escape(label.as_str())
                    );
                }
            }
            Item::Span { .. } => {}
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

/// Share of a category's width that its bars fill.
const BARS: f64 = 0.84;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_drawn_is_well_formed_and_hides_no_text() {
        let mut items = Panel::new(Axis::around("<y> & \"z\"", [f64::NAN]))
            .line(Style::colour(9), "a < b & c", vec![[0.0, f64::INFINITY], [1.0, 2.0]])
            .area(Style::colour(1), "area", vec![[0.0, 0.0, 1.0], [1.0, f64::NAN, 2.0]])
            .error_bars(Style::colour(2), vec![[0.5, 0.5, 0.1]])
            .limit(0.7, "limit > 0.7")
            .span(0.2, 0.4, "band");
        for shape in [Mark::Dot, Mark::Ring, Mark::Square, Mark::Triangle] {
            items = items.marks(Style::colour(3).mark(shape), "marks", vec![[0.5, 0.5], [9.0, 9.0]]);
        }
        let bars = Panel::new(Axis::linear("bars", 0.0, 2.0)).height(80.0).bars_with_errors(
            Style::colour(0),
            "x",
            vec![Some(1.0), None],
            vec![Some(0.2)],
        );
        let plot = Plot::new("Title & <more>", Axis::categories("", &["one", "two"]))
            .note("a note that is long enough to need more than one line of text, if it is made of sufficiently many words")
            .panel(items)
            .panel(bars);
        for svg in [plot.svg(), plot.inline(), row(&[plot.clone(), plot.clone()])] {
            let mut reader = quick_xml::Reader::from_str(&svg);
            reader.config_mut().check_end_names = true;
            loop {
                match reader.read_event().unwrap() {
                    quick_xml::events::Event::Eof => break,
                    quick_xml::events::Event::Start(element) | quick_xml::events::Event::Empty(element) => {
                        assert!(element.attributes().all(|attribute| attribute.is_ok()));
                    }
                    _ => {}
                }
            }
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            for text in ["a &lt; b &amp; c", "Title &amp; &lt;more&gt;", "limit &gt; 0.7", ">band<", ">N/A<"] {
                assert!(svg.contains(text), "{text}");
            }
        }
    }

    #[test]
    fn a_value_at_a_bar_has_four_digits_as_in_the_tables() {
        assert_eq!([165.26, 0.5624, 1.0198, 10000.0].map(four_digits), ["165.3", "0.562", "1.020", "10000"]);
    }
}
