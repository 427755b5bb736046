//! The small languages of the command line: lights, points and picture sizes.

use std::collections::BTreeSet;
use std::str::FromStr;

use rimline::gltf::SceneLight;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod};
use rimline::mesh::WeldDistance;
use rimline::{AreaShape, Light};

use crate::coordinates::{Coordinate, GivenLight};

/// Which light `--light` asks for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum LightSpec {
    Given(GivenLight),
    /// The file's light of this name, or else of this number.
    Named(String),
    #[default]
    All,
}

/// A light of `rimline shadow`: where it is, and how it shines.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ShadedLightSpec {
    pub(crate) light: LightSpec,
    /// Red, green and blue of its light, linear.
    pub(crate) color: Option<[f32; 3]>,
    pub(crate) intensity: Option<f32>,
    pub(crate) range: Option<f32>,
    /// Where its light begins to fall off towards the range, and how.
    pub(crate) begin: Option<f32>,
    pub(crate) exponent: Option<f32>,
    /// Degrees from the way that a spot shines, up to which it has full light, and beyond which it has none.
    pub(crate) cone: Option<[f32; 2]>,
    pub(crate) target: Option<[Coordinate; 3]>,
    pub(crate) radius: Option<f32>,
}

/// A light's shape of `--area`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AreaSpec {
    pub(crate) shape: AreaShape,
    /// No size is given: the scene chooses a radius, and these are the sizes for one of 1.
    pub(crate) is_relative: bool,
}

/// A value, if it is one that may be given.
fn checked<T>(value: T, is_right: bool, why: impl Into<String>) -> Result<T, String> {
    if is_right { Ok(value) } else { Err(why.into()) }
}

/// A light from its SPEC. Components are rounded once, from the decimal digits to the nearest `f32`, unless there is an
/// origin.
pub(crate) fn light(text: &str) -> Result<LightSpec, String> {
    let unknown = |kind: &str| {
        let wrong = unknown_word("kind of light", kind);
        format!("{wrong}; write point:x,y,z, dir:x,y,z, hom:x,y,z,w, file:NAME, file:INDEX or file:all")
    };
    let (kind, rest) = text.split_once(':').ok_or_else(|| unknown(text))?;
    let with = |[x, y, z]: [Coordinate; 3], w: f32| [x, y, z, Coordinate { single: w, double: w.into() }];
    let xyzw = match kind {
        "point" => with(coordinates(rest)?, 1.0),
        "dir" => with(coordinates(rest)?, 0.0),
        "hom" => coordinates(rest)?,
        "file" => {
            return match rest {
                "" => Err("a name or a number must follow `file:`, or `all` for every light of the file".to_owned()),
                "all" => Ok(LightSpec::All),
                name => Ok(LightSpec::Named(name.to_owned())),
            };
        }
        _ => return Err(unknown(kind)),
    };
    let given = GivenLight(xyzw);
    let is_light = given.light().to_array() != [0.0; 4];
    checked(LightSpec::Given(given), is_light, "all components are zero, which is neither a point nor a direction")
}

