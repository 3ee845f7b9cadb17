//! Axes of charts, linear or logarithmic.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// How values lie along an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally long.
    #[default]
    Linear,
    /// Equal ratios are equally long; values that are not above 0 are left out.
    Log,
}

/// Greatest over least value from which a scale is logarithmic.
const WIDE: f64 = 8.0;

impl Scale {
    /// Logarithmic where all values are above 0 and the greatest is at least 8 times the least.
    pub fn fitting(values: impl IntoIterator<Item = f64>) -> Self {
        let (least, greatest) = least_and_greatest(values);
        if least > 0.0 && greatest >= WIDE * least && greatest.is_finite() { Self::Log } else { Self::Linear }
    }

    /// Whether the axis has a place for a value.
    pub(super) fn shows(self, value: f64) -> bool {
        value.is_finite() && (self == Self::Linear || value > 0.0)
    }
}

/// Infinite and crossed where there are no values.
pub(super) fn least_and_greatest(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(v), most.max(v)))
}

/// A scale over a range that is not empty, and that is above 0 where it is logarithmic.
pub(super) struct Axis {
    scale: Scale,
    range: Range<f64>,
}

impl Axis {
    /// Around the least and the greatest value; `low` and `high`: room below and above them as shares of the range.
    pub(super) fn new(scale: Scale, values: (f64, f64), low: f64, high: f64) -> Self {
        let (least, greatest) = match (scale, values) {
            (_, (least, greatest)) if least < greatest => values,
            (Scale::Linear, (value, _)) if value.is_finite() => {
                (value - 0.1 * value.abs() - 0.5, value + 0.1 * value.abs() + 0.5)
            }
            (Scale::Log, (value, _)) if value.is_finite() => (0.5 * value, 2.0 * value),
            (Scale::Linear, _) => (0.0, 1.0),
            (Scale::Log, _) => (1.0, 2.0),
        };
        let range = match scale {
            Scale::Linear => {
                let size = greatest - least;
                least - low * size..greatest + high * size
            }
            Scale::Log => {
                let ratio = greatest / least;
                least / ratio.powf(low)..greatest * ratio.powf(high)
            }
        };
        Self { scale, range }
    }

    /// What is written beside a mark: as many decimals as steps of a tenth of the range need.
    pub(super) fn text(&self, value: f64) -> String {
        let range = match self.scale {
            Scale::Linear => self.range.end - self.range.start,
            // marks of one digit
            Scale::Log => 10.0 * value,
        };
        let decimals = (1.0 - range.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.decimals$}")
    }

    /// Powers of two where all values are above one half, else 1, 2 and 5 in every power of ten; of too many every second, third and
    /// so on.
    fn log_marks(&self, most: usize) -> Vec<f64> {
        let inside = |mark: &f64| (self.range.start..=self.range.end).contains(mark);
        let marks: Vec<f64> = if self.range.start > 0.5 {
            (0..1023).map(|k| 2f64.powi(k)).filter(inside).collect()
        } else {
            (-300..300).flat_map(|k| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(k))).filter(inside).collect()
        };
        let step = marks.len().div_ceil(most.max(1)).max(1);
        marks.into_iter().step_by(step).collect()
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, pixels: (i32, i32)) -> i32 {
        let Range { start, end } = self.range;
        match self.scale {
            Scale::Linear => RangedCoordf64::from(start..end).map(value, pixels),
            Scale::Log => RangedCoordf64::from(start.ln()..end.ln()).map(&value.ln(), pixels),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match self.scale {
            Scale::Linear => RangedCoordf64::from(self.range.clone()).key_points(hint),
            Scale::Log => self.log_marks(hint.bold_points()),
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.text(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_ranges_are_logarithmic() {
        assert_eq!(Scale::fitting([8.0, 1.0, 2.0]), Scale::Log);
        for values in [&[][..], &[1.0, 7.9], &[0.0, 100.0], &[-1.0, 100.0], &[1.0, f64::INFINITY]] {
            assert_eq!(Scale::fitting(values.iter().copied()), Scale::Linear, "{values:?}");
        }
    }

    #[test]
    fn marks_of_a_logarithmic_axis() {
        let marks = |least, greatest, most| Axis::new(Scale::Log, (least, greatest), 0.0, 0.1).log_marks(most);
        assert_eq!(marks(1.0, 8.0, 9), [1.0, 2.0, 4.0, 8.0]);
        assert_eq!(marks(1.0, 8.0, 2), [1.0, 4.0]);
        assert_eq!(marks(0.02, 1.0, 9), [0.02, 0.05, 0.1, 0.2, 0.5, 1.0]);
    }

    #[test]
    fn equal_ratios_are_equally_long() {
        let axis = Axis::new(Scale::Log, (1.0, 16.0), 0.0, 0.0);
        assert_eq!([1.0, 2.0, 4.0, 8.0, 16.0].map(|v| axis.map(&v, (0, 400))), [0, 100, 200, 300, 400]);
    }

    #[test]
    fn an_axis_is_never_empty() {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        for (scale, values) in [Scale::Linear, Scale::Log].into_iter().flat_map(|s| [none, (5.0, 5.0)].map(|v| (s, v)))
        {
            let Range { start, end } = Axis::new(scale, values, 0.1, 0.1).range;
            assert!(start < end && start.is_finite() && end.is_finite(), "{scale:?}, {values:?}");
        }
        assert!(Axis::new(Scale::Linear, (1e300, 1e300), 0.0, 0.0).range.contains(&1e300));
    }

    #[test]
    fn texts_are_short() {
        let text = |scale, greatest, value| Axis::new(scale, (0.0, greatest), 0.0, 0.0).text(value);
        assert_eq!([text(Scale::Linear, 300.0, 20.0), text(Scale::Linear, 10.0, 2.5)], ["20", "2"]);
        assert_eq!(text(Scale::Linear, 0.9, 0.25), "0.25");
        let text = |value| Axis::new(Scale::Log, (0.01, 1000.0), 0.0, 0.0).text(value);
        assert_eq!([text(0.02), text(0.5), text(2.0), text(512.0)], ["0.02", "0.5", "2", "512"]);
    }
}
