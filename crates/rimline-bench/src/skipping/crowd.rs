//! Figures that walk, and lamps that reach few of them.

use std::f32::consts::PI;

use glam::Vec3;
use rimline::{Instance, Light, Model, ModelError};

use super::walk::{MIDDLE, RADIUS, Walker, pose, walker_mesh};
use crate::random::Random;
use crate::record::{Camera, Casters, Setting};

pub(super) const LAMPS: usize = 32;
/// One pair of figure and lamp in so many is within the lamp's range.
const ONE_PAIR_IN: usize = 20;
/// The ground for each figure, in square metres.
const GROUND: f32 = 9.0;
/// The height of lamps above the ground.
const LAMP: f32 = 4.0;
/// The height of the eye of a figure.
const EYE: f32 = 1.6;

/// From where the crowd is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum View {
    /// From above its edge.
    Whole,
    /// From its middle, level.
    Within,
}

pub(super) fn setting(walker_count: usize, view: View) -> Result<Setting, ModelError> {
    let mut random = Random::new(3);
    let width = (GROUND * walker_count as f32).sqrt();
    let side = (walker_count as f32).sqrt().ceil().max(1.0) as usize;
    // Somewhere in its own square.
    let mut spot = |number: usize, columns: usize, rows: usize| {
        let mut along =
            |index: usize, count: usize| width * ((index as f32 + random.between(0.2, 0.8)) / count as f32 - 0.5);
        Vec3::new(along(number % columns, columns), 0.0, along(number / columns, rows))
    };
    let spots: Vec<Vec3> = (0..walker_count).map(|number| spot(number, side, walker_count.div_ceil(side))).collect();
    let lamps: Vec<Vec3> = (0..LAMPS).map(|number| spot(number, 8, LAMPS / 8) + LAMP * Vec3::Y).collect();
    // The range at which the lamps reach as many as they should.
    let mut distances: Vec<f32> =
        lamps.iter().flat_map(|&lamp| spots.iter().map(move |&at| from_lamp(lamp, at))).collect();
    distances.sort_by(f32::total_cmp);
    let pairs_in_range = (distances.len() / ONE_PAIR_IN).max(1);
    let range = distances.get(pairs_in_range - 1).map_or(1.0, |distance| distance + 1e-3);
    let walkers: Vec<Walker> = spots
        .iter()
        .map(|&at| {
            let [heading, phase] = [random.between(-PI, PI), random.between(0.0, 1.0)];
            Walker { at, heading, phase }
        })
        .collect();
    let model = Model::new(vec![walker_mesh()?], vec![Instance::new(0, None); walker_count])?;
    let (eye, forward) = match view {
        View::Whole => {
            let eye = Vec3::new(0.0, 0.25 * width + 2.0, 0.55 * width + 4.0);
            (eye, -eye.normalize())
        }
        // Where four squares meet.
        View::Within => (Vec3::new(width * ((side / 2) as f32 / side as f32 - 0.5), EYE, 0.0), Vec3::NEG_Z),
    };
    let camera = Camera { eye, right: Vec3::X, up: Vec3::X.cross(forward), forward, scale: 1.5, near: 0.1 };
    let pairs_in_range = distances.iter().filter(|distance| **distance <= range).count();
    let casters = Casters::Walking { model, pose: Box::new(move |frame| pose(&walkers, frame)) };
    let lights = lamps.iter().map(|lamp| Light::point(lamp.to_array()).with_range(range)).collect();
    Ok(Setting { pairs_in_range, ground: Some(0.0), ..Setting::new(casters, lights, camera.shadow()) })
}

/// From a lamp to the nearest point of a ball that holds a figure.
fn from_lamp(lamp: Vec3, foot: Vec3) -> f32 {
    ((foot + MIDDLE - lamp).length() - RADIUS).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twentieth_of_the_pairs_matters() {
        for count in [20, 100, 1000] {
            let Setting { pairs_in_range, lights, casters, .. } = setting(count, View::Whole).expect("figures");
            assert_eq!([lights.len(), casters.count()], [LAMPS, count]);
            let share = pairs_in_range as f32 / (count * LAMPS) as f32;
            assert!((0.045..=0.055).contains(&share), "{count} figures: {share}");
        }
    }
}
