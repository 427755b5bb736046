//! The outermost of many points: those that a picture's frame hangs on.

use glam::DVec3;

/// How many directions are looked in, beside the axes and the diagonals.
const DIRECTIONS: u32 = 128;

/// Finds, for each of many directions, the point that lies farthest that way from `centre`. The points come in no
/// meaningful order, are never many, and include those that define the bounds. Other points lie outside of their hull
/// by at most about a hundredth of the size of all points.
pub(crate) fn outermost(points: &[[f32; 3]], centre: [f32; 3]) -> Vec<[f32; 3]> {
    let centre = DVec3::from(centre.map(f64::from));
    let directions: Vec<DVec3> = directions().collect();
    let mut farthest = vec![(f64::NEG_INFINITY, None); directions.len()];
    for &point in points {
        let from_centre = DVec3::from(point.map(f64::from)) - centre;
        for (direction, (most, found)) in directions.iter().zip(&mut farthest) {
            let height = direction.dot(from_centre);
            if height > *most {
                (*most, *found) = (height, Some(point));
            }
        }
    }
    let mut found: Vec<[f32; 3]> = farthest.into_iter().filter_map(|(_, found)| found).collect();
    found.sort_unstable_by_key(|point| point.map(f32::to_bits));
    found.dedup();
    found
}

/// The axes, the diagonals, and directions that are spread evenly in a spiral.
fn directions() -> impl Iterator<Item = DVec3> {
    let sides = [-1.0, 0.0, 1.0];
    let grid = sides.into_iter().flat_map(move |x| sides.into_iter().map(move |y| (x, y)));
    let grid = grid.flat_map(move |(x, y)| sides.into_iter().map(move |z| DVec3::new(x, y, z)));
    let spiral = (0..DIRECTIONS).map(|number| {
        let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let y = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(DIRECTIONS);
        let (sine, cosine) = (f64::from(number) * golden_angle).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        DVec3::new(radius * cosine, y, radius * sine)
    });
    grid.filter(|direction| *direction != DVec3::ZERO).chain(spiral)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::bounds::Bounds;

    #[test]
    fn few_points_hold_the_rest() {
        // Points all over a ball.
        let ball: Vec<[f32; 3]> = (0..20_000)
            .map(|number: u32| {
                let t = f64::from(number) / 20_000.0;
                let (sine, cosine) = (f64::from(number) * 2.4).sin_cos();
                let radius = 2.0 * (t * (1.0 - t)).sqrt();
                [radius * cosine, 1.0 - 2.0 * t, radius * sine].map(|c| (100.0 + 3.0 * c) as f32)
            })
            .collect();
        let few = outermost(&ball, [100.0; 3]);
        assert!(few.len() <= DIRECTIONS as usize + 26, "{} are left", few.len());
        assert_eq!(Bounds::of(&few), Bounds::of(&ball));
        for degrees in 0..360 {
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let direction = DVec3::new(cosine, 0.3 * sine, sine).normalize();
            let height = |p: &[f32; 3]| direction.dot(DVec3::from(p.map(f64::from)) - 100.0);
            let most = |points: &[[f32; 3]]| points.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
            assert!(most(&few) > 0.97 * most(&ball), "{degrees}: {} of {}", most(&few), most(&ball));
        }
    }

    #[test]
    fn a_box_keeps_its_corners() {
        let corners: Vec<[f32; 3]> = (0..8_u32).map(|n| [n & 1, n >> 1 & 1, n >> 2].map(|c| c as f32)).collect();
        assert_eq!(outermost(&corners, [0.5; 3]).len(), 8);
        assert!(outermost(&[], [0.0; 3]).is_empty());
    }
}