/// A light with its options, `SPEC[,option=value]…`.
pub(crate) fn shaded(text: &str) -> Result<ShadedLightSpec, String> {
    let (light_text, options) = split_options(text);
    let mut shaded = ShadedLightSpec { light: light(light_text)?, ..ShadedLightSpec::default() };
    let mut names = BTreeSet::new();
    for option in options {
        let (name, value) = option.split_once('=').unwrap_or((option, ""));
        checked((), names.insert(name), format!("{name}= is given twice; give it once"))?;
        let lamp = |value: f32, is_right, needed: &str| {
            checked(value, is_right, format!("{name}={value}: it must be {needed}"))
        };
        let bounded = |value| lamp(value, (0.0..=MOST_LAMP).contains(&value), "0 to 1000000000");
        match name {
            "range" => {
                let range = number(value)?;
                shaded.range = Some(lamp(range, range > 0.0, "more than 0")?);
            }
            "begin" => {
                let begin = number(value)?;
                shaded.begin = Some(lamp(begin, begin >= 0.0, "0 or more")?);
            }
            "exponent" => shaded.exponent = Some(bounded(number(value)?)?),
            "intensity" => shaded.intensity = Some(bounded(number(value)?)?),
            "radius" => {
                let radius = number(value)?;
                let is_right = radius > 0.0 && radius <= MOST_AREA_SIZE;
                shaded.radius = Some(lamp(radius, is_right, "more than 0, and at most 1e30")?);
            }
            "cone" => {
                let [inner, outer] = numbers(value)?;
                let is_right = 0.0 <= inner && inner <= outer && 0.0 < outer && outer <= 90.0;
                let why = "write cone=INNER,OUTER, two angles from 0 to 90 degrees, the smaller first";
                shaded.cone = Some(checked([inner, outer], is_right, format!("cone={inner},{outer}: {why}"))?);
            }
            "target" => shaded.target = Some(coordinates(value)?),
            "color" => {
                let [red, green, blue] = numbers(value)?;
                shaded.color = Some([bounded(red)?, bounded(green)?, bounded(blue)?]);
            }
            _ => {
                return Err(format!(
                    "there is no light option `{name}`; there are range=R, begin=R, exponent=E, color=R,G,B, intensity=I, \
                     radius=R, cone=INNER,OUTER and target=X,Y,Z"
                ));
            }
        }
    }
    if let LightSpec::Given(given) = shaded.light {
        // The options that a light has in the file are known once the file is read.
        shaded.check(given.light(), None).map_err(|(_, problem)| problem)?;
    }
    Ok(shaded)
}

impl ShadedLightSpec {
    /// Its options fit together and to the light, which may have a range and a cone of its own. If not: whether that is refused
    /// even where they fit other lights of `file:all`, and why.
    pub(crate) fn check(&self, light: Light, of_file: Option<&SceneLight>) -> Result<(), (bool, String)> {
        let at_a_point =
            [("range", self.range.is_some()), ("cone", self.cone.is_some()), ("target", self.target.is_some())];
        if let Some((option, _)) = at_a_point.into_iter().find(|(_, is_given)| light.w == 0.0 && *is_given) {
            let why = "is measured from a light's position, but it is at infinity";
            return Err((false, format!("{option}= {why}; leave {option}= out, or write point:x,y,z")));
        }
        if self.target.is_some() && self.cone.is_none() && of_file.is_none_or(|light| light.cone.is_none()) {
            let why = "target= says where a spot shines, but the light has no cone; give cone=INNER,OUTER, too, or leave \
                       target= out";
            return Err((false, why.to_owned()));
        }
        let no_range = |option: &str| {
            let why = "says how a light fades towards its range, but it has none; give range=R, too, or leave";
            Err((false, format!("{option}= {why} {option}= out")))
        };
        match (self.range.or(of_file.and_then(|light| light.range)), self.begin, self.exponent) {
            (None, Some(_), _) => no_range("begin"),
            (None, None, Some(_)) => no_range("exponent"),
            (Some(range), Some(begin), _) if begin > range => {
                let why = "the light would end before it begins to fade; give it a smaller begin or a larger range";
                Err((true, format!("begin={begin} lies beyond the range {range}: {why}")))
            }
            _ => Ok(()),
        }
    }
}

/// The part before the first `,name=`, and the options after it, whose values may hold commas.
fn split_options(text: &str) -> (&str, Vec<&str>) {
    // A comma begins an option where a name of letters and `=` follow.
    let is_start = |&(at, _): &(usize, &str)| {
        let name = text[at + 1..].split('=').next().unwrap_or_default();
        at + 1 + name.len() < text.len() && !name.is_empty() && name.chars().all(|c| c.is_ascii_alphabetic())
    };
    let starts: Vec<usize> = text.match_indices(',').filter(is_start).map(|(at, _)| at).collect();
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    let options = starts.iter().zip(ends).map(|(&start, end)| &text[start + 1..end]).collect();
    (&text[..starts.first().copied().unwrap_or(text.len())], options)
}

