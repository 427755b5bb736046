//! The one list of stages and of WGSL files. Pipelines, labels, CPU references and tests use it. The top of each file
//! in `wgsl` says what its stage computes, for whom, and what it promises.

use crate::compose::{Composed, compose};

/// A stage. Its entry points, pipeline labels and CPU reference, if it has one, carry its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stage {
    /// The name, also that of a CPU reference `src/cpu/SUBJECT/NAME.rs`.
    pub name: &'static str,
    /// The name of its module. A stage with one text for a single mesh and for scenes has two modules.
    pub module: &'static str,
    /// The file of its entry points, `SUBJECT/FILE` without `.wgsl`, which may have those of other stages too.
    pub file: &'static str,
    /// The variant: names for which `#if` holds in its files.
    pub flags: &'static [&'static str],
    /// The entry points. They are the pipelines' labels.
    pub entry_points: &'static [&'static str],
}

/// Lists stages: `STAGE = SUBJECT / NAME`, with `in FILE` if the file has another name, for a variant `as MODULE if
/// FLAG`, and entry points that have other names than the stage.
macro_rules! stages {
    ($(#[$doc:meta])* $list:ident: $($stage:ident = $subject:ident / $name:ident $(in $file:ident)? $(as $module:ident if $flag:ident)?
        $(: $($entry:ident),+)?;)*) => {
        $(
            #[doc = concat!("The stage `", stringify!($name), "`.")]
            pub const $stage: Stage = Stage {
                name: stringify!($name),
                // The first of each list counts. The last is the default: the name of the stage.
                module: [$(stringify!($module),)? stringify!($name)][0],
                file: [
                    $(concat!(stringify!($subject), "/", stringify!($file)),)?
                    concat!(stringify!($subject), "/", stringify!($name)),
                ][0],
                flags: &[$(stringify!($flag))?],
                entry_points: [$(&[$(stringify!($entry)),+] as &[&str],)? &[stringify!($name)]][0],
            };
        )*
        $(#[$doc])*
        pub const $list: &[Stage] = &[$($stage),*];
    };
}

stages! {
    /// Every stage that is dispatched, in the order of the data flow.
    STAGES:
    NEEDS = scene / needs;
    DEFORM = deform / deform;
    FACING = extract / facing;
    EXACT_FACING = extract / exact_facing;
    POLYGON_FACING = polygon / polygon_facing;
    POLYGON_TURNS = polygon / polygon_turns in polygon_facing;
    POLYGON_PAIRS = polygon / polygon_pairs;
    POLYGON_MASKS = polygon / polygon_masks in polygon_facing;
    EDGES = extract / edges;
    CUT_EDGES = polygon / cut_edges: cut_edges, cut_edges_rank, cut_edges_before, cut_edges_list;
    CUT_QUADS = polygon / cut_quads in list_pieces;
    PER_EDGE = extract / per_edge;
    COMPACT = extract / compact: compact_count, compact_scan, compact_scatter;
    ARGUMENTS = extract / arguments in compact;
    CULL_LIGHTS = scene / cull_lights;
    CLUSTERS = scene / clusters;
    CHUNKS = scene / chunks in clusters;
    SCENE_FACING = extract / facing as scene_facing if SCENE;
    SCENE_EXACT_FACING = extract / exact_facing as scene_exact_facing if SCENE;
    SCENE_EDGES = extract / edges as scene_edges if SCENE;
    RECEIVER_DEPTH = shadow / receiver_depth in receiver_pyramid;
    RECEIVER_SAMPLES = shadow / receiver_depth in receiver_pyramid as receiver_samples if SAMPLES;
    RECEIVER_PYRAMID = shadow / receiver_pyramid;
    RELIST = shadow / relist;
    BOUNDS = shadow / bounds;
    COUNTING_METHODS = shadow / counting_methods;
    ZP_PLUS_2005_CASES = shadow / zp_plus_2005_cases;
    CAPS = shadow / caps;
    LIST_SIDES = shadow / list_sides as list_sides if STATISTICS_READ;
    SHADOW_ARGUMENTS = shadow / shadow_arguments;
    PIECE_ARGUMENTS = shadow / piece_arguments in shadow_arguments;
    STENCIL_PENCIL = shadow / stencil_pencil;
    STENCIL_CROSSINGS = shadow / stencil_crossings;
    PIECE_CROSSINGS = shadow / piece_crossings in stencil_crossings;
    STENCIL_BOUND = shadow / stencil_bound;
    SHADOW_BOXES = query / shadow_boxes;
    SHADOW_DEPTH = query / shadow_depth;
    DEPTH_ARGUMENTS = query / depth_arguments in exact_shadow_depth;
    EXACT_SHADOW_DEPTH = query / exact_shadow_depth: exact_shadow_depth, exact_shadow_depth_recount;
    DEPTH_NEAR = depth_map / depth_near;
    DEPTH_NEAR_WALLS = depth_map / depth_near_walls in depth_near;
    DEPTH_METRIC = depth_map / depth_metric in converted_maps;
    DEPTH_MERGE = depth_map / depth_merge in converted_maps;
    DEPTH_CUBE = depth_map / depth_cube in converted_maps;
    DEPTH_EDGES = depth_map / depth_edges: depth_edges_mark, depth_edges_continue, depth_edges_count;
    DEPTH_CELLS = depth_map / depth_cells: depth_cells_count, depth_cells_scan, depth_cells_list;
    CONTOUR_MARKS = depth_map / contour_marks;
    CONTOUR_TILES = depth_map / contour_tiles: contour_tiles_find, contour_tiles_list;
    CONTOUR_CROSSINGS = depth_map / contour_crossings;
    CONTOUR_WALLS = depth_map / contour_walls: contour_walls_trace, contour_walls_scan;
}

stages! {
    /// The stages of draws.
    DRAWN:
    SIDES = shadow / sides: side, side_clipped, zp_plus_2005_side;
    CAP_FACES = shadow / cap_faces: light_cap, seen_light_cap, dark_cap, near_cap, zp_plus_2005_cap;
    PIECE_VOLUMES = shadow / piece_volumes: piece_side, piece_side_clipped, piece_near_cap, piece_light_cap, piece_dark_cap;
    DEPTH_SURFACE = depth_map / depth_surface in surface: depth_surface, depth_near_cap;
    DEPTH_WALLS = depth_map / depth_walls;
    MESH_DEPTH = depth_map / mesh_depth: mesh_depth, scene_depth;
    OUTLINE_EDGES = outline / outline_edges: outline_silhouette, outline_feature;
    SCENE_OUTLINE_EDGES = outline / outline_edges as scene_outline_edges if SCENE: outline_silhouette, outline_feature;
    SHADOW_MASKS = mask / shadow_masks: mask_whole;
}

/// Lists files by folder and name.
macro_rules! files {
    ($($folder:ident: $($name:ident),+;)*) => {
        &[$($((
            concat!(stringify!($folder), "/", stringify!($name)),
            include_str!(concat!("../wgsl/", stringify!($folder), "/", stringify!($name), ".wgsl")),
        ),)+)*]
    };
}

/// Every WGSL file: its name without `.wgsl`, and its text.
pub const FILES: &[(&str, &str)] = files! {
    common: casters, determinant, exact_sign, extraction, order_keys, positions;
    deform: deform, displace;
    depth_map: cell_words, contour, contour_crossings, contour_marks, contour_rim, contour_tiles, contour_walls,
        converted_maps, depth_cells, depth_edges, depth_near, depth_walls, edge_code, edge_rule, edge_strips, mesh_depth,
        samples, scan, surface;
    extract: compact, edge_lists, edges, exact_facing, facing, one_caster, per_edge, results;
    interface: caster, outlined;
    mask: shadow_masks;
    outline: mesh_edges, outline_edges, scene_edges;
    polygon: boundaries, corner_turn, cut_edges, cuts, list_pieces, polygon_facing, polygon_pairs;
    query: exact_shadow_depth, records, shadow_boxes, shadow_depth, shadow_pairs, shadow_segments;
    scene: clusters, cull_lights, listed_chunks, many_casters, needs, table;
    shadow: bounds, cap_faces, caps, caster, choices, counting_methods, culling, draw_lists, half_plane_bins,
        list_sides, piece_volumes, receiver_pyramid, receivers, relist, shadow, shadow_arguments, sides, stencil_bound,
        stencil_crossings, stencil_pencil, vertices, zp_plus_2005_cases;
};

/// The text of a file. In builds with debug assertions the variable `RIMLINE_WGSL` may name a folder
/// that is read instead of what was compiled in.
pub fn source(name: &str) -> Option<&'static str> {
    #[cfg(debug_assertions)]
    if let Some(folder) = std::env::var_os("RIMLINE_WGSL") {
        let text = std::fs::read_to_string(std::path::Path::new(&folder).join(format!("{name}.wgsl")));
        return text.ok().map(|text| &*text.leak());
    }
    FILES.iter().find(|(file, _)| *file == name).map(|&(_, text)| text)
}

