//! Command lines of benches.

use crate::Error;

/// The value behind an option, if that is there. cargo adds `--bench` behind all, so nothing that begins so is a value.
pub fn value_of(option: &'static str, arguments: &[String]) -> Result<Option<String>, Error> {
    let mut from_option = arguments.iter().skip_while(|argument| *argument != option);
    if from_option.next().is_none() {
        return Ok(None);
    }
    let value = from_option.next().filter(|value| !value.starts_with("--")).cloned();
    value.map(Some).ok_or(Error::NoValue { option })
}

#[cfg(test)]
mod tests {
    use super::value_of;

    #[test]
    fn an_option_without_its_value_is_refused() {
        let value = |line: &str| {
            let arguments: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
            value_of("--json", &arguments).map_err(|error| error.to_string())
        };
        assert_eq!(value("depth_maps casters --quick --bench"), Ok(None));
        assert_eq!(value("depth_maps --json a.json --bench"), Ok(Some("a.json".to_owned())));
        for line in ["depth_maps --json", "depth_maps --json --bench"] {
            assert_eq!(value(line), Err("--json needs a value; give one behind it".to_owned()), "{line}");
        }
    }
}
