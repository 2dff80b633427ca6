//! From a [`Plot`] to SVG.
//!
//! From top to bottom: title, note, legend, the panels, the label of the horizontal axis. Widths of texts are estimated, since no font is
//! available here.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::{
    axis::{Axis, horizontal, vertical},
    chart::{Item, Panel, Plot, WIDTH},
    items::{MARK_SIZE, items, line_class, mark, texts},
    path::{Frame, put},
    style::{STYLE, Style},
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
/// Mean width of a character relative to the font size, for sans-serif fonts.
const LETTER: f64 = 0.54;
/// Font sizes of the style sheet.
const TITLE_SIZE: f64 = 13.0;
const TEXT_SIZE: f64 = 11.0;
/// Space after a legend entry, sufficient for fonts with wider characters than estimated.
const LEGEND_SPACE: f64 = 22.0;
/// Width of the sample at the start of a legend entry.
const SAMPLE: f64 = 22.0;

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

/// Title, note and legend, and their lower end.
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
        open_panel(&mut svg, &plot.x, panel, &frame);
        axes(&mut svg, &plot.x, panel, &frame, index == 0);
        put!(svg, "<g clip-path=\"url(#{})\"><g class=\"items\">\n", clip_name(&frame));
        items(&mut svg, &plot.x, panel, &frame);
        svg.push_str("</g></g>\n");
        texts(&mut svg, &plot.x, panel, &frame);
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
        svg.push_str("</g>\n");
        y = frame.bottom;
    }
    (svg, (y + BELOW).ceil())
}

/// The group of a panel, with the data that a page's script needs to convert positions to values.
fn open_panel(svg: &mut String, x: &Axis, panel: &Panel, frame: &Frame) {
    let Frame { left, top, right, bottom } = frame;
    let kind = if is_of_names(panel) { "categories" } else { x.kind() };
    put!(
        svg,
        "<g class=\"panel\" data-frame=\"{left} {top} {right} {bottom}\" data-x=\"{} {} {kind}\" data-y=\"{} {} {}\" \
         data-x-label=\"{}\" data-y-label=\"{}\" data-tens=\"{} {}\">\n<clipPath id=\"{}\"><rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\"/></clipPath>\n",
        x.from,
        x.to,
        panel.y.from,
        panel.y.to,
        panel.y.kind(),
        escape(x.label.as_str()),
        escape(panel.y.label.as_str()),
        x.tens,
        panel.y.tens,
        clip_name(frame),
        right - left,
        bottom - top
    );
}

/// Panels with equal frames share one clip.
fn clip_name(frame: &Frame) -> String {
    format!("clip-{}-{}", frame.top.round(), frame.bottom.round())
}

/// Lines of at most this many characters, broken between words.
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
    for (label, style, kind) in plot.panels.iter().flat_map(|panel| &panel.items).flat_map(entries) {
        if !label.is_empty() && !shown.contains(&(label, style, kind)) {
            shown.push((label, style, kind));
        }
    }
    let mut x = WIDTH;
    for (label, style, kind) in shown {
        let width = SAMPLE + 6.0 + label.chars().count() as f64 * TEXT_SIZE * LETTER + LEGEND_SPACE;
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

/// What an item adds to the legend: text, style and kind of its sample.
fn entries(item: &Item) -> Vec<(&str, Style, &'static str)> {
    match item {
        Item::Line { style, label, .. } => vec![(label, *style, "line")],
        Item::Marks { style, label, .. } => vec![(label, *style, "mark")],
        Item::Area { style, label, .. } | Item::Bars { style, label, .. } => vec![(label, *style, "area")],
        Item::Rows(rows) => rows.series.iter().map(|(style, label)| (label.as_str(), *style, "area")).collect(),
        Item::ErrorBars { .. } | Item::Limit { .. } | Item::Span { .. } => Vec::new(),
    }
}

/// Nothing along its axis to point at or to zoom into.
fn is_of_names(panel: &Panel) -> bool {
    has_bars(panel) || panel.items.iter().any(|item| matches!(item, Item::Rows(_)))
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
                "<path class=\"grid own\" d=\"M{:.1} {:.1}V{:.1}\"/>",
                horizontal(x, frame, tick.at),
                frame.top,
                frame.bottom
            );
        }
    }
    for tick in &panel.y.ticks {
        let y = vertical(&panel.y, frame, tick.at);
        put!(svg, "<path class=\"grid own\" d=\"M{:.1} {y:.1}H{:.1}\"/>", frame.left, frame.right);
        put!(
            svg,
            "<text class=\"own\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
            frame.left - 5.0,
            y + 3.8,
            escape(tick.text.as_str())
        );
    }
    let middle = 0.5 * (frame.top + frame.bottom);
    put!(
        svg,
        "<text text-anchor=\"middle\" transform=\"rotate(-90 12 {middle:.1})\" x=\"12\" y=\"{middle:.1}\">{}</text>\n",
        escape(panel.y.shown_label())
    );
}

fn horizontal_texts(svg: &mut String, x: &Axis, frame: &Frame) {
    for tick in &x.ticks {
        put!(
            svg,
            "<text class=\"own\" text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
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
        escape(x.shown_label())
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::Mark;

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
}
