//! Pages: one HTML file with embedded style and charts, which opens offline and is readable on phones and laptops.

use std::fmt::Write as _;

use quick_xml::escape::escape;

use super::plot::{self, Plot};

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #20262c; --soft: #55606a; --line: #d5dce2; --ground: #ffffff; --raised: #f3f6f8;
  --good: #16653f; --bad: #b3261e; --open: #5f6b76; --link: #005a9c }
@media screen and (prefers-color-scheme: dark) { :root { --ink: #e4e8eb; --soft: #a9b4be; --line: #3a444d; --ground: #14181c; --raised: #1d242a;
  --good: #5fd39b; --bad: #ff8a80; --open: #a9b4be; --link: #8ecbff } }
* { box-sizing: border-box }
body { font: 16px/1.5 system-ui, 'Segoe UI', Helvetica, Arial, sans-serif; color: var(--ink); background: var(--ground);
  max-width: 84rem; margin: 0 auto; padding: 1rem; overflow-wrap: break-word }
h1 { font-size: 1.6rem; line-height: 1.25 } h2 { font-size: 1.25rem; margin-top: 2.2rem } h3 { font-size: 1rem; margin: 1.4rem 0 .4rem }
p, li { max-width: 46rem } p.soft, span.soft, figcaption .soft { color: var(--soft); font-size: .9rem }
.scroll { overflow-x: auto; margin: 0 0 1.2rem } table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .6rem .25rem 0; text-align: left; vertical-align: top; white-space: nowrap }
th { white-space: normal; overflow-wrap: normal; vertical-align: bottom; min-width: 4rem; line-height: 1.3 }
th:first-child, td:first-child { position: sticky; left: 0; background: var(--ground) }
td.wrap { white-space: normal; min-width: 12rem } td.number, th.number { text-align: right } td.parted { white-space: normal } td.parted span { white-space: nowrap } td.bad { color: var(--bad); font-weight: 600 }
td.tone { font-weight: 600 } td.good { color: var(--good) } td.open { color: var(--open) } a { color: var(--link) }
.facts { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; margin: 1rem 0 .6rem; font-size: .9rem }
.facts dt { color: var(--soft) } .facts dd { margin: 0; min-width: 0; overflow-wrap: anywhere }
pre.command { background: var(--raised); padding: .5rem .7rem; margin: 0 0 1.2rem; border-radius: 4px; white-space: pre-wrap; overflow-wrap: anywhere }
pre.command code { background: none; padding: 0; user-select: all } .long { max-height: 15rem; overflow-y: auto }
.plots { display: flex; flex-wrap: wrap; gap: .5rem 1rem; align-items: flex-start; margin-bottom: 1rem } .plots svg, .plots figure { flex: 0 1 380px; min-width: 0 }
figure { margin: 0 0 1rem } figcaption { max-width: 380px }
ul.verdicts { list-style: none; padding: 0; columns: 2 26rem; column-gap: 2rem } ul.verdicts li { border-left: 4px solid var(--line); padding: .1rem 0 .1rem .8rem; margin: 0 0 1rem; break-inside: avoid }
.verdicts .good { border-color: var(--good) } .verdicts .bad { border-color: var(--bad) } .verdicts .open { border-color: var(--open) }
.verdict { font-weight: 600 } .good .verdict { color: var(--good) } .bad .verdict { color: var(--bad) } .open .verdict { color: var(--open) }
code { font-family: ui-monospace, monospace; font-size: .92em; background: var(--raised); padding: .05em .3em; border-radius: 4px }
.plots .chart { flex: 0 1 380px; min-width: 0 } .chart svg { display: block; touch-action: pan-y } .readout { display: block; min-height: 1.5em;
  font-size: .85rem; color: var(--soft); max-width: 380px; font-variant-numeric: tabular-nums }
button { font: inherit; color: inherit; background: none; border: 0; padding: 0; cursor: pointer } .sort { text-align: inherit; font-weight: inherit }
th[aria-sort=ascending] .sort::after { content: ' \\2191' } th[aria-sort=descending] .sort::after { content: ' \\2193' }
.copy { font-size: .85rem; color: var(--soft); text-decoration: underline; margin: -.9rem 0 1.2rem; display: block }
footer { color: var(--soft); font-size: .85rem; margin-top: 3rem; border-top: 1px solid var(--line); padding-top: .6rem }
@media print { :root { color-scheme: light; --ink: #20262c; --soft: #55606a; --line: #d5dce2; --ground: #ffffff; --raised: #f3f6f8; --good: #16653f;
  --bad: #b3261e; --open: #5f6b76; --link: #005a9c } body { max-width: none; padding: 0; font-size: 10pt } .tools, .readout { display: none } .scroll { overflow: visible; max-height: none }
  table { font-size: 8pt } th, td { white-space: normal } th:first-child, td:first-child { position: static } h2, h3 { break-after: avoid }
  tr, figure, .plots svg { break-inside: avoid } }";

/// Zoom, values under the pointer, sortable and copyable tables. Our own, since a library that draws charts from data (uPlot) would have to
/// draw them again, and a page without scripts would be without charts.
const SCRIPT: &str = include_str!("page/script.js");

/// A page under construction.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
}

/// State of a row of a list, for its colour; the text states it as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// As expected.
    Good,
    /// Not as expected.
    Bad,
    /// Not known.
    Open,
}

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Open => "open",
        }
    }

    fn cell_class(self) -> &'static str {
        match self {
            Self::Good => "tone good",
            Self::Bad => "tone bad",
            Self::Open => "tone open",
        }
    }
}

