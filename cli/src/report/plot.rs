//! Charts as SVG: lines, markers, error bars, bands and bars over shared axes.
//!
//! ```
//! use cli::report::plot::{Axis, Panel, Plot, Style};
//! let gain = Panel::new(Axis::linear("magnitude, deg/deg", 0.0, 1.5)).line(Style::colour(0), "early", vec![[0.5, 1.0], [12.0, 1.1]]);
//! let svg = Plot::new("Trailing edge", Axis::linear("frequency, Hz", 0.5, 12.0)).panel(gain).svg();
//! ```
//!
//! Why not a charting crate: the maintained ones (plotters, charts-rs) write colours into every element, so that a picture cannot follow a
//! reader's dark mode, and size text in pixels of a fixed canvas; the others draw with scripts. The requirements here are small: axes,
//! lines, markers, bars, in classes that one style sheet colours twice.
//!
//! A chart is [`WIDTH`] units wide, the width of a phone: there its text is as large as that of the page. Wider screens put several side by
//! side. It contains no script, no font and no link.

mod axis;
mod chart;
mod draw;
mod items;
mod path;
mod rows;
mod style;

pub use axis::Axis;
pub use chart::{Panel, Plot, WIDTH};
pub use rows::{Row, Rows};
pub use style::{Dash, Mark, STYLE, Style};

impl Plot {
    /// A standalone picture with its style sheet.
    #[must_use]
    pub fn svg(&self) -> String {
        row(std::slice::from_ref(self))
    }

    /// The picture for a page that contains [`STYLE`] once.
    #[must_use]
    pub fn inline(&self) -> String {
        draw::one(self)
    }
}

/// Gives charts heads of one height, so that their panels align side by side.
#[must_use]
pub fn aligned(mut plots: Vec<Plot>) -> Vec<Plot> {
    let highest = plots.iter().map(draw::head_height).fold(0.0, f64::max);
    plots.iter_mut().for_each(|plot| plot.least_head = highest);
    plots
}

/// Several charts side by side as one standalone picture.
#[must_use]
pub fn row(plots: &[Plot]) -> String {
    draw::row(plots)
}
