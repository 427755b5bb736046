//! Near rectangles right behind the rim of a slanted leaf, where its volume has flaps that join it to its walls. The shadow
//! at each pixel is right by the near cap of `depth_walls`, which is skipped where `depth_near_walls` finds no surface.

use std::collections::HashSet;

use glam::{DVec2, DVec3, DVec4};
use rimline::ShadowCamera;
use rimline::gpu::depth_map::DepthMapOptions;
use rimline_testkit::device::Gpu;
use rimline_testkit::frames::{Eye, Rays, vector};
use rimline_testkit::harness::Test;
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, same};
use wgpu::TextureFormat;

use crate::contours::{Quad, UNIT, listed};
use crate::maps::Map;
use crate::near_rectangles::{both, eye_at, position};
use crate::parity::{self, SIDE, clip, light, seen, seen_depths};
use crate::picture::{Encoded, Maps, REVERSED, STANDARD, Target, by, contours, look, pipelines};

pub(crate) const TESTS: &[Test] = &[
    ("near_rectangles_behind_a_rim_have_the_parity_of_walls_and_flaps", behind_a_rim),
    ("near_rectangles_behind_a_flap_alone_are_in_shadow", behind_a_flap),
    ("near_caps_are_drawn_where_a_surface_may_rise_up_to_its_contour", beside_a_rising_rim),
];

const TEXELS: u32 = 24;
/// Texels of a contour beside which no more is asked than that the volume is closed.
const RIM: f64 = 2.0;

/// A depth over the texels of a map, from the near plane on: at texel 0, and how it grows across and down.
#[derive(Clone, Copy, Debug)]
struct Plane([f64; 3]);

impl Plane {
    fn at(&self, x: f64, y: f64) -> f64 {
        self.0[0] + self.0[1] * x + self.0[2] * y
    }

    /// By how much a position is behind it, times the distance from the light.
    fn ahead(&self, at: DVec4) -> f64 {
        at.z - self.0[0] * at.w - self.0[1] * at.x - self.0[2] * at.y
    }

    fn slopes(&self) -> f64 {
        self.0[1].abs() + self.0[2].abs()
    }
}

/// A round leaf over the ground or nothing.
struct Leaf {
    light: ShadowCamera,
    middle: DVec2,
    radius: f64,
    plane: Plane,
    ground: Option<Plane>,
    slope_bias: f64,
    /// A step of depth that is small beside all others.
    small: f64,
}

impl Leaf {
    fn random(random: &mut Random) -> Self {
        let (light, _) = light(random);
        let middle = DVec2::new(f64::from(random.between(9.0, 14.0)), f64::from(random.between(9.0, 14.0)));
        let radius = f64::from(random.between(4.5, 7.0));
        let [near, ahead] = [0.0, 0.5].map(|depth| {
            let depth = if light.depth == REVERSED { 1.0 - depth } else { depth };
            position(&light, [TEXELS; 2], [11.5; 2], depth)
        });
        let depth_at = |distance: f64| {
            let clip = clip(&light, near + distance * (ahead - near).normalize());
            if light.depth == REVERSED { 1.0 - clip.z / clip.w } else { clip.z / clip.w }
        };
        let mut plane = |distance: f64, steepness: f32| {
            let [here, step] = [depth_at(distance), depth_at(distance + 1.0)];
            let [across, down] = [0; 2].map(|_| (step - here) * f64::from(random.between(-steepness, steepness)));
            Plane([here - across * middle.x - down * middle.y, across, down])
        };
        let (plane, ground) = (plane(5.0, 0.12), plane(9.0, 0.03));
        let small = (1e-3 * (depth_at(5.01) - depth_at(5.0)).abs()).max(1e-6);
        let ground = (random.below(2) == 0).then_some(ground);
        let slope_bias = [0.0, 1.0][random.below(2)];
        Self { light, middle, radius, plane, ground, slope_bias, small }
    }

    fn away(&self, x: f64, y: f64) -> f64 {
        DVec2::new(x, y).distance(self.middle) - self.radius
    }

