//! Scenes that are hard on floating-point arithmetic, made by code: by name and size, the same bits on every platform.
//! Tests, benches and the report of run time against error go through them.
//!
//! ```
//! let scene = rimline_bench::stress::scene("translation-1e6", 2000).expect("a name of `stress::names`");
//! let (mesh, lights) = (scene.mesh()?, scene.lights(8));
//! # Ok::<(), rimline::MeshError>(())
//! ```

use crate::shapes::Shape;
use rimline::Light;
use rimline::mesh::{Mesh, MeshError, Weld};

mod bodies;
mod lights;

use bodies::{moved, scaled, stretched};
use lights::Placing;

/// A mesh whose facing is hard to decide, and where its lights are.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the scene for [`scene`], such as `translation-1e6`.
    pub name: &'static str,
    pub class: &'static str,
    pub positions: Vec<[f32; 3]>,
    /// Triangles, as indices into `positions`. Some scenes have faces without area, or several at one position.
    pub faces: Vec<[u32; 3]>,
    placing: Placing,
}

impl Scene {
    /// The scene's faces and edge records, vertices at the same position welded; to be used with `positions` as they are.
    pub fn mesh(&self) -> Result<Mesh, MeshError> {
        Mesh::new(&self.positions, &self.faces, Weld::Position)
    }

    /// The scene's first `count` lights: points, directions and other weights. All are finite, none is all zeros.
    pub fn lights(&self, count: usize) -> Vec<Light> {
        (0..count).map(|index| self.placing.light(self, index)).collect()
    }

    fn new(shape: Shape, placing: Placing) -> Self {
        Self { name: "", class: "", positions: shape.positions, faces: shape.faces, placing }
    }
}

/// Every scene with about `faces` faces, in the order of [`names`].
pub fn scenes(faces: usize) -> impl ExactSizeIterator<Item = Scene> {
    SCENES.iter().map(move |entry| entry.scene(faces))
}

/// One scene with about `faces` faces, as many as come out even and at least as many as the scene needs; `None` for a
/// name that [`names`] lacks.
pub fn scene(name: &str, faces: usize) -> Option<Scene> {
    SCENES.iter().find(|entry| entry.name == name).map(|entry| entry.scene(faces))
}

/// The names of all scenes, those of a class side by side, milder ones first.
pub fn names() -> impl ExactSizeIterator<Item = &'static str> {
    SCENES.iter().map(|entry| entry.name)
}

struct Entry {
    class: &'static str,
    name: &'static str,
    make: fn(usize) -> Scene,
}

impl Entry {
    fn scene(&self, faces: usize) -> Scene {
        Scene { name: self.name, class: self.class, ..(self.make)(faces) }
    }
}

/// Declares [`SCENES`]: classes, and how a scene of a number of faces is made. Some are of degrees, which end their names.
macro_rules! scenes {
    ($($class:literal {
        $(each $degrees:ident $prefix:literal: $($degree:literal)+,)*
        $($name:literal: $make:expr,)*
    })*) => {
        const SCENES: &[Entry] = &[$(
            $($(Entry {
                class: $class,
                name: concat!($prefix, stringify!($degree)),
                make: |faces| $degrees(faces, $degree),
            },)+)*
            $(Entry { class: $class, name: $name, make: $make },)*
        )*];
    };
}

