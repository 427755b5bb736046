//! Pairs of face and light, class by class, that a predicate can get wrong: in a plane by construction or all but, at
//! every magnitude. Built on whole numbers times a power of two, so that zeros are exact.

use rimline::Light;

use super::oracle::ExactFace;
use super::random::Random;
use super::{any_finite, is_long, must_fail};

/// Lights of a batch.
pub const LIGHTS: usize = 16;
/// Faces of a batch.
pub const FACES: usize = 3000;

type Corners = [[f32; 3]; 3];
type Lattice = [i64; 3];

/// How pairs of one class are made, and which signs must be among them.
struct Class {
    name: &'static str,
    light: fn(&mut Random) -> Source,
    face: fn(&mut Random, &Source) -> Corners,
    zeros: Among,
    signs: Among,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Among {
    /// More than one in a hundred.
    Many,
    /// It does not matter.
    Any,
    None,
}

/// A light, and where it lies among whole numbers: at `point · 2^scale`, or towards it.
struct Source {
    light: Light,
    point: Lattice,
    scale: i32,
}

/// Faces, each made for the light of its index modulo [`LIGHTS`].
pub struct Batch {
    pub positions: Vec<[f32; 3]>,
    pub faces: Vec<[u32; 3]>,
    pub lights: Vec<Light>,
}

impl Batch {
    /// The face's corners and its light.
    pub fn pair(&self, face: usize) -> (Corners, Light) {
        (self.faces[face].map(|v| self.positions[v as usize]), self.lights[face % LIGHTS])
    }