pub(crate) fn area(text: &str) -> Result<AreaSpec, String> {
    let (kind, sizes) = text.split_once(':').map_or((text, None), |(kind, sizes)| (kind, Some(sizes)));
    let given = |size: f32| {
        let is_right = size > 0.0 && size <= MOST_AREA_SIZE;
        checked(size, is_right, format!("a light's size is more than 0, and at most {MOST_AREA_SIZE}"))
    };
    let radius = || sizes.map_or(Ok(1.0), |radius| given(number(radius)?));
    let shape = match kind {
        "rect" => {
            let [width, height] = sizes.map_or(Ok([2.2, 1.4]), numbers)?;
            AreaShape::Rectangle { width: given(width)?, height: given(height)? }
        }
        "disc" => AreaShape::Disc { radius: radius()? },
        "sphere" => AreaShape::Sphere { radius: radius()? },
        _ => {
            let wrong = unknown_word("shape", text);
            return Err(format!("{wrong}; write rect, rect:W,H, disc, disc:R, sphere or sphere:R"));
        }
    };
    Ok(AreaSpec { shape, is_relative: sizes.is_none() })
}

/// The largest intensity, color and exponent: sums and products of all lights stay far below the largest float.
const MOST_LAMP: f32 = 1e9;
/// The largest size of a light's shape, so that points on it stay finite.
const MOST_AREA_SIZE: f32 = 1e30;
/// The largest width and height of a picture. Devices have limits of their own, which are lower.
const MOST_PIXELS: u32 = 1 << 16;

pub(crate) fn near(text: &str) -> Result<f32, String> {
    let distance = number(text)?;
    checked(distance, distance > 0.0, "the near plane must lie at a distance of more than 0")
}

pub(crate) fn lift(text: &str) -> Result<f64, String> {
    let distance = coordinate(text)?.double;
    let needed = "a distance above 0 is needed, 1e30 at most; without a distance leave the option out";
    checked(distance, distance > 0.0 && distance <= 1e30, format!("it is {distance}, and {needed}"))
}

/// Reads a number from `least` to `most`.
pub(crate) fn within(least: f32, most: f32) -> impl Fn(&str) -> Result<f32, String> + Clone {
    move |text| {
        let given = number(text)?;
        checked(given, (least..=most).contains(&given), format!("it is {given}, and may be {least} to {most}"))
    }
}

/// The texels along a side of a depth map.
pub(crate) fn map_side(text: &str) -> Result<u32, String> {
    let no_side =
        |_| format!("`{text}` is no number of texels; give each FILE before --from-depth, or write --from-depth=1024");
    let side = text.parse::<u32>().map_err(no_side)?;
    checked(side, (3..=4096).contains(&side), format!("{side} is not in 3..=4096"))
}

pub(crate) fn detector(text: &str) -> Result<DepthMapMethod, String> {
    match text.split_once('=') {
        None if text == "every" => Ok(DepthMapMethod::EveryCell),
        None if text == "automatic" => Ok(DepthMapMethod::Automatic { dangling: None }),
        Some(("differences", threshold)) => {
            Ok(DepthMapMethod::Differences { threshold: depth_difference(number(threshold)?)?, dangling: None })
        }
        Some(("second", thresholds)) => {
            let [low, high] = numbers(thresholds)?;
            let (low, high) = (depth_difference(low)?, depth_difference(high)?);
            let why = format!("second=LOW,HIGH has the lower threshold first, not {low},{high}");
            checked(DepthMapMethod::SecondDifferences { low, high, dangling: None }, low <= high, why)
        }
        Some(("contours", threshold)) => {
            let threshold = depth_difference(number(threshold)?)?;
            // In texels, and in thresholds.
            let (sideways, depth) = (0.1, (4.0 * threshold).min(1.0));
            Ok(DepthMapMethod::Contours { threshold, sideways, depth })
        }
        _ => {
            let wrong = unknown_word("detector", text);
            Err(format!("{wrong}; write every, automatic, differences=T, second=LOW,HIGH or contours=T"))
        }
    }
}

