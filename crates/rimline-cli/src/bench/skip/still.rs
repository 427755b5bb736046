//! Figures in a cube among which nothing moves.

use super::super::casters::field::{CasterMesh, Field};
use super::setting::{Casters, Setting};

pub(super) fn setting(casters: usize) -> Setting {
    let Field { shape, places, lights, camera, .. } = Field::new(CasterMesh::Figure.shape(), casters);
    let placed: Vec<_> = places.iter().map(|place| (0, Field::transform(place))).collect();
    let pairs_in_range = placed.len() * lights.len();
    Setting {
        casters: Casters::Rigid { shapes: vec![shape], placed },
        lights,
        camera,
        ground: None,
        turn: 0.0,
        drift: 0.0,
        pairs_in_range,
    }
}