    /// Whether each row and column of the leaf has at least three texels, so that a slope is distinct from a jump.
    fn has_slopes(&self) -> bool {
        let is_in = |x: i32, y: i32| self.away(f64::from(x), f64::from(y)) < 0.0;
        (0..TEXELS as i32).all(|row| {
            let [across, down] = [false, true].map(|is_column| {
                (0..TEXELS as i32).filter(|&at| if is_column { is_in(row, at) } else { is_in(at, row) }).count()
            });
            [across, down].iter().all(|&count| count == 0 || count > 2)
        })
    }

    fn map(&self) -> Map {
        let is_reversed = self.light.depth == REVERSED;
        Map::new([TEXELS; 2], is_reversed, |texel| {
            let [x, y] = [texel % TEXELS, texel / TEXELS].map(f64::from);
            let plane = if self.away(x, y) < 0.0 { Some(self.plane) } else { self.ground };
            let depth = plane.map_or(1.0, |plane| plane.at(x, y));
            (if is_reversed { 1.0 - depth } else { depth }) as f32
        })
    }

    /// Texels across and down, and the depth from the near plane on, all times w.
    fn seen_by_light(&self, position: DVec3) -> DVec4 {
        let clip = clip(&self.light, position);
        let side = f64::from(TEXELS);
        let texel = |at: f64| ((at + clip.w) * side - clip.w) / 2.0;
        let depth = if self.light.depth == REVERSED { clip.w - clip.z } else { clip.z };
        DVec4::new(texel(clip.x), texel(-clip.y), depth, clip.w)
    }

    /// Whether a position is behind a plane, `None` within what the plane is moved by.
    fn is_behind(&self, plane: &Plane, at: DVec4) -> Option<bool> {
        let ahead = plane.ahead(at) / at.w;
        let moved = 0.5 * self.slope_bias * plane.slopes();
        if ahead < -self.small { Some(false) } else { (ahead > moved + self.small).then_some(true) }
    }

    /// Whether a position is in shadow, `None` near borders.
    fn is_dark(&self, at: DVec4) -> Option<bool> {
        let [x, y] = [at.x / at.w, at.y / at.w];
        let side = f64::from(TEXELS) - 1.0;
        let outside = (-x).max(x - side).max(-y).max(y - side);
        let away = self.away(x, y);
        if outside > RIM {
            Some(false)
        } else if away < -RIM {
            self.is_behind(&self.plane, at)
        } else if away > RIM && outside < -RIM {
            self.ground.map_or(Some(false), |ground| self.is_behind(&ground, at))
        } else {
            None
        }
    }

    /// Whether a surface, or where one may end, may be between two positions, or where its volume begins near one of them.
    fn is_between(&self, from: DVec4, to: DVec4) -> bool {
        let planes = [(Some(self.plane), true), (self.ground, false)];
        planes.into_iter().filter_map(|(plane, is_leaf)| Some((plane?, is_leaf))).any(|(plane, is_leaf)| {
            let may_be = |at: DVec4| {
                let away = self.away(at.x / at.w, at.y / at.w);
                if is_leaf { away < RIM } else { away > -RIM }
            };
            let ends = [from, to].map(|at| (may_be(at), self.is_behind(&plane, at)));
            if ends.iter().any(|&(may_be, is_behind)| may_be && is_behind.is_none()) {
                return true;
            }
            let [first, last] = [from, to].map(|at| plane.ahead(at));
            // Where the surface is, and where it is moved to.
            let moved = 0.5 * self.slope_bias * plane.slopes();
            [0.0, moved].into_iter().any(|moved| {
                let [first, last] = [first - moved * from.w, last - moved * to.w];
                (first > 0.0) != (last > 0.0) && may_be(from.lerp(to, first / (first - last)))
            })
        })
    }
}

