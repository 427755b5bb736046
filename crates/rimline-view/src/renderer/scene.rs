//! The state of the viewer as pictures take it.

use rimline_picture::{Camera, Part, SceneBounds, SceneView, ShadedLight, reach};

use crate::state::lamp::Lamp;
use crate::state::viewer::Viewer;

/// The scene that a picture of the viewer shows.
pub(super) struct SeenScene {
    camera: Camera,
    size: [u32; 2],
    bounds: SceneBounds,
    lights: Vec<ShadedLight>,
    reach: f32,
}

impl SeenScene {
    /// In a picture of this size.
    pub(super) fn of(viewer: &Viewer, size: [u32; 2]) -> Self {
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
        Self { camera, size, bounds, lights, reach }
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
        let Self { camera, size, bounds, lights, reach } = self;
        SceneView { camera, size: *size, part: &Part::WHOLE, bounds, lights, reach: *reach }
    }
}

fn shaded(lamp: &Lamp) -> ShadedLight {
    let light = lamp.light();
    ShadedLight { color: lamp.shine().into(), range: light.range, cone: lamp.spot_cone(), ..ShadedLight::new(light) }
}
