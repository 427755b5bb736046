//! The state of the viewer as pictures take it.

use rimline_picture::{Camera, Part, SceneBounds, SceneView, ShadedLight, reach};

use crate::state::lamp::Lamp;
use crate::state::viewer::Viewer;

/// The scene that a picture of the viewer shows.
pub(super) struct SeenScene {
    camera: Camera,
    size: [u32; 2],
    part: Part,
    bounds: SceneBounds,
    lights: Vec<ShadedLight>,
    reach: f32,
}

impl SeenScene {
    /// In a picture of this size, a part of whose pixels is drawn.
    pub(super) fn of(viewer: &Viewer, size: [u32; 2], part: Part) -> Self {
        let bounds = SceneBounds { models: viewer.bounds(), ground: viewer.ground() };
        let camera = viewer.orbit.camera(size, &bounds.models, bounds.ground).view;
        let sources = viewer.sources();
        let lamps = viewer.lamps.iter().filter(|lamp| lamp.is_on).enumerate();
        let lights: Vec<_> = lamps
            .map(|(number, lamp)| {
                let lights_of_lamp = sources.iter().filter(|(of, _)| *of == number).map(|(_, source)| source.light());
                ShadedLight { samples: lights_of_lamp.collect(), shown: Some(number as u32), ..shaded(lamp) }
            })
            .collect();
        let reach = reach(&lights, &bounds.models.corners().map(Into::into), &bounds);
        Self { camera, size, part, bounds, lights, reach }
    }

    /// For each light the number of its first sample among those of all, and its own.
    pub(super) fn firsts(&self) -> Vec<[usize; 2]> {
        let mut next = 0;
        let numbered = self.lights.iter().enumerate();
        let firsts = numbered.map(|(number, light)| {
            let first = next;
            next += light.samples.len();
            [first, number]
        });
        firsts.collect()
    }

    pub(super) fn view(&self) -> SceneView<'_> {
        let Self { camera, size, part, bounds, lights, reach } = self;
        SceneView { camera, size: *size, part, bounds, lights, reach: *reach }
    }
}

fn shaded(lamp: &Lamp) -> ShadedLight {
    let light = lamp.light();
    ShadedLight { color: lamp.shine().into(), range: light.range, cone: lamp.spot_cone(), ..ShadedLight::new(light) }
}

#[cfg(test)]
mod tests {
    use glam::{Mat4, Vec2, Vec3};
    use rimline::ShadowCamera;

    use super::*;
    use crate::state::event::Event;

    #[test]
    fn a_pixel_of_half_the_rows_and_columns_shows_the_middle_of_four() {
        let mut viewer = Viewer::new(crate::scenes::moebius().expect("a band"));
        for size in [[520, 512], [521, 512], [520, 513], [3, 401], [401, 3]] {
            viewer.handle(Event::Resized(size));
            let (seen, drawn) = (SeenScene::of(&viewer, size, Part::halved(size)), Part::size(size));
            let ShadowCamera { view_projection, origin, .. } = seen.view().shadow_camera();
            for corner in viewer.bounds().corners() {
                let at = Mat4::from_cols_array_2d(&view_projection) * (corner - Vec3::from(origin)).extend(1.0);
                let ndc = Vec2::new(at.x, -at.y) / at.w;
                let pixel = (0.5 * ndc + 0.5) * Vec2::from(drawn.map(|pixels| pixels as f32));
                let expected = viewer.camera().project(corner).expect("it is before the eye");
                assert!((2.0 * pixel).distance(expected) < 1e-2, "{size:?}: {pixel} is half of {expected}");
            }
        }
    }
}