fn crosses([a, b]: [DVec2; 2], at: DVec2) -> bool {
    (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
}

/// Whether a point of the near rectangle is within contours, and the flaps at the point with whether it is behind them.
fn among(quads: &[Quad], at: DVec4) -> (bool, Vec<(usize, bool)>) {
    let position = DVec2::new(at.x / at.w, at.y / at.w);
    let point = |vertex: [i32; 3]| DVec2::new(f64::from(vertex[0]), f64::from(vertex[1])) / 256.0 - 1.0;
    let mut segments = HashSet::new();
    let mut flaps = Vec::new();
    for (number, quad) in quads.iter().enumerate() {
        let [p, q, r, s] = quad.map(point);
        if p == q && r == s {
            segments.insert([[quad[0][0], quad[0][1]], [quad[2][0], quad[2][1]]]);
            continue;
        }
        for corners in [[0, 1, 2], [0, 2, 3]] {
            let [a, b, c] = corners.map(|corner: usize| point(quad[corner]));
            let is_in = [[a, b], [b, c], [c, a]].into_iter().filter(|&side| crosses(side, position)).count() % 2 == 1;
            if is_in {
                let shares = [
                    (b - position).perp_dot(c - position),
                    (c - position).perp_dot(a - position),
                    (a - position).perp_dot(b - position),
                ];
                let depths = corners.map(|corner: usize| f64::from(quad[corner][2]) / UNIT);
                let depth =
                    (0..3).map(|corner| shares[corner] * depths[corner]).sum::<f64>() / shares.iter().sum::<f64>();
                flaps.push((number, at.z / at.w > depth));
            }
        }
    }
    let segment = |[a, b]: [[i32; 2]; 2]| [a, b].map(|[x, y]| point([x, y, 0]));
    (segments.into_iter().filter(|&ends| crosses(segment(ends), position)).count() % 2 == 1, flaps)
}

fn behind_a_rim() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(16_304)?;
    // Pixels whose point of the near rectangle is between the leaf and a flap, and, the negative control, those for which
    // the next pixel's count is wrong.
    let (mut tally, mut between, mut others) = (parity::Tally::default(), 0, 0);
    for round in 0..if is_long() { 2000 } else { 120 } {
        let leaf = Leaf::random(&mut random);
        if !leaf.has_slopes() {
            continue;
        }
        let map = leaf.map();
        // A position within two texels of the rim, up to five slopes behind the leaf or a little before it.
        let angle = f64::from(random.between(0.0, std::f32::consts::TAU));
        let [x, y] =
            (leaf.middle + (leaf.radius + f64::from(random.between(-1.8, 0.3))) * DVec2::from_angle(angle)).to_array();
        let behind = f64::from(random.between(-0.5, 5.0)) * leaf.plane.slopes();
        let depth = leaf.plane.at(x, y) + behind;
        let depth = if map.is_reversed { 1.0 - depth } else { depth };
        let middle = position(&leaf.light, map.size, [x, y], depth);
        let texel = (position(&leaf.light, map.size, [x + 1.0, y], depth) - middle).length();
        let width = texel * [0.3, 1.0, 3.0][round % 3];
        let forward = vector(&mut random);
        let eye = eye_at(&mut random, middle, forward, width);
        let rays = Rays::new(&eye, SIDE);
        let seen = seen(&mut random, &rays);
        let depths = seen_depths(&eye, SIDE, &seen);
        let threshold = (leaf.small * 100.0) as f32;
        let method = contours([threshold, [0.0, 0.25, 0.5][random.below(3)], threshold]);
        let options = DepthMapOptions { slope_bias: leaf.slope_bias as f32, ..by(method) };
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, leaf.light)?;
        let target = Target::new(eye, &depths);
        let (stencil, encoded) = both(&gpu, &target, &maps, options)?;
        let quads = listed(&gpu, encoded.volumes.cells())?.1;
        for at in 0..SIDE * SIDE {
            let (near, position) = seen(parity::middle(at, SIDE));
            let [from, to] = [near, position].map(|position| leaf.seen_by_light(position));
            if from.w < 0.1 || to.w < 0.1 || leaf.is_between(from, to) {
                continue;
            }
            let Some(is_dark) = leaf.is_dark(to) else { continue };
            let among =
                |x: f64, y: f64| among(&quads, leaf.seen_by_light(seen(parity::middle(at, SIDE) + DVec2::new(x, y)).0));
            let here = among(0.0, 0.0);
            let around = [(-0.05, 0.0), (0.05, 0.0), (0.0, -0.05), (0.0, 0.05)];
            let is_clear = around.into_iter().all(|(x, y)| among(x, y) == here);
            let is_behind = leaf.is_behind(&leaf.plane, from) == Some(true);
            between += usize::from(is_clear && is_behind && here.1.iter().any(|&(_, is_behind)| !is_behind));
            tally.add(is_clear.then_some((is_dark, is_behind)), stencil[at as usize] != 0);
            let next = stencil[((at + 1) % (SIDE * SIDE)) as usize] != 0;
            others += usize::from(is_clear && is_dark != next);
        }
    }
    println!("{tally:?}, {between} between, {others} others");
    let parity::Tally { dark, lit, wrong, .. } = tally;
    let is_tried = dark.min(lit) > 1500 && between * 100 > dark + lit && others > 10;
    if wrong == 0 && is_tried { Ok(()) } else { Err(format!("{tally:?}")) }
}