/// One cell of a table.
#[derive(Debug, Clone)]
pub struct Cell {
    text: String,
    class: &'static str,
    /// Texts with the files that they link to, after the text.
    links: Vec<(String, String)>,
}

impl Cell {
    /// Text.
    #[must_use]
    pub fn text(text: impl Into<String>) -> Self {
        Self::of_class(text, "")
    }

    /// Whether it contains more than the mark of an unknown value.
    fn says(&self) -> bool {
        !self.links.is_empty() || !matches!(self.text.as_str(), "" | "-")
    }

    fn of_class(text: impl Into<String>, class: &'static str) -> Self {
        Self { text: text.into(), class, links: Vec::new() }
    }

    /// Links to files beside the page: texts and paths.
    #[must_use]
    pub fn links(links: Vec<(String, String)>) -> Self {
        Self { links, ..Self::text("") }
    }

    /// Text that may wrap.
    #[must_use]
    pub fn long(text: impl Into<String>) -> Self {
        Self::of_class(text, "wrap")
    }

    /// A name, which wraps on a narrow screen.
    #[must_use]
    pub fn name(text: impl Into<String>) -> Self {
        Self::of_class(text, "parted")
    }

    /// A formatted number. A suffix, such as its standard error, moves to a second line on a narrow screen.
    #[must_use]
    pub fn number(text: impl Into<String>) -> Self {
        let text = text.into();
        let class = if text.contains(' ') { "number parted" } else { "number" };
        Self::of_class(text, class)
    }

    /// A verdict or the like, in the colour of its state.
    #[must_use]
    pub fn toned(text: impl Into<String>, tone: Tone) -> Self {
        Self::of_class(text, tone.cell_class())
    }

    /// A number that may exceed its limit.
    #[must_use]
    pub fn judged(text: impl Into<String>, beyond: bool) -> Self {
        Self::of_class(text, if beyond { "number bad" } else { "number" })
    }
}

