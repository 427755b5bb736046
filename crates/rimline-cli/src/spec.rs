//! The small languages of the command line: lights, points and picture sizes.

use rimline::gltf::SceneLight;
use rimline::gpu::depth_map::{DanglingEdges, DepthMapMethod};
use rimline::mesh::{MeshError, WeldDistance};
use rimline::{AreaShape, Light};

use crate::coordinates::{Coordinate, GivenLight};

/// Which light `--light` asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LightSpec {
    /// Given by its components.
    Given(GivenLight),
    /// The file's light of this name, or else of this number.
    Named(String),
    /// Every light of the file, in its order.
    All,
}

/// A light of `rimline shadow`: where it is, and how it shines.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShadedLightSpec {
    pub(crate) light: LightSpec,
    /// Red, green and blue of its light, linear.
    pub(crate) color: Option<[f32; 3]>,
    pub(crate) intensity: Option<f32>,
    /// Where its light ends.
    pub(crate) range: Option<f32>,
    /// Where its light begins to fall off towards the range, and how.
    pub(crate) begin: Option<f32>,
    pub(crate) exponent: Option<f32>,
    /// Degrees from the way that a spot shines, up to which it has full light, and beyond which it has none.
    pub(crate) cone: Option<[f32; 2]>,
    /// The point that a spot shines at.
    pub(crate) target: Option<[Coordinate; 3]>,
    /// The radius of the sphere that shines.
    pub(crate) radius: Option<f32>,
}

/// A light's shape of `--area`; without sizes they are chosen by the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AreaSpec {
    /// With the sizes that it has for a radius of 1.
    Chosen(AreaShape),
    Given(AreaShape),
}

/// Why a value of the command line is refused; clap says which option it was given to.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum SpecError {
    #[error(
        "there is no kind of light `{0}`; write point:x,y,z, dir:x,y,z, hom:x,y,z,w, file:NAME, file:INDEX or file:all"
    )]
    Kind(String),
    #[error("a name or a number must follow `file:`, or `all` for every light of the file")]
    NoName,
    #[error("{wanted} numbers are needed, separated by commas, but {given} are given")]
    Count { wanted: usize, given: usize },
    #[error("`{0}` is not a number")]
    Number(String),
    #[error("`{0}` is beyond what a 32-bit float holds (about ±3.4e38)")]
    Overflow(String),
    #[error(transparent)]
    WeldDistance(MeshError),
    #[error("all components are zero, which is neither a point nor a direction")]
    Zero,
    #[error("a size is written as width x height in pixels, such as 1280x960")]
    Size,
    #[error("a picture needs at least one pixel each way")]
    NoPixels,
    #[error("a picture has at most {limit} pixels each way, not {given}")]
    Pixels { given: u32, limit: u32 },
    #[error("it is {0}, and a distance above 0 is needed, 1e30 at most; without a distance leave the option out")]
    Lift(f64),
    #[error("it is {given}, and may be {least} to {most}")]
    Range { given: f32, least: f32, most: f32 },
    #[error(
        "there is no light option `{0}`; there are range=R, begin=R, exponent=E, color=R,G,B, intensity=I, radius=R, \
         cone=INNER,OUTER and target=X,Y,Z"
    )]
    LampOption(String),
    #[error("{option}={value}: it must be {needed}")]
    LampValue { option: &'static str, value: f32, needed: &'static str },
    #[error(
        "begin={begin} lies beyond the range {range}: the light would end before it begins to fade; give it a smaller \
         begin or a larger range"
    )]
    BeginBeyondRange { begin: f32, range: f32 },
    #[error("{0}= says how a light fades towards its range, but it has none; give range=R, too, or leave {0}= out")]
    NoRange(&'static str),
    #[error("{0}= is measured from a light's place, but it is at infinity; leave {0}= out, or write point:x,y,z")]
    AtInfinity(&'static str),
    #[error("cone={inner},{outer}: write cone=INNER,OUTER, two angles from 0 to 90 degrees, the smaller first")]
    Cone { inner: f32, outer: f32 },
    #[error(
        "target= says where a spot shines, but the light has no cone; give cone=INNER,OUTER, too, or leave target= out"
    )]
    NoCone,
    #[error("a spot at the point that it shines at has no direction; give another target=X,Y,Z")]
    TargetAtLight,
    #[error("there is no shape `{0}`; write rect, rect:W,H, disc, disc:R, sphere or sphere:R")]
    Area(String),
    #[error("there is no detector `{0}`; write every, automatic, differences=T, second=LOW,HIGH or contours=T")]
    Detector(String),
    #[error("second=LOW,HIGH has the lower threshold first, not {low},{high}")]
    SecondThresholds { low: f32, high: f32 },
    #[error("device depths differ by 0 to 1, not {0}")]
    DepthThreshold(f32),
    #[error("edges that dangle go on by SHARE,CELLS: 0 to 1 of the thresholds, and 1 to 64 whole cells, such as 0.5,8")]
    Dangling,
    #[error("a light's size is more than 0, and at most {MOST_AREA_SIZE}")]
    AreaSize,
    #[error("the near plane must lie at a distance of more than 0")]
    Near,
    #[error("there are 1 to {limit} of them, not {given}")]
    SampleCount { given: u32, limit: u32 },
    #[error("the angle must lie between 0 and 180 degrees, both left out")]
    Angle,
    #[error("the angle must lie between 0 and 180 degrees")]
    Crease,
}

