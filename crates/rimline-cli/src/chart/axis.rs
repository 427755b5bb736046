//! Axes: from numbers to places, and where the ticks are.

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

    /// 0 at the low end, 1 at the high one; numbers outside are taken as the end.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let place = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) }
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
            assert!(axis.place(0.001) < axis.place(5.0) && axis.place(5.0) < axis.place(70.0));
            for value in [f64::NAN, -1.0, 0.0, 1e9, f64::INFINITY] {
                assert!((0.0..=1.0).contains(&axis.place(value)), "{value}");
            }
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