impl Page {
    /// An empty page with a title.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        let title = title.into();
        let body = format!("<h1>{}</h1>\n", escape(title.as_str()));
        Self { title, body }
    }

    fn add(mut self, html: &str) -> Self {
        self.body.push_str(html);
        self
    }

    /// A heading.
    #[must_use]
    pub fn heading(self, text: &str) -> Self {
        self.add(&format!("<h2>{}</h2>\n", escape(text)))
    }

    /// A smaller heading.
    #[must_use]
    pub fn subheading(self, text: &str) -> Self {
        self.add(&format!("<h3>{}</h3>\n", escape(text)))
    }

    /// A paragraph.
    #[must_use]
    pub fn paragraph(self, text: &str) -> Self {
        self.add(&format!("<p>{}</p>\n", escape(text)))
    }

    /// A note.
    #[must_use]
    pub fn remark(self, text: &str) -> Self {
        self.add(&format!("<p class=\"soft\">{}</p>\n", escape(text)))
    }

    /// Charts, as many side by side as fit.
    #[must_use]
    pub fn plots<'a>(self, plots: impl IntoIterator<Item = &'a Plot>) -> Self {
        let drawn: String = plots.into_iter().map(Plot::inline).collect();
        self.add(&format!("<div class=\"plots\">\n{drawn}</div>\n"))
    }

    /// Charts with captions and notes: caption, note, chart.
    #[must_use]
    pub fn captioned(self, charts: &[(String, String, Plot)]) -> Self {
        self.figures(charts.iter().map(|(caption, remark, plot)| (caption.as_str(), remark.as_str(), plot)))
    }

    /// Charts with captions and notes, as many side by side as fit.
    #[must_use]
    pub fn figures<'a>(self, figures: impl IntoIterator<Item = (&'a str, &'a str, &'a Plot)>) -> Self {
        let mut html = String::from("<div class=\"plots\">\n");
        for (caption, remark, plot) in figures {
            let remark = if remark.is_empty() {
                String::new()
            } else {
                format!("<br><span class=\"soft\">{}</span>", escape(remark))
            };
            // Writing to a String cannot fail.
            let _ = writeln!(
                html,
                "<figure>{}<figcaption><b>{}</b>{remark}</figcaption></figure>",
                plot.inline(),
                escape(caption)
            );
        }
        html.push_str("</div>\n");
        self.add(&html)
    }

    /// Names with their meanings.
    #[must_use]
    pub fn facts(self, facts: &[(&str, String)]) -> Self {
        let each = facts.iter().filter(|(_, text)| !text.is_empty());
        let each: String = each
            .map(|(name, text)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(*name), escape(text.as_str())))
            .collect();
        self.add(&format!("<dl class=\"facts\">\n{each}</dl>\n"))
    }

    /// A command line that can be copied.
    #[must_use]
    pub fn command(self, line: &str) -> Self {
        self.add(&format!("<pre class=\"command\"><code>{}</code></pre>\n", escape(line)))
    }

    /// A table that scrolls separately on a narrow screen. The heads of number columns are right-aligned with the numbers.
    #[must_use]
    pub fn table(self, heads: &[&str], rows: &[Vec<Cell>]) -> Self {
        self.table_in("scroll", heads, rows)
    }

    /// As [`Page::table`], limited on screen to a number of rows that does not push away what follows; the others are reached by scrolling,
    /// and printed.
    #[must_use]
    pub fn long_table(self, heads: &[&str], rows: &[Vec<Cell>]) -> Self {
        self.table_in("scroll long", heads, rows)
    }

    /// Columns without content in any row are omitted.
    fn table_in(self, class: &str, heads: &[&str], rows: &[Vec<Cell>]) -> Self {
        let says = |column: usize| rows.iter().any(|row| row.get(column).is_some_and(Cell::says));
        let shown: Vec<usize> = (0..heads.len()).filter(|column| rows.is_empty() || says(*column)).collect();
        let mut html = format!("<div class=\"{class}\" tabindex=\"0\"><table>\n<tr>");
        // Writing to a String cannot fail.
        for column in &shown {
            let number =
                rows.first().and_then(|row| row.get(*column)).is_some_and(|cell| cell.class.starts_with("number"));
            let class = if number { " class=\"number\"" } else { "" };
            let _ = write!(html, "<th{class}>{}</th>", escape(heads[*column]));
        }
        html.push_str("</tr>\n");
        for row in rows {
            html.push_str("<tr>");
            for cell in shown.iter().filter_map(|column| row.get(*column)) {
                let class = if cell.class.is_empty() { String::new() } else { format!(" class=\"{}\"", cell.class) };
                let links = cell
                    .links
                    .iter()
                    .map(|(text, path)| format!("<a href=\"{}\">{}</a>", escape(path.as_str()), escape(text.as_str())));
                let links = links.collect::<Vec<String>>().join(" ");
                let text = match cell.text.split_once(' ') {
                    Some((value, behind)) if cell.class == "number parted" => {
                        format!("<span>{}</span> <span>{}</span>", escape(value), escape(behind))
                    }
                    _ => escape(cell.text.as_str()).into_owned(),
                };
                let _ = write!(html, "<td{class}>{text}{links}</td>");
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</table></div>\n");
        self.add(&html)
    }

    /// A list of statements, each with verdict, subject and note.
    #[must_use]
    pub fn verdicts(self, rows: &[(Tone, String, String, String, String)]) -> Self {
        let mut html = String::from("<ul class=\"verdicts\">\n");
        for (tone, verdict, claim, finding, place) in rows {
            let (class, verdict, claim) = (tone.class(), escape(verdict.as_str()), escape(claim.as_str()));
            let _ = write!(html, "<li class=\"{class}\"><span class=\"verdict\">{verdict}</span>: {claim}");
            if !finding.is_empty() {
                let _ = write!(html, "<br>{}", escape(finding.as_str()));
            }
            if !place.is_empty() {
                let _ = write!(html, "<br><span class=\"soft\">{}</span>", escape(place.as_str()));
            }
            html.push_str("</li>\n");
        }
        html.push_str("</ul>\n");
        self.add(&html)
    }

    /// The page as a file.
    #[must_use]
    pub fn html(&self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n\
             <style>{STYLE}\n{}</style>\n</head>\n<body>\n{}<footer>actuator {}</footer>\n\
             <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
            escape(self.title.as_str()),
            plot::STYLE,
            self.body,
            env!("CARGO_PKG_VERSION"),
        )
    }
}
