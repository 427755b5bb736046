//! Numbers as text.

pub(crate) use crate::row::grouped;

pub(crate) fn three_digits(number: f64) -> String {
    match number.abs() {
        _ if !number.is_finite() => "–".to_owned(),
        0.0 => "0".to_owned(),
        size if size >= 99.95 => grouped(number.round() as usize),
        size if size >= 9.995 => format!("{number:.1}"),
        size if size >= 0.9995 => format!("{number:.2}"),
        size if size >= 0.0995 => format!("{number:.3}"),
        size if size >= 0.001 => format!("{number:.4}"),
        _ => format!("{number:.1e}"),
    }
}

/// A tick of an axis: no more figures than it needs.
pub(crate) fn tick(value: f64) -> String {
    match value {
        v if v >= 1e6 => format!("{} M", short(v / 1e6)),
        v if v >= 1e4 => format!("{} k", short(v / 1e3)),
        v if v >= 1e3 => grouped(v.round() as usize),
        v => short(v),
    }
}

fn short(value: f64) -> String {
    let is_small = (f64::MIN_POSITIVE..0.001).contains(&value.abs());
    let text = if is_small { format!("{value:.3e}") } else { format!("{value:.4}") };
    let (number, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    number.trim_end_matches('0').trim_end_matches('.').to_owned() + power
}

pub(crate) fn times(value: f64) -> String {
    format!("{}×", short(value))
}

pub(crate) fn lights_text(lights: usize) -> String {
    if lights == 1 { "1 light".to_owned() } else { format!("{lights} lights") }
}

pub(crate) fn or_dash(number: Option<f64>) -> String {
    number.map_or_else(|| "–".to_owned(), three_digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_grouped() {
        assert_eq!([grouped(0), grouped(999), grouped(1_048_576)], ["0", "999", "1,048,576"]);
        assert_eq!([1.0, 0.5, 0.01, 20_000.0, 3e6].map(tick), ["1", "0.5", "0.01", "20 k", "3 M"]);
        assert_eq!([0.0, 0.0012, 1.2e-4, 2e-5].map(tick), ["0", "0.0012", "1.2e-4", "2e-5"]);
        assert_eq!([1234.6, 12.34, 1.2, 0.1234, 0.0].map(three_digits), ["1,235", "12.3", "1.20", "0.123", "0"]);
    }
}
