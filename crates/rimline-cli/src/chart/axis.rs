//! Axes: which numbers they show, and where the ticks are. plotters turns numbers into places.

use std::ops::Range;

use plotters::coord::combinators::{IntoLogRange, LogCoord};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

use super::text_width::{SMALL, text_width};

/// How numbers become places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    Log,
}

/// An axis over a range of numbers.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) title: String,
    pub(crate) scale: Scale,
    /// How a tick is written.
    pub(crate) format: fn(f64) -> String,
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis on which all of `values` have room; those that cannot be shown (not finite, or not above zero where the
    /// scale is logarithmic) count for nothing.
    pub(crate) fn over(
        title: impl Into<String>,
        scale: Scale,
        format: fn(f64) -> String,
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        let shown = values.into_iter().filter(|value| value.is_finite() && (scale == Scale::Linear || *value > 0.0));
        let (low, high) =
            shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = match scale {
            _ if low > high => (1.0, 10.0),
            // A tenth of the span, in equal factors, on either side.
            Scale::Log => {
                let margin = (high / low).max(2.0).powf(0.05);
                (low / margin, high * margin)
            }
            Scale::Linear => (low.min(0.0), if high > low.min(0.0) { high * 1.05 } else { 1.0 }),
        };
        Self { title: title.into(), scale, format, low, high }
    }

    /// The same, with a number shown that may lie outside.
    pub(crate) fn including(mut self, value: f64) -> Self {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
        self
    }

    /// The coordinate along a horizontal side of so many pixels: as many ticks as there is room for.
    pub(super) fn across(&self, length: i32) -> Coordinate {
        self.coordinate(length, |tick| text_width(&(self.format)(tick), SMALL) + 24)
    }

    /// The same for an upright side.
    pub(super) fn upright(&self, length: i32) -> Coordinate {
        self.coordinate(length, |_| 56)
    }

    fn coordinate(&self, length: i32, room: impl Fn(f64) -> i32) -> Coordinate {
        let bare = Coordinate { axis: self.clone(), ticks: Vec::new() };
        let fit = |ticks: &Vec<f64>| {
            ticks.windows(2).all(|pair| {
                let between = bare.map(&pair[1], (0, length)) - bare.map(&pair[0], (0, length));
                between >= i32::midpoint(room(pair[0]), room(pair[1]))
            })
        };
        let ticks = (1..=10).rev().map(|most| self.ticks(most)).find(fit).unwrap_or_default();
        Coordinate { ticks, ..bare }
    }

    /// Round numbers in the range, lowest first, at most about `most`.
    pub(crate) fn ticks(&self, most: usize) -> Vec<f64> {
        let all = match self.scale {
            Scale::Linear => self.linear_ticks(most),
            Scale::Log => self.log_ticks(most),
        };
        all.into_iter().filter(|tick| (self.low..=self.high).contains(tick)).collect()
    }

    fn linear_ticks(&self, most: usize) -> Vec<f64> {
        let rough = (self.high - self.low) / most.max(1) as f64;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let first = (self.low / step).ceil() as i64;
        (first..first + 2 * most as i64).map(|n| n as f64 * step).collect()
    }

    fn log_ticks(&self, most: usize) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let decades = (last - first) as usize + 1;
        let within = |tick: &f64| (self.low..=self.high).contains(tick);
        let finer: [&[f64]; 4] = [
            &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
            &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
            &[1.0, 2.0, 5.0],
            &[1.0, 3.0],
        ];
        for steps in finer {
            let ticks: Vec<f64> = (first..=last)
                .flat_map(|power| steps.iter().map(move |m| m * 10_f64.powi(power)))
                .filter(within)
                .collect();
            if ticks.len() <= most {
                return ticks;
            }
        }
        let stride = decades.div_ceil(most.max(1)).max(1);
        (first..=last).step_by(stride).map(|power| 10_f64.powi(power)).collect()
    }
}

/// plotters' coordinate of an axis, with its ticks. plotters' own ticks of a logarithm are whole decades, too few for the
/// spans of these plots.
#[derive(Clone, Debug)]
pub(super) struct Coordinate {
    axis: Axis,
    ticks: Vec<f64>,
}

impl Coordinate {
    /// Rows of a list, the first one at the top, without ticks.
    pub(super) fn rows(length: i32) -> Self {
        let axis = Axis {
            title: String::new(),
            scale: Scale::Linear,
            format: |_| String::new(),
            low: f64::from(length),
            high: 0.0,
        };
        Self { axis, ticks: Vec::new() }
    }
}

impl Ranged for Coordinate {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    /// Numbers outside are taken as the end, and what is no number as the low one.
    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let Axis { scale, low, high, .. } = self.axis;
        let value = if value.is_nan() { low } else { value.clamp(low.min(high), low.max(high)) };
        match scale {
            Scale::Linear => RangedCoordf64::from(low..high).map(&value, limit),
            Scale::Log => LogCoord::from((low..high).log_scale()).map(&value, limit),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.axis.low..self.axis.high
    }
}

impl ValueFormatter<f64> for Coordinate {
    fn format_ext(&self, value: &f64) -> String {
        (self.axis.format)(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(scale: Scale, values: &[f64]) -> Axis {
        Axis::over("", scale, |value| value.to_string(), values.iter().copied())
    }

    #[test]
    fn places_keep_the_order_and_stay_inside() {
        for scale in [Scale::Linear, Scale::Log] {
            let axis = axis(scale, &[0.001, 5.0, 70.0]);
            let coordinate = axis.across(1000);
            let place = |value: f64| coordinate.map(&value, (0, 1000));
            assert!(place(0.001) < place(5.0) && place(5.0) < place(70.0));
            for value in [f64::NAN, -1.0, 0.0, 1e9, f64::INFINITY] {
                assert!((0..=1000).contains(&place(value)), "{value}");
            }
        }
    }

    #[test]
    fn ticks_have_room_for_their_names() {
        let axis = Axis::over("", Scale::Log, |value| format!("{value} nanoseconds"), [0.8, 3.0, 900.0]);
        for length in [40, 200, 700, 1900] {
            let coordinate = axis.across(length);
            let ends = coordinate.ticks.iter().map(|tick| {
                let half = text_width(&(axis.format)(*tick), SMALL) / 2;
                let place = coordinate.map(tick, (0, length));
                [place - half, place + half]
            });
            let ends: Vec<[i32; 2]> = ends.collect();
            assert!(ends.windows(2).all(|pair| pair[0][1] < pair[1][0]), "{length}: {ends:?}");
            assert_eq!(ends.len() > 1, length > 40 + 160, "{length}: {ends:?}");
        }
    }

    #[test]
    fn ticks_are_round_few_and_in_range() {
        for values in [[0.001, 1e6].as_slice(), &[1.0, 1.3], &[3.0], &[], &[f64::NAN, 0.0]] {
            for scale in [Scale::Linear, Scale::Log] {
                let ticks = axis(scale, values).ticks(8);
                assert!(ticks.len() <= 16, "{values:?}: {ticks:?}");
                assert!(ticks.is_sorted(), "{values:?}: {ticks:?}");
            }
        }
        let decades = axis(Scale::Log, &[1.0, 1e5]).ticks(8);
        assert!(decades.contains(&10.0) && decades.contains(&1e4), "{decades:?}");
    }
}
