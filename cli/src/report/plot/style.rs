//! Colours, dashes and marks, and the style sheet for their light and dark form.

/// Appearance of one series: distinguished by colour and, without colour, by dash or mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    pub(super) colour: usize,
    pub(super) dash: Dash,
    pub(super) mark: Mark,
    pub(super) faint: bool,
}

/// Dash of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Solid.
    #[default]
    Solid,
    /// Long strokes.
    Dashed,
    /// Dots.
    Dotted,
}

/// Mark of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mark {
    /// A small dot, for many points.
    #[default]
    Dot,
    /// A ring.
    Ring,
    /// A square.
    Square,
    /// A triangle.
    Triangle,
}

/// Number of colours; a series beyond them starts again.
pub(super) const COLOURS: usize = 6;

impl Style {
    /// Colour 0 to 5: blue, vermilion, green, purple, ochre, grey.
    #[must_use]
    pub fn colour(colour: usize) -> Self {
        Self { colour: colour % COLOURS, dash: Dash::Solid, mark: Mark::Dot, faint: false }
    }

    /// With this dash.
    #[must_use]
    pub fn dash(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    /// With this mark.
    #[must_use]
    pub fn mark(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }

    /// Thinner and paler: measured data behind the fitted model.
    #[must_use]
    pub fn faint(self) -> Self {
        Self { faint: true, ..self }
    }
}

/// Style sheet of all charts; a page with charts contains it once. Plain colours in two sets rather than variables, because viewers other
/// than browsers do not support variables. The colours are distinguishable by colour-blind readers (Okabe and Ito 2008), the darker ones
/// lightened for a dark background.
pub const STYLE: &str = "
.plot { font-family: system-ui, 'Segoe UI', Helvetica, Arial, sans-serif; font-size: 11px; max-width: 100%; height: auto }
.plot text { fill: #20262c; stroke: none }
.plot .value { font-size: 10.8px } .plot .title { font-size: 13px; font-weight: 600 } .plot .soft { fill: #55606a }
.plot .paper { fill: #ffffff } .plot .grid { stroke: #e3e8ec; fill: none } .plot .frame { stroke: #8b959e; fill: none }
.plot .limit { stroke: #b3261e; stroke-dasharray: 6 3; fill: none } .plot text.limit { fill: #b3261e; stroke: #ffffff; stroke-width: 3; stroke-dasharray: none; stroke-linejoin: round; paint-order: stroke }
.plot text.row { stroke: #ffffff; stroke-width: 3; stroke-linejoin: round; paint-order: stroke }
.plot .span { fill: #7d8b99; fill-opacity: .13; stroke: none }
.plot .line { fill: none; stroke-width: 1.8; stroke-linejoin: round; stroke-linecap: round }
.plot .faint { stroke-width: 1; opacity: .55 } .plot .dashed { stroke-dasharray: 6 4 } .plot .dotted { stroke-dasharray: 1.5 3.5 }
.plot .dots { fill: none; stroke-width: 2.4; stroke-linecap: round }
.plot .ring { fill: none; stroke-width: 1.5 } .plot .area { stroke: none; fill-opacity: .18 } .plot .error { stroke-width: 1; fill: none }
.plot .bar { fill-opacity: .8 } .plot .whisker { stroke: #20262c; stroke-width: 1.2; fill: none }
.plot .c0 { stroke: #0072b2 } .plot .c1 { stroke: #d55e00 } .plot .c2 { stroke: #008f68 }
.plot .c3 { stroke: #a94f8a } .plot .c4 { stroke: #9a7400 } .plot .c5 { stroke: #5f6b76 }
.plot .f0 { fill: #0072b2 } .plot .f1 { fill: #d55e00 } .plot .f2 { fill: #008f68 }
.plot .f3 { fill: #a94f8a } .plot .f4 { fill: #9a7400 } .plot .f5 { fill: #5f6b76 }
.plot .items * { vector-effect: non-scaling-stroke } .plot .zoomed > .own { display: none }
.plot .cursor { stroke: #55606a; stroke-width: 1; fill: none; pointer-events: none } .plot .choice { fill: #0072b2; fill-opacity: .12; stroke: #0072b2 }
@media screen and (prefers-color-scheme: dark) {
.plot text { fill: #e4e8eb } .plot .soft { fill: #a9b4be }
.plot .paper { fill: #14181c } .plot .grid { stroke: #2b333a } .plot .frame { stroke: #7c8790 }
.plot .limit { stroke: #ff8a80 } .plot text.limit { fill: #ff8a80; stroke: #14181c } .plot text.row { stroke: #14181c } .plot .span { fill: #9fb0c0; fill-opacity: .16 }
.plot .whisker { stroke: #e4e8eb } .plot .cursor { stroke: #a9b4be }
.plot .c0 { stroke: #56b4e9 } .plot .c1 { stroke: #ff9a5c } .plot .c2 { stroke: #3fd0a4 }
.plot .c3 { stroke: #e79bcb } .plot .c4 { stroke: #e3c04a } .plot .c5 { stroke: #a9b4be }
.plot .f0 { fill: #56b4e9 } .plot .f1 { fill: #ff9a5c } .plot .f2 { fill: #3fd0a4 }
.plot .f3 { fill: #e79bcb } .plot .f4 { fill: #e3c04a } .plot .f5 { fill: #a9b4be }
}
";
