//! Content of a chart: panels over one horizontal axis, and their items.

use super::{axis::Axis, rows::Rows, style::Style};

/// Width of one chart [units of the picture].
pub const WIDTH: f64 = 380.0;

/// One or more panels stacked over one horizontal axis.
#[derive(Debug, Clone)]
pub struct Plot {
    pub(super) title: String,
    pub(super) note: String,
    pub(super) x: Axis,
    pub(super) panels: Vec<Panel>,
    /// Minimum height of title, note and legend together.
    pub(super) least_head: f64,
}

/// A vertical axis and its items.
#[derive(Debug, Clone)]
pub struct Panel {
    pub(super) y: Axis,
    pub(super) height: f64,
    pub(super) items: Vec<Item>,
}

/// Default height of a panel [units of the picture].
const PANEL_HEIGHT: f64 = 150.0;

/// One item. A label makes it an entry of the legend; equal entries are shown once.
#[derive(Debug, Clone)]
pub(super) enum Item {
    Line { style: Style, label: String, points: Vec<[f64; 2]> },
    Marks { style: Style, label: String, points: Vec<[f64; 2]> },
    ErrorBars { style: Style, points: Vec<[f64; 3]> },
    Area { style: Style, label: String, points: Vec<[f64; 3]> },
    Bars { style: Style, label: String, values: Vec<Option<f64>>, errors: Vec<Option<f64>> },
    Limit { at: f64, label: String },
    Span { from: f64, to: f64, label: String },
    Rows(Rows),
}

impl Plot {
    /// A chart without panels yet.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis) -> Self {
        Self { title: title.into(), note: String::new(), x, panels: Vec::new(), least_head: 0.0 }
    }

    /// A sentence below the title: conditions, origin of the data, values outside the axes.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// Adds a panel below the existing ones.
    #[must_use]
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// The title.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }
}

impl Panel {
    /// A panel without content yet.
    #[must_use]
    pub fn new(y: Axis) -> Self {
        Self { y, height: PANEL_HEIGHT, items: Vec::new() }
    }

    /// A panel of horizontal bars, as high as they need.
    #[must_use]
    pub fn of_rows(rows: Rows) -> Self {
        Self { y: Axis::linear("", 0.0, 1.0).ticks(&[]), height: rows.height(), items: vec![Item::Rows(rows)] }
    }

    /// A height other than the default of 150 units.
    #[must_use]
    pub fn height(mut self, height: f64) -> Self {
        self.height = height;
        self
    }

    fn with(mut self, item: Item) -> Self {
        self.items.push(item);
        self
    }

    /// A line through (x, y). A non-finite value interrupts it; parts outside the axes are clipped; a line with more points than the
    /// picture can show is thinned to the extremes of each of its columns.
    #[must_use]
    pub fn line(self, style: Style, label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        self.with(Item::Line { style, label: label.into(), points })
    }

    /// A mark at each (x, y).
    #[must_use]
    pub fn marks(self, style: Style, label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        self.with(Item::Marks { style, label: label.into(), points })
    }

    /// A vertical bar from y - e to y + e at each (x, y, e).
    #[must_use]
    pub fn error_bars(self, style: Style, points: Vec<[f64; 3]>) -> Self {
        self.with(Item::ErrorBars { style, points })
    }

    /// The area between two lines, from (x, lower, upper).
    #[must_use]
    pub fn area(self, style: Style, label: impl Into<String>, points: Vec<[f64; 3]>) -> Self {
        self.with(Item::Area { style, label: label.into(), points })
    }

    /// One bar for each category of the horizontal axis, with its value, beside the existing bars.
    #[must_use]
    pub fn bars(self, style: Style, label: impl Into<String>, values: Vec<Option<f64>>) -> Self {
        self.bars_with_errors(style, label, values, Vec::new())
    }

    /// As [`Panel::bars`], with y ± error drawn if there is one.
    #[must_use]
    pub fn bars_with_errors(
        self,
        style: Style,
        label: impl Into<String>,
        values: Vec<Option<f64>>,
        errors: Vec<Option<f64>>,
    ) -> Self {
        self.with(Item::Bars { style, label: label.into(), values, errors })
    }

    /// A horizontal line for a limit.
    #[must_use]
    pub fn limit(self, at: f64, label: impl Into<String>) -> Self {
        self.with(Item::Limit { at, label: label.into() })
    }

    /// A part of the horizontal axis, shaded.
    #[must_use]
    pub fn span(self, from: f64, to: f64, label: impl Into<String>) -> Self {
        self.with(Item::Span { from, to, label: label.into() })
    }
}