/// How edges of depth maps go on that dangle, `SHARE,CELLS`.
pub(crate) fn dangling(text: &str) -> Result<DanglingEdges, String> {
    let [share, cells] = numbers(text)?;
    let is_right = (0.0..=1.0).contains(&share) && (1.0..=64.0).contains(&cells) && cells.fract() == 0.0;
    let why =
        "edges that dangle go on by SHARE,CELLS: 0 to 1 of the thresholds, and 1 to 64 whole cells, such as 0.5,8";
    checked(DanglingEdges { share, cells: cells as u32 }, is_right, why)
}

fn depth_difference(value: f32) -> Result<f32, String> {
    checked(value, (0.0..=1.0).contains(&value), format!("device depths differ by 0 to 1, not {value}"))
}

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = "a size is written as width x height in pixels, such as 1280x960";
    let (width, height) = text.split_once(['x', 'X']).ok_or(wrong)?;
    let pixels = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong);
    match [pixels(width)?, pixels(height)?] {
        [0, _] | [_, 0] => Err("a picture needs at least one pixel each way".to_owned()),
        [given, _] | [_, given] if given > MOST_PIXELS => {
            Err(format!("a picture has at most {MOST_PIXELS} pixels each way, not {given}"))
        }
        size => Ok(size),
    }
}

pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    let is_angle = degrees > 0.0 && degrees < 180.0;
    checked(degrees, is_angle, "the angle must lie between 0 and 180 degrees, both left out")
}

pub(crate) fn crease(text: &str) -> Result<f64, String> {
    let degrees = number(text)?;
    checked(degrees.into(), (0.0..=180.0).contains(&degrees), "the angle must lie between 0 and 180 degrees")
}

pub(crate) fn weld_distance(text: &str) -> Result<WeldDistance, String> {
    WeldDistance::new(number(text)?).map_err(|error| error.to_string())
}

fn numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    separated(text, number)
}

pub(crate) fn coordinates<const N: usize>(text: &str) -> Result<[Coordinate; N], String> {
    separated(text, coordinate)
}

fn separated<T, const N: usize>(text: &str, read: fn(&str) -> Result<T, String>) -> Result<[T; N], String> {
    if text.trim().is_empty() {
        return Err(format!("the value is missing; give {N} numbers, separated by commas"));
    }
    if text.split(',').any(|part| part.trim().is_empty()) {
        return Err("a number is missing; write all with commas between them, and without spaces".to_owned());
    }
    let values = text.split(',').map(read).collect::<Result<Vec<_>, _>>()?;
    values.try_into().map_err(|values: Vec<_>| {
        format!("{N} numbers are needed, separated by commas, but {} are given", values.len())
    })
}

pub(crate) fn coordinate(text: &str) -> Result<Coordinate, String> {
    let single = number(text)?;
    let double = text.trim().parse().map_err(|_| no_number(text.trim()))?;
    Ok(Coordinate { single, double })
}

fn no_number(text: &str) -> String {
    if text.is_empty() {
        return "the value is missing; give a number".to_owned();
    }
    format!("`{text}` is not a number")
}

fn unknown_word(what: &str, word: &str) -> String {
    if word.is_empty() { format!("the {what} is missing") } else { format!("there is no {what} `{word}`") }
}

fn number(text: &str) -> Result<f32, String> {
    let text = text.trim();
    // `str::parse` also takes "inf", "nan" and their like; only digits make a number here.
    if !text.contains(|c: char| c.is_ascii_digit()) {
        return Err(no_number(text));
    }
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("`{text}` is beyond what a 32-bit float holds (about ±3.4e38)")),
        Err(_) => Err(no_number(text)),
    }
}

const UP: [f32; 3] = [0.0, 1.0, 0.0];

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    Named(&'static str, [f32; 3]),
    /// To the right of the front, and above the ground, in degrees.
    Angles(f64, f64),
}

const SIDES: [(&str, [f32; 3]); 7] = [
    ("front", [0.0, 0.0, 1.0]),
    ("back", [0.0, 0.0, -1.0]),
    ("left", [-1.0, 0.0, 0.0]),
    ("right", [1.0, 0.0, 0.0]),
    ("top", [0.0, 1.0, 0.0]),
    ("bottom", [0.0, -1.0, 0.0]),
    ("iso", [1.0, 1.0, 1.0]),
];

