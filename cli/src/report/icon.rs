//! `model.png`: magnitude responses of the 17 sets, one colour per surface, drawn to be read at 200 pixels.

use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

use actuator_fmu::{
    error::{Error, Result},
    parameters::{LoadCase, Order, Surface, table},
};
use identification::frequency::response;

const WIDTH: u32 = 400;
const HEIGHT: u32 = 300;
/// Left, top, right and bottom edge of the plot [pixels].
const PLOT: [f32; 4] = [28.0, 20.0, 384.0, 276.0];
/// Range of the horizontal axis: wide enough to show the resonances.
const LAST_HZ: f64 = 50.0;
/// Range of the vertical axis, as in the report's figures [deg/deg].
const TOP: f64 = 1.5;

/// Colours distinguishable by colour-blind readers (Okabe and Ito 2008): blue, vermilion, bluish green.
fn colour(surface: Surface) -> Color {
    match surface {
        Surface::TrailingEdge => Color::from_rgba8(0, 114, 178, 255),
        Surface::UpperSpoiler => Color::from_rgba8(213, 94, 0, 255),
        Surface::LowerSpoiler => Color::from_rgba8(0, 158, 115, 255),
    }
}

fn paint(colour: Color) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(colour);
    paint
}

fn stroke(width: f32, dash: Option<&[f32]>) -> Stroke {
    Stroke {
        width,
        line_cap: LineCap::Round,
        line_join: LineJoin::Round,
        dash: dash.and_then(|dash| tiny_skia::StrokeDash::new(dash.to_vec(), 0.0)),
        ..Stroke::default()
    }
}

#[allow(clippy::cast_possible_truncation)] // pixels
fn point(frequency_hz: f64, magnitude: f64) -> (f32, f32) {
    let [left, top, right, bottom] = PLOT;
    (left + (right - left) * (frequency_hz / LAST_HZ) as f32, bottom - (bottom - top) * (magnitude / TOP) as f32)
}

fn polyline(points: impl Iterator<Item = (f32, f32)>) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (index, (x, y)) in points.enumerate() {
        if index == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    builder.finish()
}

/// The picture as PNG.
///
/// # Errors
/// None in practice; the encoder's own.
pub fn png() -> Result<Vec<u8>> {
    let failed = || Error::new("model.png", "no canvas", "a picture that fits into memory");
    let mut canvas = Pixmap::new(WIDTH, HEIGHT).ok_or_else(failed)?;
    canvas.fill(Color::WHITE);
    // The band of the report's data, 0.5 to 12 Hz, as background.
    let ((left, top), (right, bottom)) = (point(0.5, TOP), point(12.0, 0.0));
    let band = Rect::from_ltrb(left, top, right, bottom).map(PathBuilder::from_rect).ok_or_else(failed)?;
    canvas.fill_path(
        &band,
        &paint(Color::from_rgba8(236, 240, 244, 255)),
        FillRule::Winding,
        Transform::identity(),
        None,
    );
    for magnitude in [0.5, 1.0] {
        let line = polyline([point(0.0, magnitude), point(LAST_HZ, magnitude)].into_iter()).ok_or_else(failed)?;
        canvas.stroke_path(
            &line,
            &paint(Color::from_rgba8(205, 212, 219, 255)),
            &stroke(1.5, None),
            Transform::identity(),
            None,
        );
    }
    for set in table() {
        let curve = polyline((0..=200).map(|index| {
            let frequency = LAST_HZ * f64::from(index) / 200.0;
            point(frequency, response(&set.base, Order::Third, frequency).norm())
        }))
        .ok_or_else(failed)?;
        let dash: Option<&[f32]> = (set.name.load_case == LoadCase::Loaded).then_some(&[9.0, 8.0]);
        canvas.stroke_path(&curve, &paint(colour(set.name.surface)), &stroke(3.0, dash), Transform::identity(), None);
    }
    let axes = polyline([point(0.0, TOP), point(0.0, 0.0), point(LAST_HZ, 0.0)].into_iter()).ok_or_else(failed)?;
    canvas.stroke_path(
        &axes,
        &paint(Color::from_rgba8(40, 48, 56, 255)),
        &stroke(4.0, None),
        Transform::identity(),
        None,
    );
    canvas.encode_png().map_err(|error| Error::new("model.png", error.to_string(), "a picture that PNG can hold"))
}
