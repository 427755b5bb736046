//! Volumes of a depth map against a lookup in the same map, without filter, as shaders of receivers do it: wrong pixels of the
//! same views.

use std::cell::OnceCell;

use glam::DVec2;
use rimline::DepthDirection;
use rimline::gpu::depth_map::{DepthMapMethod, DepthMapOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::random::Random;
use wgpu::TextureFormat;

use crate::parity::middle;
use crate::picture::Picture;
use crate::textures::{read, texture};
use crate::views::{MapOf, Near, SIDE, View, worlds};

pub(crate) const TESTS: &[Test] = &[("volumes_have_no_acne_and_lookups_have", compare)];

/// Else upright edges of boxes lie along the columns of a map, where the run of a contour does not tell a place.
const TURN: f64 = 0.5;

/// How a pixel's shadow is found.
#[derive(Clone, Copy, Debug)]
enum Way {
    Volumes(DepthMapMethod),
    /// With a bias of a map that is drawn: steps of its format, and multiples of its slope, as `wgpu::DepthBiasState` has them.
    Lookup {
        constant: f64,
        slope_scale: f64,
    },
}

const MARKED: DepthMapMethod = DepthMapMethod::Differences { threshold: 0.0005, dangling: None };
const CONTOURS: DepthMapMethod = DepthMapMethod::Contours { threshold: 0.0005, sideways: 0.1, depth: 0.002 };

const WAYS: [(&str, Way); 6] = [
    ("volumes, every cell", Way::Volumes(DepthMapMethod::EveryCell)),
    ("volumes, differences above 0.0005", Way::Volumes(MARKED)),
    ("contours, differences above 0.0005", Way::Volumes(CONTOURS)),
    ("lookup, no bias", Way::Lookup { constant: 0.0, slope_scale: 0.0 }),
    // The bias of wgpu's example of shadows.
    ("lookup, bias of 2 steps and 2 slopes", Way::Lookup { constant: 2.0, slope_scale: 2.0 }),
    ("volumes, automatic", Way::Volumes(DepthMapMethod::Automatic { dangling: None })),
];

/// Pixels that are wrong.
#[derive(Clone, Copy, Debug, Default)]
struct Wrong {
    /// Dark in the light, farther than a texel from a border and a fold: acne.
    acne: usize,
    /// Lit in the shadow, as far away.
    leaks: usize,
    at_folds: usize,
    /// Dark in the light, within a texel of a border.
    too_large: usize,
    /// Lit in the shadow, there.
    too_small: usize,
}

/// The step between depths of a format at a depth, as polygon offsets count it.
fn step(format: TextureFormat, depth: f64) -> f64 {
    match format {
        TextureFormat::Depth16Unorm => 1.0 / 65_536.0,
        TextureFormat::Depth24Plus => 1.0 / 16_777_216.0,
        _ => (depth.max(1e-30).log2().floor() - 23.0).exp2(),
    }
}

/// The depths that a map has if its triangles are drawn with a bias.
fn biased(view: &View<'_>, format: TextureFormat, [constant, slope_scale]: [f64; 2]) -> Vec<f32> {
    let is_reversed = view.sun.camera.depth == DepthDirection::Reversed;
    let (far, away) = if is_reversed { (0.0, -1.0) } else { (1.0, 1.0) };
    let depth = |(texel, seen): (u32, &crate::views::Seen)| {
        let Some((point, normal)) = *seen else { return far };
        let middle = middle(texel, view.side);
        // The depth of the surface's tangent plane.
        let on_plane = |place: DVec2| {
            let (from, direction) = view.light_rays.at(place);
            let t = (point - from).dot(normal) / direction.dot(normal);
            view.sun.in_map(from + t * direction).z
        };
        let slope = |axis: DVec2| (on_plane(middle + 0.1 * axis) - on_plane(middle - 0.1 * axis)).abs() / 0.2;
        let own = view.sun.in_map(point).z;
        let bias = slope_scale * slope(DVec2::X).max(slope(DVec2::Y)) + constant * step(format, own);
        (own + away * bias).clamp(0.0, 1.0) as f32
    };
    (0..).zip(&view.light_seen).map(depth).collect()
}

/// Whether each pixel is in shadow.
fn dark(gpu: &Gpu, view: &View<'_>, format: TextureFormat, way: Way) -> Result<Vec<bool>, String> {
    let [light_depths, eye_depths] = view.depths();
    let (light, eye) = (view.sun.camera, view.eye);
    match way {
        Way::Volumes(method) => {
            let map = &texture(gpu, [view.side; 2], format, &light_depths)?;
            let options = DepthMapOptions { method, ..Default::default() };
            let picture =
                Picture { map, objects: None, light, eye, depths: &eye_depths, side: SIDE, options, bits: 7..8 };
            Ok(picture.stencil(gpu)?.into_iter().map(|value| value != 0).collect())
        }
        Way::Lookup { constant, slope_scale } => {
            let map = texture(gpu, [view.side; 2], format, &biased(view, format, [constant, slope_scale]))?;
            let stored = read(gpu, &map)?;
            let dark = |seen: &crate::views::Seen| {
                let Some((point, _)) = *seen else { return false };
                let place = view.sun.in_map(point);
                let side = f64::from(view.side);
                let [x, y] = [place.x, place.y].map(|at| (at * side).floor());
                if x.min(y) < 0.0 || x.max(y) >= side {
                    return false;
                }
                let (own, stored) = (place.z as f32, stored[(y * side + x) as usize]);
                if light.depth == DepthDirection::Reversed { own < stored } else { own > stored }
            };
            Ok(view.eye_seen.iter().map(dark).collect())
        }
    }
}

fn compare() -> Result<(), String> {
    compare_with(MapOf::default(), if is_long() { 8 } else { 1 })?;
    if !is_long() {
        return Ok(());
    }
    compare_with(MapOf { turn: TURN, ..MapOf::default() }, 8)?;
    compare_with(MapOf { side: 384, ..MapOf::default() }, 4)?;
    compare_with(MapOf { side: 384, turn: TURN, ..MapOf::default() }, 4)
}

/// Wrong pixels with such maps.
fn compare_with(map: MapOf, rounds: usize) -> Result<(), String> {
    let seed = 1635;
    println!("seed {seed}, maps of {}², turned by {}", map.side, map.turn);
    let gpu = Gpu::shared()?;
    let mut random = Random::new(seed);
    let (mut lit, mut pixels) = (0, 0);
    let mut wrong = [Wrong::default(); 6];
    // Wrong pixels on bodies without narrow facets at their rims, and on the ground.
    let (mut of_fields, mut on_ground) = ([0; 6], [0; 6]);
    for format in [TextureFormat::Depth32Float, TextureFormat::Depth24Plus, TextureFormat::Depth16Unorm] {
        for _ in 0..rounds {
            for (number, world) in worlds(&mut random).into_iter().enumerate() {
                let Some(view) = View::lit(&mut random, &world, map) else { continue };
                let dark = WAYS.map(|(_, way)| dark(&gpu, &view, format, way));
                let dark = dark.into_iter().collect::<Result<Vec<_>, _>>()?;
                for (pixel, seen) in view.receivers() {
                    let (is_lit, near) = (view.is_lit(seen), OnceCell::new());
                    pixels += 1;
                    lit += usize::from(is_lit);
                    let tallies = wrong.iter_mut().zip(&mut of_fields).zip(&mut on_ground);
                    for (((wrong, of_fields), on_ground), dark) in tallies.zip(&dark) {
                        if dark[pixel] != is_lit {
                            continue;
                        }
                        let count = match (near.get_or_init(|| view.near(seen, 1.0)), is_lit) {
                            (Near::Border, true) => &mut wrong.too_large,
                            (Near::Border, false) => &mut wrong.too_small,
                            (Near::Fold, _) => &mut wrong.at_folds,
                            (Near::Nothing, true) => &mut wrong.acne,
                            (Near::Nothing, false) => &mut wrong.leaks,
                        };
                        *count += 1;
                        *of_fields += usize::from(number < 5);
                        *on_ground += usize::from(seen.0.y < 1e-7);
                    }
                }
            }
        }
    }
    println!("{pixels} pixels, {lit} of them lit");
    println!("| way | acne | leaks | at folds | dark at borders | lit at borders | on the ground | without facets |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    let rows = WAYS.iter().zip(wrong).zip(on_ground.iter().zip(of_fields));
    for (((name, _), Wrong { acne, leaks, at_folds, too_large, too_small }), (on_ground, of_fields)) in rows {
        println!("| {name} | {acne} | {leaks} | {at_folds} | {too_large} | {too_small} | {on_ground} | {of_fields} |");
    }
    let far = wrong.map(|wrong| wrong.acne + wrong.leaks);
    let all = wrong.map(|wrong| wrong.acne + wrong.leaks + wrong.at_folds + wrong.too_large + wrong.too_small);
    // The lookup without bias has acne, so the counts tell it.
    let has_acne = wrong[3].acne * 50 > lit;
    println!("contours: {:.2} of the lookup with bias", all[2] as f64 / all[4] as f64);
    // On the ground contours have half of what the lookup has, and in all, with steep sides of bodies, 0.65.
    if on_ground[2] * 2 > on_ground[4] || all[2] * 20 > all[4] * 13 {
        return Err(format!("{all:?}, {on_ground:?} on the ground"));
    }
    if far[0] == 0 && far[1].max(far[5]) * 100_000 <= pixels && far[2] * 5000 <= pixels && has_acne {
        Ok(())
    } else {
        Err(format!("{far:?} of {pixels} are wrong: {wrong:?}"))
    }
}