/// A camera of parallel rays, which all have one direction.
fn parallel(at: DVec3, half_width: f64) -> ShadowCamera {
    let eye = look(at, DVec3::new(0.3, -0.8, 0.2), 0.5);
    Eye { is_relative: false, depth: STANDARD, far: Some(40.0), half_width: Some(half_width), ..eye }.camera()
}

/// A surface that comes nearer to the light up to its rim, in each of four directions, may come nearer by as much again. For
/// a near rectangle behind that and before all samples the near cap is drawn, and not for one before both.
fn beside_a_rising_rim() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let light = parallel(DVec3::new(1.0, 9.0, 2.0), 4.0);
    let options = DepthMapOptions { slope_bias: 0.0, ..by(contours([0.05, 0.25, 0.02])) };
    for (turn, at) in [[11.3, 12.0], [11.7, 12.0], [12.0, 11.3], [12.0, 11.7]].into_iter().enumerate() {
        let map = Map::new([TEXELS; 2], false, |texel| {
            let [x, y] = [texel % TEXELS, texel / TEXELS];
            match [x, TEXELS - 1 - x, y, TEXELS - 1 - y][turn] {
                // 0.39 at the rim.
                along @ ..12 => 0.5 - 0.01 * along as f32,
                _ => 1.0,
            }
        });
        let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, light)?;
        for (distance, is_drawn) in [(0.375, false), (0.385, true), (0.395, true)] {
            let near = position(&light, map.size, at, distance);
            let forward = (near - position(&light, map.size, at, 0.0)).normalize();
            let eye = parallel(near - 0.5 * forward, 0.02);
            let encoded = Encoded::new(&gpu, &*pipelines(&gpu, STANDARD, 0..1)?, &maps, &eye, options)?;
            same(&format!("turn {turn}, at {distance}"), &[encoded.has_cap()], &[is_drawn])?;
        }
    }
    Ok(())
}

/// A surface that bends away from the light between the ends of a segment. The flap does not, so a near rectangle may
/// be behind it and before all samples around.
fn behind_a_flap() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let light = parallel(DVec3::new(1.0, 9.0, 2.0), 4.0);
    let depth_of = |row: f64| 0.5 + 0.015 * (1.0 - ((row - 7.0) / 7.0).powi(2));
    let map = Map::new([TEXELS; 2], false, |texel| match texel % TEXELS {
        ..12 => depth_of(f64::from(texel / TEXELS)) as f32,
        _ => 1.0,
    });
    let maps = Maps::of(&gpu, &map, TextureFormat::R32Float, light)?;
    // Behind the flap, and, as the negative control, before it, where the eye sees a surface close behind the near
    // rectangle.
    for (distance, seen, is_behind) in [(0.508, 0.5, true), (0.49, 0.001, false)] {
        let near = position(&light, map.size, [10.8, 7.0], distance);
        let forward = (near - position(&light, map.size, [10.8, 7.0], 0.0)).normalize();
        let depths = [seen; (SIDE * SIDE) as usize];
        let target = Target::new(parallel(near - 0.5 * forward, 0.02), &depths);
        let options = DepthMapOptions { slope_bias: 0.0, ..by(contours([0.01, 0.25, 0.02])) };
        let (stencil, encoded) = both(&gpu, &target, &maps, options)?;
        let (_, quads) = listed(&gpu, encoded.volumes.cells())?;
        let (_, flaps) = among(&quads, DVec4::new(10.8, 7.0, distance, 1.0));
        same("flaps", &flaps.iter().map(|flap| flap.1).collect::<Vec<_>>(), &[is_behind])?;
        if stencil.iter().any(|&count| (count != 0) != is_behind) {
            return Err(format!("some at {distance} are not as they should be"));
        }
    }
    Ok(())
}
