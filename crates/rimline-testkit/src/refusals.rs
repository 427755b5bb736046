//! Tables of calls that must be refused.

use std::error::Error;
use std::fmt::{Debug, Display};

/// A row: a call, and the error that it must end with.
pub struct Refusal {
    /// The name of the row, which a failure tells.
    pub what: String,
    /// The error of the call: how `Debug` shows it, and its message.
    pub made: Result<(), [String; 2]>,
    pub expected: Expected,
}

/// The outcome that a row expects.
pub enum Expected {
    /// The error that `Debug` shows so. NaN equals itself.
    Is(String),
    /// An error of which `Debug` shows each of these.
    Shows(Vec<String>),
    /// An error whose message contains each of these.
    Says(Vec<String>),
    /// No error.
    Taken,
}

/// This error, with all of its fields.
pub fn is<E: Debug>(error: E) -> Expected {
    Expected::Is(format!("{error:?}"))
}

/// An error of which `Debug` shows each of `parts`: a variant, and fields that are known.
pub fn shows(parts: &[&str]) -> Expected {
    Expected::Shows(parts.iter().map(ToString::to_string).collect())
}

/// An error whose message contains each of `parts`.
pub fn says(parts: &[&str]) -> Expected {
    Expected::Says(parts.iter().map(ToString::to_string).collect())
}

/// A row of a table.
pub fn refusal<T, E: Error>(what: impl Display, made: Result<T, E>, expected: Expected) -> Refusal {
    let made = made.map(drop).map_err(|error| [format!("{error:?}"), error.to_string()]);
    Refusal { what: what.to_string(), made, expected }
}

/// Fails with the first row whose call ended otherwise.
pub fn refused(rows: impl IntoIterator<Item = Refusal>) -> Result<(), String> {
    rows.into_iter().try_for_each(|Refusal { what, made, expected }| {
        let (is_right, wanted) = match (&made, expected) {
            (made, Expected::Taken) => (made.is_ok(), "no error".to_owned()),
            (made, Expected::Is(error)) => (made.as_ref().is_err_and(|[shown, _]| *shown == error), error),
            (made, Expected::Shows(parts)) => {
                (made.as_ref().is_err_and(|[shown, _]| contains(shown, &parts)), format!("an error with {parts:?}"))
            }
            (made, Expected::Says(parts)) => {
                (made.as_ref().is_err_and(|[_, said]| contains(said, &parts)), format!("a message with {parts:?}"))
            }
        };
        if is_right { Ok(()) } else { Err(format!("{what}: {made:?}, expected {wanted}")) }
    })
}

fn contains(text: &str, parts: &[String]) -> bool {
    parts.iter().all(|part| text.contains(part))
}

#[cfg(test)]
mod tests {
    use rimline::{Light, LightError};

    use super::*;

    /// The driver fails with the name of a row that is not refused as it says, wherever it stands.
    #[test]
    fn wrong_rows_are_named() {
        let nan = LightError::Range { index: 2, range: f32::NAN };
        let made = |error: Option<LightError>| error.map_or(Ok(Light::point([0.0; 3])), Err);
        let right = || {
            [
                refusal("is", made(Some(nan)), is(nan)),
                refusal("shows", made(Some(nan)), shows(&["Range {", "index: 2"])),
                refusal("says", made(Some(nan)), says(&["light 2", "has the range"])),
                refusal("nothing is wrong", made(None), Expected::Taken),
            ]
        };
        assert_eq!(refused(right()), Ok(()));
        let other = LightError::Range { index: 3, range: f32::NAN };
        for wrong in [
            refusal("the row", made(Some(other)), is(nan)),
            refusal("the row", made(None), is(nan)),
            refusal("the row", made(Some(nan)), shows(&["index: 2", "index: 3"])),
            refusal("the row", made(Some(nan)), shows(&["light 2"])),
            refusal("the row", made(None), shows(&[])),
            refusal("the row", made(Some(nan)), says(&["light 2", "light 3"])),
            refusal("the row", made(Some(nan)), says(&["index: 2"])),
            refusal("the row", made(None), says(&[])),
            refusal("the row", made(Some(nan)), Expected::Taken),
        ] {
            let failed = refused(right().into_iter().chain([wrong])).expect_err("a wrong row");
            assert!(failed.starts_with("the row: "), "{failed}");
        }
    }
}