/// A light from its SPEC. Components are rounded once, from the decimal digits to the nearest `f32`, unless there is an
/// origin.
pub(crate) fn light(text: &str) -> Result<LightSpec, SpecError> {
    let (kind, rest) = text.split_once(':').ok_or_else(|| SpecError::Kind(text.to_owned()))?;
    let with = |[x, y, z]: [Coordinate; 3], w: f32| [x, y, z, Coordinate { single: w, double: w.into() }];
    let xyzw = match kind {
        "point" => with(coordinates(rest)?, 1.0),
        "dir" => with(coordinates(rest)?, 0.0),
        "hom" => coordinates(rest)?,
        "file" => {
            return match rest {
                "" => Err(SpecError::NoName),
                "all" => Ok(LightSpec::All),
                name => Ok(LightSpec::Named(name.to_owned())),
            };
        }
        _ => return Err(SpecError::Kind(kind.to_owned())),
    };
    let given = GivenLight::new(xyzw);
    if given.light.to_array() == [0.0; 4] {
        return Err(SpecError::Zero);
    }
    Ok(LightSpec::Given(given))
}

/// A light with its options, `SPEC[,option=value]…`.
pub(crate) fn shaded(text: &str) -> Result<ShadedLightSpec, SpecError> {
    let (light_text, options) = split_options(text);
    let mut shaded = ShadedLightSpec::new(light(light_text)?);
    let lamp = |option, value: f32, is_right: bool, needed| {
        if is_right { Ok(value) } else { Err(SpecError::LampValue { option, value, needed }) }
    };
    let bounded = |option, value| lamp(option, value, (0.0..=MOST_LAMP).contains(&value), "0 to 1000000000");
    for option in options {
        let (name, value) = option.split_once('=').unwrap_or((option, ""));
        match name {
            "range" => {
                let range = number(value)?;
                shaded.range = Some(lamp("range", range, range > 0.0, "more than 0")?);
            }
            "begin" => {
                let begin = number(value)?;
                shaded.begin = Some(lamp("begin", begin, begin >= 0.0, "0 or more")?);
            }
            "exponent" => shaded.exponent = Some(bounded("exponent", number(value)?)?),
            "intensity" => shaded.intensity = Some(bounded("intensity", number(value)?)?),
            "radius" => {
                let radius = number(value)?;
                let is_right = radius > 0.0 && radius <= MOST_AREA_SIZE;
                shaded.radius = Some(lamp("radius", radius, is_right, "more than 0, and at most 1e30")?);
            }
            "cone" => {
                let [inner, outer] = numbers(value)?;
                if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= 90.0) {
                    return Err(SpecError::Cone { inner, outer });
                }
                shaded.cone = Some([inner, outer]);
            }
            "target" => shaded.target = Some(coordinates(value)?),
            "color" => {
                let color: [f32; 3] = numbers(value)?;
                for component in color {
                    bounded("color", component)?;
                }
                shaded.color = Some(color);
            }
            _ => return Err(SpecError::LampOption(name.to_owned())),
        }
    }
    if let LightSpec::Given(given) = shaded.light {
        // The options that a light has in the file are known once the file is read.
        shaded.check(given.light, None)?;
    }
    Ok(shaded)
}

impl ShadedLightSpec {
    pub(crate) fn new(light: LightSpec) -> Self {
        Self {
            light,
            color: None,
            intensity: None,
            range: None,
            begin: None,
            exponent: None,
            cone: None,
            target: None,
            radius: None,
        }
    }