    /// The exact sign of each pair.
    fn signs(&self) -> Vec<i32> {
        let sign = |face| {
            let (corners, light) = self.pair(face);
            ExactFace::new(&corners, [0, 1, 2]).map_or(0, |exact| exact.sign(light))
        };
        (0..self.faces.len()).map(sign).collect()
    }
}

/// The bit of each face for its own light.
pub fn bits_of_pairs(masks: &[u32]) -> Vec<bool> {
    (0..).zip(masks).map(|(face, mask)| mask >> (face % LIGHTS) & 1 != 0).collect()
}

/// Runs on batches of every class, with the class's name and the exact signs: at least 200,000 pairs, 10 million in the long
/// run. Fails where a class lacks the signs that it is there for.
pub fn for_every_class(
    seed: u64,
    mut run: impl FnMut(&str, &Batch, &[i32]) -> Result<(), String>,
) -> Result<(), String> {
    let batches = usize::div_ceil(if is_long() { 10_000_000 } else { 200_000 }, CLASSES.len() * FACES);
    println!("seed {seed}; {} cases", batches * CLASSES.len() * FACES);
    for (number, class) in (0..).zip(&CLASSES) {
        let mut random = Random::new(seed + 1000 * number);
        let mut counts = [0; 3];
        for index in 0..batches {
            let batch = class.batch(&mut random);
            let signs = batch.signs();
            for sign in &signs {
                counts[(sign + 1) as usize] += 1;
            }
            run(&format!("{}, batch {index}", class.name), &batch, &signs)?;
        }
        println!("{}: {counts:?} negative, zero, positive", class.name);
        class.check(counts)?;
        must_fail("a class of one sign", &class.check([0, 0, FACES]))?;
    }
    Ok(())
}

impl Class {
    fn batch(&self, random: &mut Random) -> Batch {
        let sources: Vec<Source> = (0..LIGHTS).map(|_| (self.light)(random)).collect();
        let corners: Vec<Corners> = (0..FACES).map(|face| (self.face)(random, &sources[face % LIGHTS])).collect();
        Batch {
            positions: corners.concat(),
            faces: (0..FACES as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(),
            lights: sources.into_iter().map(|source| source.light).collect(),
        }
    }

    /// Fails unless the class has the signs that it is there for: so many negative, zero, positive.
    fn check(&self, counts: [usize; 3]) -> Result<(), String> {
        let [negative, zero, positive] = counts;
        let has = |count: usize, among| match among {
            Among::Many => count * 100 > counts.iter().sum::<usize>(),
            Among::Any => true,
            Among::None => count == 0,
        };
        if has(zero, self.zeros) && has(positive, self.signs) && has(negative, self.signs) {
            Ok(())
        } else {
            Err(format!("{}: not the signs that it should have: {counts:?}", self.name))
        }
    }
}

/// Every class. Lights anywhere in the plane of a face are alike, but for those at a corner.
const CLASSES: [Class; 9] = {
    use Among::{Any, Many, None};
    const fn class(
        name: &'static str,
        light: fn(&mut Random) -> Source,
        face: fn(&mut Random, &Source) -> Corners,
        zeros: Among,
        signs: Among,
    ) -> Class {
        Class { name, light, face, zeros, signs }
    }
    [
        class("random", any_light, random_face, None, Many),
        class("coplanar but for rounding, ± 1 ulp", any_light, nearly_coplanar, Any, Many),
        class("coplanar ± 1 ulp", |random| source(random, W::Any, [-60, 60]), coplanar, Many, Many),
        class("degenerate", |random| source(random, W::Any, [-40, 40]), degenerate, Many, None),
        class("subnormal", |random| source(random, W::Any, [-149, -149]), subnormal, Many, Many),
        class("mixed magnitudes", wild_light, wild_face, Many, Many),
        class("huge", |random| source(random, W::Any, [112, 114]), huge, Many, Many),
        class("w tiny", |random| source(random, W::Tiny, [-2, 60]), around_origin, Many, Many),
        class("light on a vertex", |random| source(random, W::NotZero, [-60, 60]), on_vertex, Many, Many),
    ]
};

#[derive(Clone, Copy, PartialEq, Eq)]
enum W {
    Tiny,
    NotZero,
    /// Often 0, 1 or negative.
    Any,
}

/// Whole numbers up to 300, times `2^scale` with a scale from `least` to `most`.
fn source(random: &mut Random, w: W, [least, most]: [i32; 2]) -> Source {
    let scale = between(random, least, most);
    let point = lattice(random, 300);
    // w = factor · 2^power, and (x, y, z) = w · point: neither loses a bit.
    let (lowest, highest) = ((-149_i32).max(-149 - scale), 124.min(115 - scale));
    let power = match random.below(2) {
        0 => between(random, lowest.max(-3), highest.min(3).max(lowest.max(-3))),
        _ => between(random, lowest, highest),
    };
    let factor = between(random, 1, 7);
    let (factor, power) = match (w, random.below(4)) {
        (W::Tiny, _) => (factor, between(random, lowest, lowest + 40)),
        (_, 0) => (1, 0),
        (W::Any, 1) => (0, power),
        (_, 2) => (-factor, power),
        _ => (factor, power),
    };
    if factor == 0 {
        let [x, y, z] = placed(if point == [0; 3] { [1, 0, 0] } else { point }, scale);
        return Source { light: Light::homogeneous([x, y, z, 0.0]), point, scale };
    }
    let [x, y, z] = placed(point.map(|c| c * i64::from(factor)), scale + power);
    let w = (f64::from(factor) * 2.0_f64.powi(power)) as f32;
    Source { light: Light::homogeneous([x, y, z, w]), point, scale }
}

fn between(random: &mut Random, low: i32, high: i32) -> i32 {
    low + random.below((high - low + 1) as usize) as i32
}

fn lattice(random: &mut Random, most: i32) -> Lattice {
    [(); 3].map(|()| i64::from(between(random, -most, most)))
}

/// Whole numbers times `2^scale`, of which no bit is lost.
fn placed(point: Lattice, scale: i32) -> [f32; 3] {
    point.map(|c| {
        let exact = c as f64 * 2.0_f64.powi(scale);
        assert_eq!(f64::from(exact as f32), exact, "{c} · 2^{scale} is no f32");
        exact as f32
    })
}

fn sum(a: Lattice, factor: i64, b: Lattice) -> Lattice {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

/// Turned round by chance, and two of three times with a coordinate moved by one ulp.
fn nudged(random: &mut Random, corners: [Lattice; 3], scale: i32) -> Corners {
    let mut corners = corners.map(|corner| placed(corner, scale));
    let turn = random.below(3);
    corners.rotate_left(turn);
    if random.below(3) != 0 {
        nudge(random, &mut corners);
    }
    corners
}

fn nudge(random: &mut Random, corners: &mut Corners) {
    let coordinate = &mut corners[random.below(3)][random.below(3)];
    *coordinate = if random.below(2) == 0 { coordinate.next_up() } else { coordinate.next_down() };
}

/// A light in the plane of a face.
fn coplanar(random: &mut Random, source: &Source) -> Corners {
    let (a, b) = (lattice(random, 300), lattice(random, 300));
    let to_light = if source.light.w == 0.0 { source.point } else { sum(source.point, -1, a) };
    let c = sum(a, i64::from(between(random, -4, 4)), sum(b, -1, a));
    let c = sum(c, i64::from(between(random, -4, 4)), to_light);
    nudged(random, [a, b, c], source.scale)
}

/// A face in a plane through the origin and the light: coplanar for every w.
fn around_origin(random: &mut Random, source: &Source) -> Corners {
    if random.below(2) == 0 {
        return coplanar(random, source);
    }
    let across = lattice(random, 300);
    let corners = [(); 3].map(|()| {
        let along = source.point.map(|c| c * i64::from(between(random, -6, 6)));
        sum(along, i64::from(between(random, -6, 6)), across)
    });
    nudged(random, corners, source.scale)
}

fn on_vertex(random: &mut Random, source: &Source) -> Corners {
    let corners = [source.point, lattice(random, 300), lattice(random, 300)];
    nudged(random, corners, source.scale)
}

/// Two or three corners are one, or all lie on a line.
fn degenerate(random: &mut Random, source: &Source) -> Corners {
    let (a, along) = (lattice(random, 300), lattice(random, 300));
    let [first, second] = [0; 2].map(|_| i64::from(between(random, -4, 4)));
    let second = if random.below(3) == 0 { first } else { second };
    let mut corners = [a, sum(a, first, along), sum(a, second, along)].map(|corner| placed(corner, source.scale));
    if random.below(3) == 0 {
        // Not on the lattice.
        corners[0] = random.direction();
        corners[1] = [corners[0], corners[2]][random.below(2)];
    }
    let turn = random.below(3);
    corners.rotate_left(turn);
    corners
}

fn subnormal(random: &mut Random, source: &Source) -> Corners {
    if random.below(3) != 0 {
        return coplanar(random, source);
    }
    [[(); 3]; 3].map(|corner| corner.map(|()| f32::from_bits(random.next_u64() as u32 & 0x807f_ffff)))
}

fn huge(random: &mut Random, source: &Source) -> Corners {
    if random.below(3) != 0 {
        return coplanar(random, source);
    }
    [[(); 3]; 3].map(|corner| {
        corner.map(|()| {
            let exponent = between(random, 248, 254) as u32;
            f32::from_bits(random.next_u64() as u32 & 0x807f_ffff | exponent << 23)
        })
    })
}

/// Any finite number, zero one time of three.
fn wild(random: &mut Random) -> f32 {
    if random.below(3) == 0 { 0.0 } else { any_finite(random) }
}

fn wild_light(random: &mut Random) -> Source {
    let w = [0.0, 1.0, wild(random), -1.0][random.below(4)];
    let mut light = [wild(random), wild(random), wild(random), w];
    if light == [0.0; 4] {
        light[1] = f32::MIN_POSITIVE;
    }
    Source { light: Light::homogeneous(light), point: [0; 3], scale: 0 }
}

fn wild_face(random: &mut Random, _: &Source) -> Corners {
    [[(); 3]; 3].map(|corner| corner.map(|()| wild(random)))
}

fn any_light(random: &mut Random) -> Source {
    let [x, y, z] = random.direction().map(|c| c * random.between(-4.0, 6.0).exp2());
    let w = [0.0, 1.0, random.between(0.2, 5.0), random.between(-3.0, -0.1)][random.below(4)];
    Source { light: Light::homogeneous([x, y, z, w]), point: [0; 3], scale: 0 }
}

fn random_face(random: &mut Random, _: &Source) -> Corners {
    let scale = random.between(-6.0, 6.0).exp2();
    let centre = random.direction().map(|c| c * random.between(0.0, 4.0));
    [(); 3].map(|()| {
        let corner = random.direction();
        std::array::from_fn(|i| centre[i] + corner[i] * scale)
    })
}

fn nearly_coplanar(random: &mut Random, source: &Source) -> Corners {
    let mut corners = random_face(random, source);
    let [a, b, _] = corners;
    let (s, t) = (random.between(-2.0, 2.0), random.between(-2.0, 2.0));
    let [x, y, z, w] = source.light.to_array();
    let l = [x, y, z];
    corners[2] = std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (l[i] - w * a[i]));
    if random.below(3) != 0 {
        nudge(random, &mut corners);
    }
    corners
}