/// [`OUTLINE_EDGES`] for depth that has several samples a pixel.
pub const OUTLINE_SAMPLES: Stage = Stage { module: "outline_samples", flags: &["SAMPLES"], ..OUTLINE_EDGES };

/// [`SCENE_OUTLINE_EDGES`] for depth that has several samples a pixel.
pub const SCENE_OUTLINE_SAMPLES: Stage =
    Stage { module: "scene_outline_samples", flags: &["SCENE", "SAMPLES"], ..SCENE_OUTLINE_EDGES };

/// [`SHADOW_MASKS`] for depth that has several samples a pixel.
pub const MASK_SAMPLES: Stage = Stage { module: "mask_samples", flags: &["SAMPLES"], ..SHADOW_MASKS };

/// [`DEFORM`] without its `displace`, which a caller gives.
pub const DISPLACED_DEFORM: Stage = Stage { module: "displaced_deform", flags: &["DISPLACED"], ..DEFORM };

impl Stage {
    /// The stage's module.
    ///
    /// # Errors
    /// A message names the file that cannot be read or composed.
    pub fn composed(&self) -> Result<Composed, String> {
        self.composed_for("")
    }

    /// The stage's module, and everything that `further` names. A caller puts `further` into the module.
    ///
    /// # Errors
    /// A message names the file that cannot be read or composed.
    pub fn composed_for(&self, further: &str) -> Result<Composed, String> {
        let mut composed = compose(self.file, self.flags, self.entry_points, further, &source)?;
        // The include's bind group, where a stage imports the include.
        composed.wgsl = composed.wgsl.replace("@group(GROUP)", "@group(0)");
        Ok(composed)
    }

    /// The WGSL of the stage's module. Text that cannot be composed, which tests rule out, gives a message that no
    /// compiler takes for WGSL.
    pub fn wgsl(&self) -> String {
        self.composed().map_or_else(|message| message, |composed| composed.wgsl)
    }
}
