//! The small languages of the command line: lights, points and picture sizes.

use rimline::Light;

/// Which light `--light` asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LightSpec {
    /// Given by its components.
    Given(Light),
    /// The file's light of this name.
    Named(String),
    /// Every light of the file, in its order.
    All,
}

/// Why a value of the command line is refused; clap says which option it was given to.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum SpecError {
    #[error("there is no kind of light `{0}`; write point:x,y,z, dir:x,y,z, hom:x,y,z,w, file:NAME or file:all")]
    Kind(String),
    #[error("a name must follow `file:`, or `all` for every light of the file")]
    NoName,
    #[error("{wanted} numbers are needed, separated by commas, but {given} are given")]
    Count { wanted: usize, given: usize },
    #[error("`{0}` is not a number")]
    Number(String),
    #[error("`{0}` is beyond what a 32-bit float holds (about ±3.4e38)")]
    Overflow(String),
    #[error("all components are zero, which is neither a point nor a direction")]
    Zero,
    #[error("a size is written as width x height in pixels, such as 1280x960")]
    Size,
    #[error("a picture needs at least one pixel each way")]
    NoPixels,
    #[error("the angle must lie between 0 and 180 degrees, both left out")]
    Angle,
}

/// A light from its SPEC. Components are rounded once, from the decimal digits to the nearest `f32`.
pub(crate) fn light(text: &str) -> Result<LightSpec, SpecError> {
    let (kind, rest) = text.split_once(':').ok_or_else(|| SpecError::Kind(text.to_owned()))?;
    let light = match kind {
        "point" => Light::point(numbers(rest)?),
        "dir" => Light::directional(numbers(rest)?),
        "hom" => Light::homogeneous(numbers(rest)?),
        "file" => {
            return match rest {
                "" => Err(SpecError::NoName),
                "all" => Ok(LightSpec::All),
                name => Ok(LightSpec::Named(name.to_owned())),
            };
        }
        _ => return Err(SpecError::Kind(kind.to_owned())),
    };
    if light.to_array() == [0.0; 4] {
        return Err(SpecError::Zero);
    }
    Ok(LightSpec::Given(light))
}

/// A point, `x,y,z`.
pub(crate) fn point(text: &str) -> Result<[f32; 3], SpecError> {
    numbers(text)
}

/// A picture's width and height, `WxH`.
pub(crate) fn size(text: &str) -> Result<[u32; 2], SpecError> {
    let (width, height) = text.split_once(['x', 'X']).ok_or(SpecError::Size)?;
    let pixels = |text: &str| text.trim().parse::<u32>().map_err(|_| SpecError::Size);
    match [pixels(width)?, pixels(height)?] {
        [0, _] | [_, 0] => Err(SpecError::NoPixels),
        size => Ok(size),
    }
}

/// A vertical field of view in degrees.
pub(crate) fn field_of_view(text: &str) -> Result<f32, SpecError> {
    let [degrees] = numbers(text)?;
    if degrees > 0.0 && degrees < 180.0 { Ok(degrees) } else { Err(SpecError::Angle) }
}

/// A time in seconds.
pub(crate) fn seconds(text: &str) -> Result<f32, SpecError> {
    number(text)
}

fn numbers<const N: usize>(text: &str) -> Result<[f32; N], SpecError> {
    let values = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    values.try_into().map_err(|values: Vec<_>| SpecError::Count { wanted: N, given: values.len() })
}

fn number(text: &str) -> Result<f32, SpecError> {
    let text = text.trim();
    // `str::parse` also takes "inf", "nan" and their like; only digits make a number here.
    if !text.contains(|c: char| c.is_ascii_digit()) {
        return Err(SpecError::Number(text.to_owned()));
    }
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(SpecError::Overflow(text.to_owned())),
        Err(_) => Err(SpecError::Number(text.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(text: &str) -> [f32; 4] {
        match light(text) {
            Ok(LightSpec::Given(light)) => light.to_array(),
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn lights_of_each_kind() {
        assert_eq!(given("point:-1,2e0,.5"), [-1.0, 2.0, 0.5, 1.0]);
        assert_eq!(given("dir:0,+1,-0"), [0.0, 1.0, 0.0, 0.0]);
        assert_eq!(given("hom:1e-3,-2.5E+2,3.,-4"), [1e-3, -250.0, 3.0, -4.0]);
        assert_eq!(light("file:all"), Ok(LightSpec::All));
        assert_eq!(light("file:key: left"), Ok(LightSpec::Named("key: left".into())));
    }

    #[test]
    fn digits_round_once_to_the_nearest() {
        // Just above the middle of 1 and its neighbour; by way of f64 it would land on the middle and round to 1.
        let text = "point:1.00000005960464477539062500000000000001,0,0";
        assert_eq!(given(text)[0], 1.0 + f32::EPSILON);
        assert_eq!(given("point:1e-60,1e-45,0")[..2], [0.0, f32::from_bits(1)]);
    }

    #[test]
    fn what_is_no_light_is_refused() {
        let error = |text: &str| light(text).expect_err(text);
        assert_eq!(error("sun:1,2,3"), SpecError::Kind("sun".into()));
        assert_eq!(error("1,2,3"), SpecError::Kind("1,2,3".into()));
        assert_eq!(error("point:1,2"), SpecError::Count { wanted: 3, given: 2 });
        assert_eq!(error("hom:1,2,3,4,5"), SpecError::Count { wanted: 4, given: 5 });
        assert_eq!(error("dir:1e39,0,0"), SpecError::Overflow("1e39".into()));
        assert_eq!(error("dir:inf,0,0"), SpecError::Number("inf".into()));
        assert_eq!(error("dir:0,nan,0"), SpecError::Number("nan".into()));
        assert_eq!(error("dir:0,,0"), SpecError::Number(String::new()));
        assert_eq!(error("dir:0,-0,0"), SpecError::Zero);
        assert_eq!(error("hom:0,0,0,0"), SpecError::Zero);
        assert_eq!(error("file:"), SpecError::NoName);
    }

    #[test]
    fn sizes_and_angles() {
        assert_eq!(size("1280x960"), Ok([1280, 960]));
        assert_eq!(size("0x960"), Err(SpecError::NoPixels));
        assert_eq!(size("-1x5"), Err(SpecError::Size));
        assert_eq!(size("640"), Err(SpecError::Size));
        assert_eq!(field_of_view("3.5e1"), Ok(35.0));
        assert_eq!(field_of_view("180"), Err(SpecError::Angle));
    }
}