scenes! {
    // Far from the origin, where neighbouring floats lie far apart.
    "translation" { each translated "translation-": 1e0 1e1 1e2 1e3 1e4 1e5 1e6 1e7, }
    // Where determinants underflow and overflow.
    "scale" { each scaled_body "scale-": 1e-30 1e-20 1e-10 1e0 1e10 1e20 1e30, }
    "subnormal" {
        "subnormal-thickness": |faces| flattened(faces, 1e-39),
        "subnormal-body": |faces| scaled_body(faces, 1e-39),
        "subnormal-last-bits": |faces| scaled_body(faces, 1e-43),
    }
    // The longest edge is so many times the height above it.
    "slivers" {
        each slivers "slivers-": 1e2 1e4 1e6 1e8,
        each needles "needles-": 1e2 1e4 1e6 1e8,
    }
    // Lights in the plane of all faces: some of the lights or all, and the positions rounded or exactly on a plane.
    "plate" {
        "plate-third": |faces| Scene::new(bodies::tilted_plate(faces), Placing::OnTilted { every: 3 }),
        "plate-all": |faces| Scene::new(bodies::tilted_plate(faces), Placing::OnTilted { every: 1 }),
        "plate-lattice-third": |faces| Scene::new(bodies::lattice_plate(faces), Placing::OnLattice { every: 3 }),
        "plate-lattice-all": |faces| Scene::new(bodies::lattice_plate(faces), Placing::OnLattice { every: 1 }),
    }
    "lights" {
        "lights-inside": |faces| Scene::new(bodies::blob(faces), Placing::around(0.3)),
        "lights-in-planes": |faces| Scene::new(bodies::lattice_box(faces, 0), Placing::InFacePlanes),
        "lights-on-vertices": |faces| Scene::new(bodies::blob(faces), Placing::OnVertices),
        "lights-on-edges": |faces| Scene::new(bodies::blob(faces), Placing::OnEdges),
        "lights-on-faces": |faces| Scene::new(bodies::blob(faces), Placing::OnFaces),
        "lights-of-any-weight": |faces| Scene::new(bodies::blob(faces), Placing::AnyWeight),
        "lights-1e-20": |faces| Scene::new(bodies::through_origin(faces), Placing::around(1e-20)),
        "lights-1e20": |faces| Scene::new(bodies::blob(faces), Placing::around(1e20)),
    }
    // A sphere so far from lights about the origin, as from eyes.
    "afar" { each afar "afar-": 1e2 1e4 1e6, }
    // A limb, bent until it folds into itself.
    "bent" { each bent "bent-": 60 120 150 179, }
    // A plate with lights in its plane, each vertex moved off it at random, by up to so much.
    "noise" { each rough "noise-": 1e-2 1e-4 1e-6 1e-8, }
    // Faults that a modelling program should have refused.
    "topology" {
        "degenerate-faces": |faces| Scene::new(bodies::with_degenerate_faces(faces), Placing::around(3.0)),
        "touching-boxes": |faces| Scene::new(bodies::touching_boxes(faces), Placing::InFacePlanes),
        "moebius-strip": |faces| Scene::new(bodies::moebius(faces), Placing::around(3.0)),
        "three-sheets": |faces| Scene::new(bodies::three_sheets(faces), Placing::around(3.0)),
    }
}

/// A body of radius 8 or so, moved by as much on every axis, its lights with it.
fn translated(faces: usize, by: f32) -> Scene {
    let body = scaled(bodies::blob(faces), 8.0);
    Scene::new(moved(body, [by; 3]), Placing::Around { centre: [by; 3], radius: 20.0 })
}

fn scaled_body(faces: usize, scale: f32) -> Scene {
    Scene::new(scaled(bodies::blob(faces), scale), Placing::around(2.5 * scale))
}

/// A body of unit size and a thickness of `thickness`.
fn flattened(faces: usize, thickness: f32) -> Scene {
    let body = stretched(bodies::blob(faces), [1.0, thickness, 1.0]);
    Scene::new(body, Placing::Flat { thickness, radius: 2.5 })
}

fn afar(faces: usize, distance: f32) -> Scene {
    let centre = [0.8, 0.2, -0.6].map(|c| c * distance);
    Scene::new(moved(bodies::sphere(faces), centre), Placing::around(1.0))
}

fn bent(faces: usize, degrees: u32) -> Scene {
    Scene::new(bodies::bent_limb(faces, degrees), Placing::around(4.0))
}

fn rough(faces: usize, amplitude: f32) -> Scene {
    Scene::new(bodies::rough_plate(faces, amplitude), Placing::OnTilted { every: 1 })
}

fn slivers(faces: usize, aspect: f32) -> Scene {
    Scene::new(bodies::slivers(faces, aspect), Placing::around(3.0))
}

fn needles(faces: usize, aspect: f32) -> Scene {
    Scene::new(bodies::needle(faces, aspect), Placing::around(3.0))
}
