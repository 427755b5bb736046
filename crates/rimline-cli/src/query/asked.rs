//! Contents of a query: points, the faces that they are on, lights, and how far points are lifted.

use std::slice;

use rimline::{Light, Mesh};

use crate::output::note;

/// Points and lights, in the space of the positions.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) points: &'a [[f32; 3]],
    /// One for each point.
    pub(super) on_face: Option<&'a [u32]>,
    pub(super) lights: &'a [Light],
    /// How far points are moved towards each light before they are asked about.
    pub(super) lift: Option<f64>,
}

impl Asked<'_> {
    /// The number of lights that a count takes: a lifted point is another one for each light.
    pub(super) fn lights_at_once(&self) -> usize {
        if self.lift.is_some() { 1 } else { self.lights.len() }
    }

    /// Points of one call or submission: few enough that no GPU is kept busy for long and no result takes much memory.
    pub(super) fn slice(&self, mesh: &Mesh) -> usize {
        let pairs = ((1 << 36) / mesh.faces().len().max(1)).clamp(1 << 12, 1 << 22);
        (pairs / self.lights.len().max(1)).max(64)
    }

    /// Adds the depths of all points, a slice at a time. `count` counts for points as they are.
    pub(super) fn each_slice<E>(
        &self,
        slice: usize,
        depths: &mut Vec<i32>,
        mut count: impl FnMut(Asked<'_>) -> Result<Vec<i32>, E>,
    ) -> Result<(), E> {
        for (at, points) in self.points.chunks(slice).enumerate() {
            let on_face = self.on_face.and_then(|faces| faces.get(at * slice..)?.get(..points.len()));
            let part = Asked { points, on_face, ..*self };
            depths.extend(part.count(&mut count)?);
        }
        Ok(())
    }

    /// The depths of the points, each lifted towards each light.
    fn count<E>(&self, count: &mut impl FnMut(Asked<'_>) -> Result<Vec<i32>, E>) -> Result<Vec<i32>, E> {
        let Some(lift) = self.lift else { return count(*self) };
        let mut depths = vec![0; self.points.len() * self.lights.len()];
        for (at, light) in self.lights.iter().enumerate() {
            let points: Vec<_> = self.points.iter().map(|&point| light.lift(point, lift)).collect();
            let found = count(Asked { points: &points, lights: slice::from_ref(light), lift: None, ..*self })?;
            for (of_point, depth) in depths.chunks_mut(self.lights.len()).zip(found) {
                of_point[at] = depth;
            }
        }
        Ok(depths)
    }

    /// Warns of pairs of point and light where rounding takes more than half of the lift.
    pub(super) fn note_swallowed(&self) {
        let Some(lift) = self.lift else { return };
        let pairs = self.points.iter().flat_map(|&point| self.lights.iter().map(move |&light| (point, light)));
        let swallowed = pairs.filter(|&(point, light)| is_swallowed(point, light, lift)).count();
        if swallowed > 0 {
            note(&format!(
                "warning: --lift {lift:e} is lost, or more than half of it, in the 32-bit floats of {swallowed} of the {} pairs of point \
                 and light; lift by more, or name the faces that points are on (`on_face`)",
                self.points.len() * self.lights.len()
            ));
        }
    }
}

/// Whether rounding takes more than half of the way that a point is lifted.
fn is_swallowed(point: [f32; 3], light: Light, lift: f64) -> bool {
    if !point.iter().all(|c| c.is_finite()) {
        return false;
    }
    let p = point.map(f64::from);
    let distance = |to: [f64; 3]| (0..3).map(|axis| (to[axis] - p[axis]).powi(2)).sum::<f64>().sqrt();
    let wanted =
        if light.w == 0.0 { lift } else { lift.min(distance(light.xyz.map(|c| f64::from(c) / f64::from(light.w)))) };
    distance(light.lift(point, lift).map(f64::from)) < 0.5 * wanted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_takes_is_noticed() {
        let above = Light::point([1e6, 0.0, 8.0]);
        assert!(is_swallowed([1e6, 0.0, 3.0], above, 1e-9));
        assert!(!is_swallowed([1e6, 0.0, 3.0], above, 1e-3), "only z moves");
        assert!(is_swallowed([1e6, 0.0, 3.0], Light::directional([1.0, 0.0, 0.0]), 1e-3));
        assert!(!is_swallowed([1e6, 0.0, 3.0], Light::directional([1.0, 0.0, 0.0]), 1.0));
        assert!(!is_swallowed([1e6, 0.0, 8.0], above, 1.0), "at the light");
        assert!(!is_swallowed([f32::NAN; 3], above, 1.0));
    }

    #[test]
    fn slices_keep_the_order_of_points_lights_and_faces() {
        let points: Vec<[f32; 3]> = (0..7).map(|at| [at as f32, 0.0, 0.0]).collect();
        let lights = [Light::directional([0.0, 1.0, 0.0]), Light::directional([0.0, 0.0, 1.0])];
        let faces: Vec<u32> = (10..17).collect();
        for lift in [None, Some(2.0)] {
            let asked = Asked { points: &points, on_face: Some(&faces), lights: &lights, lift };
            let mut found = Vec::new();
            // A number of point, light and face, and of where the point was moved.
            let count = |asked: Asked<'_>| -> Result<Vec<i32>, ()> {
                let mut all = Vec::new();
                for (point, face) in asked.points.iter().zip(asked.on_face.expect("faces")) {
                    for light in asked.lights {
                        let moved = point[1] + 10.0 * point[2];
                        all.push((point[0] + 100.0 * light.xyz[2] + 1000.0 * moved) as i32 + 100_000 * *face as i32);
                    }
                }
                Ok(all)
            };
            asked.each_slice(3, &mut found, count).expect("no error");
            let moved = if lift.is_some() { [2000, 20_000] } else { [0, 0] };
            let right = (0..7)
                .flat_map(|at| [0, 1].map(|light| 1_000_000 + 100_001 * at + 100 * light + moved[light as usize]));
            assert_eq!(found, right.collect::<Vec<i32>>(), "{lift:?}");
        }
    }
}
