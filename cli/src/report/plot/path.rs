//! Lines as path data: clipped at the frame, interrupted at non-finite values, thinned to the visible resolution.

use std::fmt::Write as _;

/// Writing to a String cannot fail.
macro_rules! put {
    ($to:expr, $($format:tt)*) => { let _ = write!($to, $($format)*); };
}

pub(super) use put;

/// Left, top, right and bottom edge of a panel [units of the picture].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Frame {
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }
}

/// Path data of a line through points in units of the picture.
pub(super) fn path(points: &[[f64; 2]], frame: &Frame) -> String {
    let mut data = String::new();
    for piece in points.split(|[x, y]| !(x.is_finite() && y.is_finite())) {
        let piece = thinned(piece, frame);
        let mut pen: Option<[f64; 2]> = None;
        for pair in piece.windows(2) {
            let Some([from, to]) = clipped([pair[0], pair[1]], frame) else {
                pen = None;
                continue;
            };
            // Writing to a String cannot fail.
            if pen != Some(from) {
                let _ = write!(data, "M{:.2} {:.2}", from[0], from[1]);
            }
            let _ = write!(data, "L{:.2} {:.2}", to[0], to[1]);
            pen = Some(to);
        }
    }
    data
}

/// The part of a segment inside the frame (Liang and Barsky 1984).
fn clipped([from, to]: [[f64; 2]; 2], frame: &Frame) -> Option<[[f64; 2]; 2]> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (towards, distance) in [
        (-dx, from[0] - frame.left),
        (dx, frame.right - from[0]),
        (-dy, from[1] - frame.top),
        (dy, frame.bottom - from[1]),
    ] {
        if towards == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if towards < 0.0 {
            first = first.max(distance / towards);
        } else {
            last = last.min(distance / towards);
        }
    }
    let at = |share: f64| if share == 1.0 { to } else { [from[0] + share * dx, from[1] + share * dy] };
    (first <= last).then(|| [at(first), at(last)])
}

/// Columns per unit of width: finer than a screen shows, as a reserve for zooming.
const COLUMNS_PER_UNIT: f64 = 8.0;

/// A long line with nondecreasing x, reduced to the first, minimum, maximum and last point of each column.
fn thinned(points: &[[f64; 2]], frame: &Frame) -> Vec<[f64; 2]> {
    let columns = (frame.right - frame.left) * COLUMNS_PER_UNIT;
    let goes_back = points.windows(2).any(|pair| pair[1][0] < pair[0][0]);
    if goes_back || (points.len() as f64) < 4.0 * columns {
        return points.to_vec();
    }
    let column = |point: &[f64; 2]| ((point[0] - frame.left) * COLUMNS_PER_UNIT).floor();
    let mut kept = Vec::new();
    for same in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &usize, b: &usize| same[*a][1].total_cmp(&same[*b][1]);
        let mut indices = vec![0, same.len() - 1];
        indices.extend((0..same.len()).min_by(by_height));
        indices.extend((0..same.len()).max_by(by_height));
        indices.sort_unstable();
        indices.dedup();
        kept.extend(indices.into_iter().map(|index| same[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame { left: 0.0, top: 0.0, right: 100.0, bottom: 50.0 };

    #[test]
    fn a_line_is_cut_at_the_frame_and_comes_back() {
        let data = path(&[[10.0, 10.0], [20.0, -10.0], [30.0, 10.0], [40.0, 10.0]], &FRAME);
        assert_eq!(data, "M10.00 10.00L15.00 0.00M25.00 0.00L30.00 10.00L40.00 10.00");
        assert_eq!(path(&[[-5.0, -5.0], [-1.0, 60.0]], &FRAME), "");
    }

    #[test]
    fn a_value_that_is_not_finite_interrupts_the_line() {
        let data = path(&[[0.0, 1.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 1.0]], &FRAME);
        assert_eq!(data, "M0.00 1.00L1.00 1.00M3.00 1.00L4.00 1.00");
    }

    #[test]
    fn a_long_line_keeps_its_extremes_and_loses_its_length() {
        let mut points: Vec<[f64; 2]> = (0..100_000).map(|index| [f64::from(index) * 1e-3, 25.0]).collect();
        points[54_321][1] = 3.0;
        let thin = thinned(&points, &FRAME);
        assert!(thin.len() < 4000 && thin.contains(&points[54_321]) && thin.last() == points.last());
    }
}