impl FromStr for Side {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((name, side)) = SIDES.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)) {
            return Ok(Self::Named(name, side));
        }
        let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
            let angle = |text: &str| text.trim().parse().ok().filter(|degrees: &f64| degrees.abs() <= 360.0);
            Some((angle(azimuth)?, angle(elevation).filter(|degrees| degrees.abs() <= 90.0)?))
        });
        let (azimuth, elevation) = angles.ok_or(
            "a side is front, back, left, right, top, bottom, iso, or an azimuth from -360 to 360 and an elevation from -90 to 90 \
             degrees, such as 30,15",
        )?;
        Ok(Self::Angles(azimuth, elevation))
    }
}

impl Side {
    /// The direction towards the eye, of any length, and the direction that is up on the page.
    pub(crate) fn directions(self) -> ([f64; 3], [f32; 3]) {
        match self {
            Self::Named(_, side) => (side.map(f64::from), up_of(side.map(f64::from))),
            Self::Angles(azimuth, elevation) => {
                let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
                let (sine, cosine) = (libm::sin(azimuth), libm::cos(azimuth));
                let (height, level) = (libm::sin(elevation), libm::cos(elevation));
                if level > 1e-6 {
                    return ([sine * level, height, cosine * level], UP);
                }
                // Straight from above or below the azimuth still turns the page.
                ([0.0, height, 0.0], [-sine, 0.0, -cosine].map(|c| (c * height) as f32))
            }
        }
    }
}

/// The direction that is up on the page: +Y, or for an eye above or below -Z or +Z.
pub(crate) fn up_of([x, y, z]: [f64; 3]) -> [f32; 3] {
    if libm::sqrt(x * x + z * z) > 1e-6 * y.abs() { UP } else { [0.0, 0.0, if y < 0.0 { 1.0 } else { -1.0 }] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(text: &str) -> [f32; 4] {
        match light(text) {
            Ok(LightSpec::Given(given)) => given.light().to_array(),
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
    fn lamps_and_their_options() {
        let shaded = |text: &str| shaded(text).expect(text);
        let plain = shaded("point:1,2,3");
        assert_eq!((plain.color, plain.intensity, plain.range), (None, None, None));
        let spot = shaded("point:0,5,2,radius=.2,cone=20,30,target=0,-1,.5");
        assert_eq!((spot.radius, spot.cone), (Some(0.2), Some([20.0, 30.0])));
        assert_eq!(spot.target.map(|target| target.map(|c| c.double)), Some([0.0, -1.0, 0.5]));
        // It may be a spot.
        assert!(shaded("file:Lamp,target=1,2,3").target.is_some());
        let full = shaded("point:0,1,0,color=1,.5,0,range=7,begin=2,exponent=3,intensity=.5");
        assert_eq!((full.color, full.intensity, full.range), (Some([1.0, 0.5, 0.0]), Some(0.5), Some(7.0)));
        assert_eq!((full.begin, full.exponent), (Some(2.0), Some(3.0)));
        let named = shaded("file:Lamp, big,range=2");
        assert_eq!((named.light, named.range), (LightSpec::Named("Lamp, big".into()), Some(2.0)));
        // It may have a range of its own.
        assert_eq!(shaded("file:Lamp,begin=2").begin, Some(2.0));
        assert_eq!(shaded("point:1,2,3,range=4,begin=4").begin, Some(4.0));
    }

    #[test]
    fn areas_sizes_and_angles() {
        let spec = |shape, is_relative| Ok(AreaSpec { shape, is_relative });
        assert_eq!(area("disc"), spec(AreaShape::Disc { radius: 1.0 }, true));
        assert_eq!(area("rect:1,2"), spec(AreaShape::Rectangle { width: 1.0, height: 2.0 }, false));
        assert_eq!(area("sphere:.5"), spec(AreaShape::Sphere { radius: 0.5 }, false));
        assert_eq!((size("1280x960"), field_of_view("3.5e1")), (Ok([1280, 960]), Ok(35.0)));
    }
}