    /// Its options fit together and to the light, which may have a range and a cone of its own.
    pub(crate) fn check(&self, light: Light, of_file: Option<&SceneLight>) -> Result<(), SpecError> {
        let at_a_point =
            [("range", self.range.is_some()), ("cone", self.cone.is_some()), ("target", self.target.is_some())];
        if let Some((option, _)) = at_a_point.into_iter().find(|(_, is_given)| light.w == 0.0 && *is_given) {
            return Err(SpecError::AtInfinity(option));
        }
        if self.target.is_some() && self.cone.is_none() && of_file.is_none_or(|light| light.cone.is_none()) {
            return Err(SpecError::NoCone);
        }
        match (self.range.or(of_file.and_then(|light| light.range)), self.begin, self.exponent) {
            (None, Some(_), _) => Err(SpecError::NoRange("begin")),
            (None, None, Some(_)) => Err(SpecError::NoRange("exponent")),
            (Some(range), Some(begin), _) if begin > range => Err(SpecError::BeginBeyondRange { begin, range }),
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

pub(crate) fn area(text: &str) -> Result<AreaSpec, SpecError> {
    let given = |shape, sizes: &[f32]| {
        if sizes.iter().all(|&size| size > 0.0 && size <= MOST_AREA_SIZE) {
            Ok(AreaSpec::Given(shape))
        } else {
            Err(SpecError::AreaSize)
        }
    };
    match text.split_once(':') {
        None => Ok(AreaSpec::Chosen(match text {
            "rect" => AreaShape::Rectangle { width: 2.2, height: 1.4 },
            "disc" => AreaShape::Disc { radius: 1.0 },
            "sphere" => AreaShape::Sphere { radius: 1.0 },
            _ => return Err(SpecError::Area(text.to_owned())),
        })),
        Some(("rect", sizes)) => {
            let sizes @ [width, height] = numbers(sizes)?;
            given(AreaShape::Rectangle { width, height }, &sizes)
        }
        Some((kind @ ("disc" | "sphere"), size)) => {
            let radius = number(size)?;
            let is_disc = kind == "disc";
            given(if is_disc { AreaShape::Disc { radius } } else { AreaShape::Sphere { radius } }, &[radius])
        }
        Some(_) => Err(SpecError::Area(text.to_owned())),
    }
}

/// The largest intensity, color and exponent: sums and products of all lights stay far below the largest float.
const MOST_LAMP: f32 = 1e9;
/// The largest size of a light's shape, so that places on it stay finite.
const MOST_AREA_SIZE: f32 = 1e30;
/// The largest distance that points are lifted.
const MOST_LIFT: f64 = 1e30;
/// The largest width and height of a picture. Devices have limits of their own, which are lower.
const MOST_PIXELS: u32 = 1 << 16;
/// The largest time in seconds, before and after 0.
const MOST_SECONDS: f32 = 1e9;
/// How many pictures a second has.
const LEAST_FPS: f32 = 1e-3;
const MOST_FPS: f32 = 1e5;

/// At most so many lights stand for one.
pub(crate) const MOST_SAMPLES: u32 = 32;

pub(crate) fn samples(text: &str) -> Result<usize, SpecError> {
    const LIMIT: u32 = MOST_SAMPLES;
    match text.trim().parse::<u32>() {
        Ok(count @ 1..=LIMIT) => Ok(count as usize),
        Ok(given) => Err(SpecError::SampleCount { given, limit: LIMIT }),
        Err(_) => Err(SpecError::Number(text.to_owned())),
    }
}

pub(crate) fn near(text: &str) -> Result<f32, SpecError> {
    let distance = number(text)?;
    if distance > 0.0 { Ok(distance) } else { Err(SpecError::Near) }
}

pub(crate) fn lift(text: &str) -> Result<f64, SpecError> {
    let distance = coordinate(text)?.double;
    if distance > 0.0 && distance <= MOST_LIFT { Ok(distance) } else { Err(SpecError::Lift(distance)) }
}

pub(crate) fn pictures_a_second(text: &str) -> Result<f32, SpecError> {
    within(text, LEAST_FPS, MOST_FPS)
}

/// A length in seconds: one picture at least, as the most pictures a second make it.
pub(crate) fn length(text: &str) -> Result<f32, SpecError> {
    within(text, MOST_FPS.recip(), MOST_SECONDS)
}

fn within(text: &str, least: f32, most: f32) -> Result<f32, SpecError> {
    let given = number(text)?;
    if (least..=most).contains(&given) { Ok(given) } else { Err(SpecError::Range { given, least, most }) }
}

/// How far a segment may be from its contour, in texels.
const CONTOUR_SIDEWAYS: f32 = 0.1;
/// How far the ends of a wall may be from the surfaces that it joins, in thresholds.
const CONTOUR_THRESHOLDS: f32 = 4.0;

/// How shadows are found in depth maps.
pub(crate) fn detector(text: &str) -> Result<DepthMapMethod, SpecError> {
    let unknown = || SpecError::Detector(text.to_owned());
    match text.split_once('=') {
        None if text == "every" => Ok(DepthMapMethod::EveryCell),
        None if text == "automatic" => Ok(DepthMapMethod::Automatic { dangling: None }),
        Some(("differences", threshold)) => {
            Ok(DepthMapMethod::Differences { threshold: depth_difference(number(threshold)?)?, dangling: None })
        }
        Some(("second", thresholds)) => {
            let [low, high] = numbers(thresholds)?;
            let (low, high) = (depth_difference(low)?, depth_difference(high)?);
            if low <= high {
                Ok(DepthMapMethod::SecondDifferences { low, high, dangling: None })
            } else {
                Err(SpecError::SecondThresholds { low, high })
            }
        }
        Some(("contours", threshold)) => {
            let threshold = depth_difference(number(threshold)?)?;
            let depth = (CONTOUR_THRESHOLDS * threshold).min(1.0);
            Ok(DepthMapMethod::Contours { threshold, sideways: CONTOUR_SIDEWAYS, depth })
        }
        _ => Err(unknown()),
    }
}

/// How edges of depth maps go on that dangle, `SHARE,CELLS`.
pub(crate) fn dangling(text: &str) -> Result<DanglingEdges, SpecError> {
    let [share, cells] = numbers(text)?;
    if (0.0..=1.0).contains(&share) && (1.0..=64.0).contains(&cells) && cells.fract() == 0.0 {
        Ok(DanglingEdges { share, cells: cells as u32 })
    } else {
        Err(SpecError::Dangling)
    }
}

fn depth_difference(value: f32) -> Result<f32, SpecError> {
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(SpecError::DepthThreshold(value)) }
}

/// A picture's width and height, `WxH`.
pub(crate) fn size(text: &str) -> Result<[u32; 2], SpecError> {
    let (width, height) = text.split_once(['x', 'X']).ok_or(SpecError::Size)?;
    let pixels = |text: &str| text.trim().parse::<u32>().map_err(|_| SpecError::Size);
    match [pixels(width)?, pixels(height)?] {
        [0, _] | [_, 0] => Err(SpecError::NoPixels),
        [given, _] | [_, given] if given > MOST_PIXELS => Err(SpecError::Pixels { given, limit: MOST_PIXELS }),
        size => Ok(size),
    }
}

pub(crate) fn field_of_view(text: &str) -> Result<f32, SpecError> {
    let [degrees] = numbers(text)?;
    if degrees > 0.0 && degrees < 180.0 { Ok(degrees) } else { Err(SpecError::Angle) }
}

/// Degrees that a camera is led around in a film.
pub(crate) fn orbit(text: &str) -> Result<f32, SpecError> {
    within(text, -3600.0, 3600.0)
}

/// The angle of creases in degrees.
pub(crate) fn crease(text: &str) -> Result<f64, SpecError> {
    let [degrees] = numbers(text)?;
    if (0.0..=180.0).contains(&degrees) { Ok(degrees.into()) } else { Err(SpecError::Crease) }
}

/// An angle in degrees by which an eye moves around.
pub(crate) fn turn(text: &str) -> Result<f64, SpecError> {
    within(text, -36_000.0, 36_000.0).map(f64::from)
}

pub(crate) fn seconds(text: &str) -> Result<f32, SpecError> {
    within(text, -MOST_SECONDS, MOST_SECONDS)
}

pub(crate) fn weld_distance(text: &str) -> Result<WeldDistance, SpecError> {
    WeldDistance::new(number(text)?).map_err(SpecError::WeldDistance)
}

fn numbers<const N: usize>(text: &str) -> Result<[f32; N], SpecError> {
    separated(text, number)
}

pub(crate) fn coordinates<const N: usize>(text: &str) -> Result<[Coordinate; N], SpecError> {
    separated(text, coordinate)
}

fn separated<T, const N: usize>(text: &str, read: fn(&str) -> Result<T, SpecError>) -> Result<[T; N], SpecError> {
    let values = text.split(',').map(read).collect::<Result<Vec<_>, _>>()?;
    values.try_into().map_err(|values: Vec<_>| SpecError::Count { wanted: N, given: values.len() })
}

pub(crate) fn coordinate(text: &str) -> Result<Coordinate, SpecError> {
    let single = number(text)?;
    let double = text.trim().parse().map_err(|_| SpecError::Number(text.trim().to_owned()))?;
    Ok(Coordinate { single, double })
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
            Ok(LightSpec::Given(given)) => given.light.to_array(),
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
        assert_eq!(area("disc"), Ok(AreaSpec::Chosen(AreaShape::Disc { radius: 1.0 })));
        assert_eq!(area("rect:1,2"), Ok(AreaSpec::Given(AreaShape::Rectangle { width: 1.0, height: 2.0 })));
        assert_eq!(area("sphere:.5"), Ok(AreaSpec::Given(AreaShape::Sphere { radius: 0.5 })));
        assert_eq!((size("1280x960"), field_of_view("3.5e1")), (Ok([1280, 960]), Ok(35.0)));
    }
}
