//! Options of the picture.

/// How shadow volumes are counted, as `rimline shadow --method` has it.
pub use rimline::Counting;
use rimline_picture::Mode;

use super::keys::Action;

/// Overlays of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct Overlays {
    /// Outlines as the eye sees them.
    pub silhouettes: bool,
    /// Silhouettes as each light sees them, in its colour.
    pub light_silhouettes: bool,
    /// Sides of the shadow volumes.
    pub volumes: bool,
    /// Faces that cast: the light caps of the volumes. Dark caps lie where the sides end, mostly at infinity, so they have no
    /// overlay.
    pub caps: bool,
    /// Edges of one face.
    pub boundary: bool,
    /// Edges of more than two faces, and of faces that run opposite ways.
    pub non_manifold: bool,
    /// Edges between faces that meet at more than 33°.
    pub creases: bool,
    /// Edges of faces whose side some light leaves to exact arithmetic.
    pub exact: bool,
    /// Edges between clusters, groups of faces that the library decides at once in models that cannot deform. Models in the
    /// viewer can, so these clusters are made for the overlay, from the pose in which it was switched on.
    pub clusters: bool,
    /// The farthest receiver of each tile of 8 × 8 pixels, in bands of its distance: shadows behind it are culled by receivers.
    pub receivers: bool,
    /// The boxes of the models.
    pub boxes: bool,
}

impl Overlays {
    /// Whether any of them needs an extraction of its own.
    pub fn needs_edges(&self) -> bool {
        *self != self.without_edges()
    }

    /// Only those that need none.
    pub(crate) fn without_edges(self) -> Self {
        Self { caps: self.caps, receivers: self.receivers, boxes: self.boxes, ..Self::default() }
    }
}

/// Levels of skipping. The picture is the same without them, and takes longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct Skipping {
    /// Casters out of a light's range or cone.
    pub range: bool,
    /// Shadows out of sight.
    pub view: bool,
    /// Shadows that fall on nothing that is seen.
    pub receivers: bool,
    /// Deforming casters that neither the picture nor a shadow in it needs.
    pub casters: bool,
    /// Facing bits of what did not change.
    pub bits: bool,
    /// Lists of what did not change.
    pub lists: bool,
    /// Front-facing faces of casters, where the back-facing ones suffice.
    pub faces: bool,
}

impl Default for Skipping {
    fn default() -> Self {
        Self { range: true, view: true, receivers: true, casters: true, bits: true, lists: true, faces: true }
    }
}

/// All options.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct Options {
    /// How shadow volumes are counted.
    pub counting: Counting,
    /// How shadows are drawn.
    pub mode: Mode,
    /// Whether faces are shaded as one smooth surface where they meet at small angles; else each is flat.
    pub smooth: bool,
    /// Whether models have their base colours; else they are of clay.
    pub colors: bool,
    /// Whether there is a ground that receives shadows.
    pub ground: bool,
    /// Whether models throw shadows.
    pub shadows: bool,
    /// Overlays of the picture.
    pub overlays: Overlays,
    /// Work that is left out because no picture needs it.
    pub skipping: Skipping,
    /// Whether the stages are timed by the device.
    pub timing: bool,
    /// Samples of each pixel: 4, or 1 for speed. Software devices take one while something moves, and OpenGL always.
    pub samples: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            counting: Counting::Auto,
            mode: Mode::default(),
            smooth: true,
            colors: true,
            ground: true,
            shadows: true,
            overlays: Overlays::default(),
            skipping: Skipping::default(),
            timing: false,
            samples: 4,
        }
    }
}

/// A switch of the options: the action that turns it over, what the panel calls it, and where it is.
pub(crate) type Switch = (Action, &'static str, fn(&mut Options) -> &mut bool);

/// All switches, in the order of the panel.
pub(crate) const SWITCHES: [Switch; 15] = [
    (Action::Silhouettes, "silhouettes", |options| &mut options.overlays.silhouettes),
    (Action::LightSilhouettes, "of the lights", |options| &mut options.overlays.light_silhouettes),
    (Action::Volumes, "volumes", |options| &mut options.overlays.volumes),
    (Action::Caps, "light caps", |options| &mut options.overlays.caps),
    (Action::Boundary, "boundary", |options| &mut options.overlays.boundary),
    (Action::NonManifold, "non-manifold", |options| &mut options.overlays.non_manifold),
    (Action::Creases, "creases", |options| &mut options.overlays.creases),
    (Action::Exact, "decided exactly", |options| &mut options.overlays.exact),
    (Action::Clusters, "clusters", |options| &mut options.overlays.clusters),
    (Action::Receivers, "receivers", |options| &mut options.overlays.receivers),
    (Action::Boxes, "boxes", |options| &mut options.overlays.boxes),
    (Action::Ground, "ground", |options| &mut options.ground),
    (Action::Shadows, "shadows", |options| &mut options.shadows),
    (Action::Smooth, "smooth", |options| &mut options.smooth),
    (Action::Colors, "base colours", |options| &mut options.colors),
];

/// Counting methods that can be chosen, with the names that the command gives them.
pub(crate) const COUNTINGS: [(Counting, &str); 5] = [
    (Counting::Auto, "auto"),
    (Counting::ZpPlus, "zp+"),
    (Counting::ZpPlus2005, "zp+paper"),
    (Counting::ZFail, "z-fail"),
    (Counting::ZPass, "z-pass"),
];

/// The name that the command gives a counting method.
pub(crate) fn counting_name(counting: Counting) -> &'static str {
    COUNTINGS.iter().find(|(of, _)| *of == counting).map_or("auto", |(_, name)| name)
}
