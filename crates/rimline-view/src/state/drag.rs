//! Actions of the pointer on the picture: it drags lights, and turns and moves the camera.

use glam::{Vec2, Vec3};

use super::event::{Button, Modifiers};
use super::handle::{Drag, Handle};
use super::lamp::{LampKind, sun_distance};
use super::viewer::Viewer;
use rimline_picture::Bounds;

/// Degrees for each pixel that the pointer moves.
const TURN: f32 = 0.35;

impl Viewer {
    pub(super) fn zoom(&mut self, factor: f32) {
        self.orbit.zoom(factor, self.bounds().extent());
    }

    /// Moves the camera so that the target follows the pointer.
    pub(super) fn pan(&mut self, pixels: Vec2) {
        let length = self.camera().pixel() * self.orbit.distance;
        self.orbit.shift(Vec3::new(-pixels.x, pixels.y, 0.0) * length);
    }

    pub(super) fn pressed(&mut self, button: Button, modifiers: Modifiers) {
        self.drag = Some(match (button, self.handle_at(self.pointer)) {
            (Button::Primary, Some(handle)) => {
                if let Handle::Lamp(lamp) = handle {
                    self.selected = Some(lamp);
                }
                Drag::Handle(handle, modifiers)
            }
            (Button::Primary, None) if !modifiers.shift => Drag::Turn,
            _ => Drag::Pan,
        });
    }

    pub(super) fn moved(&mut self, to: Vec2) {
        let by = to - self.pointer;
        self.pointer = to;
        match self.drag {
            Some(Drag::Turn) => self.orbit.turn(-TURN * by.x, TURN * by.y),
            Some(Drag::Pan) => self.pan(by),
            Some(Drag::Handle(handle, modifiers)) => self.drag_handle(handle, to, modifiers),
            None => self.hovered = self.handle_at(to),
        }
    }

    /// The handle at a pixel, the nearest one.
    fn handle_at(&self, pixel: Vec2) -> Option<Handle> {
        let (camera, bounds) = (self.camera(), self.bounds());
        let lamps = self.lamps.iter().enumerate().map(|(number, lamp)| (Handle::Lamp(number), lamp.handle(&bounds)));
        let target = self.selected.and_then(|number| Some((Handle::Target(number), self.target(number, &bounds)?)));
        let all = lamps.chain(target).filter_map(|(handle, at)| Some((handle, camera.project(at)?.distance(pixel))));
        let nearest = all.min_by(|(_, a), (_, b)| a.total_cmp(b));
        nearest.filter(|(_, distance)| *distance <= self.handle_radius).map(|(handle, _)| handle)
    }

    fn target(&self, number: usize, bounds: &Bounds) -> Option<Vec3> {
        self.lamps.get(number)?.target(bounds)
    }

    /// Moves a handle to where the pointer is: in a plane that faces the eye, at its height, or up and down. A light at
    /// infinity stays on its sphere, whichever keys are held.
    fn drag_handle(&mut self, handle: Handle, pixel: Vec2, modifiers: Modifiers) {
        let (camera, bounds) = (self.camera(), self.bounds());
        let (Handle::Lamp(number) | Handle::Target(number)) = handle;
        let Some(lamp) = self.lamps.get_mut(number) else { return };
        let (ray, from) = (camera.ray(pixel), camera.view.eye);
        let target = lamp.target(&bounds).filter(|_| handle == Handle::Target(number));
        let at = target.unwrap_or_else(|| lamp.handle(&bounds));
        // Where the ray meets a plane through the handle, but not farther than can be worked with.
        let meet = |normal: Vec3| {
            let along = (at - from).dot(normal) / ray.dot(normal);
            let most = 200.0 * bounds.extent();
            (along.is_finite() && along > 0.0 && along < most).then(|| from + along * ray)
        };
        let moved = if modifiers.shift {
            let level = Vec3::new(camera.view.forward.x, 0.0, camera.view.forward.z).normalize_or(camera.view.up);
            meet(level).map(|there| Vec3::new(at.x, there.y, at.z))
        } else if modifiers.control {
            meet(Vec3::Y)
        } else {
            meet(camera.view.forward)
        };
        if target.is_some() {
            lamp.aim(moved.unwrap_or(at));
        } else if let LampKind::Point(_) = lamp.kind {
            lamp.move_to(moved.unwrap_or(at), &bounds);
        } else {
            let centre = bounds.centre();
            lamp.move_to(centre + on_sphere(from, ray, centre, sun_distance(&bounds), at), &bounds);
        }
    }

    /// Moves the selected light by a step: right and ahead as the eye sees it, on the level, and up.
    pub(super) fn shift_lamp(&mut self, by: Vec3) {
        let (bounds, [right, _, forward]) = (self.bounds(), self.orbit.axes());
        let ahead = Vec3::new(forward.x, 0.0, forward.z).normalize_or(Vec3::NEG_Z);
        let by = (by.x * right + by.y * Vec3::Y + by.z * ahead) * 0.06 * bounds.extent();
        let Some(lamp) = self.lamp() else { return };
        let handle = lamp.handle(&bounds) + by;
        lamp.move_to(handle, &bounds);
    }
}

/// From the middle of a sphere to where a ray meets it, the meeting nearest to `at`; or to where the ray is nearest.
fn on_sphere(from: Vec3, ray: Vec3, centre: Vec3, radius: f32, at: Vec3) -> Vec3 {
    let (ray, to) = (ray.normalize(), centre - from);
    let middle = to.dot(ray);
    let half = (radius * radius - (to - middle * ray).length_squared()).max(0.0).sqrt();
    let meetings = [middle - half, middle + half].map(|along| from + along * ray);
    let [near, far] = meetings;
    if near.distance_squared(at) <= far.distance_squared(at) { near - centre } else { far - centre }
}
