//! The one list of stages: name, WGSL, entry points. Pipelines, labels, twins and tests use it.

/// A stage. Its WGSL file, pipeline label and CPU twin carry its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// The name, also that of `wgsl/SUBJECT/NAME.wgsl` and `src/cpu/SUBJECT/NAME.rs`.
    pub name: &'static str,
    /// The WGSL files that make up its module, in order: name and text.
    pub files: &'static [(&'static str, &'static str)],
    /// The compute entry points. They are the pipelines' labels.
    pub entry_points: &'static [&'static str],
}

macro_rules! files {
    ($($name:literal),*) => { &[$(($name, include_str!(concat!("../wgsl/", $name, ".wgsl")))),*] };
}

/// Computes morph targets, skins and displacement: mesh space to world space.
pub const DEFORM: Stage =
    Stage { name: "deform", files: files!["common/common", "deform/deform"], entry_points: &["deform"] };
/// Computes facing masks, and lists undecided faces.
pub const FACING: Stage = Stage {
    name: "facing",
    files: files![
        "common/common",
        "extract/one_caster",
        "extract/one_item",
        "common/positions",
        "common/determinant",
        "common/filter",
        "extract/facing"
    ],
    entry_points: &["facing"],
};
/// Decides the faces that the facing stage left undecided, exactly.
pub const EXACT_FACING: Stage = Stage {
    name: "exact_facing",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "extract/exact_facing"
    ],
    entry_points: &["exact_facing"],
};
/// Computes silhouette and winding masks from facing masks, and unordered lists.
pub const EDGES: Stage = Stage {
    name: "edges",
    files: files![
        "common/common",
        "extract/one_caster",
        "extract/one_item",
        "extract/facing_windows",
        "extract/emit",
        "extract/edges"
    ],
    entry_points: &["edges"],
};
/// Computes facing masks of quadrilaterals and triangles whose corners all turn alike, and lists the other polygons.
pub const POLYGON_FACING: Stage = Stage {
    name: "polygon_facing",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "common/filter",
        "polygon/outlines",
        "polygon/quads",
        "polygon/polygon_facing"
    ],
    entry_points: &["polygon_facing"],
};
/// Decides quadrilaterals and convex outlines by their turns, and lists the other polygons.
pub const POLYGON_TURNS: Stage = Stage {
    name: "polygon_turns",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "common/filter",
        "polygon/outlines",
        "polygon/quads",
        "polygon/polygon_turns"
    ],
    entry_points: &["polygon_turns"],
};
/// Finds how lights see the outlines that are left, by all pairs of their edges.
pub const OUTLINE: Stage = Stage {
    name: "outline",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "polygon/outlines",
        "polygon/places",
        "polygon/turn",
        "polygon/work",
        "polygon/outline"
    ],
    entry_points: &["outline"],
};
/// Decides the masks of these polygons.
pub const POLYGON_MASKS: Stage = Stage {
    name: "polygon_masks",
    files: files!["common/common", "extract/one_caster", "polygon/outlines", "polygon/polygon_masks"],
    entry_points: &["polygon_masks"],
};
/// Finds the border of what L-twisted polygons darken.
pub const CUT_EDGES: Stage = Stage {
    name: "cut_edges",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "polygon/outlines",
        "polygon/places",
        "polygon/turn",
        "polygon/turn_value",
        "polygon/work",
        "polygon/list_pieces",
        "polygon/cuts",
        "polygon/cut_order",
        "polygon/cut_edges"
    ],
    entry_points: &["cut_edges", "cut_edges_rank", "cut_edges_before", "cut_edges_list"],
};
/// Finds that of quadrilaterals of which no sign is in doubt.
pub const CUT_QUADS: Stage = Stage {
    name: "cut_quads",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "polygon/outlines",
        "polygon/places",
        "polygon/list_pieces",
        "polygon/cut_quads"
    ],
    entry_points: &["cut_quads"],
};
/// Computes the same from positions, as published in 2003.
pub const PER_EDGE: Stage = Stage {
    name: "per_edge",
    files: files![
        "common/common",
        "extract/one_caster",
        "common/positions",
        "common/determinant",
        "extract/emit",
        "extract/per_edge"
    ],
    entry_points: &["per_edge"],
};
/// Makes ordered lists from masks.
pub const COMPACT: Stage = Stage {
    name: "compact",
    files: files!["common/common", "extract/compact"],
    entry_points: &["compact_count", "compact_scan", "compact_scatter"],
};
/// Computes indirect draw arguments from counts.
pub const ARGUMENTS: Stage =
    Stage { name: "arguments", files: files!["common/common", "extract/arguments"], entry_points: &["arguments"] };
/// Finds the figures of a scene that a frame needs, before they are deformed.
pub const NEEDS: Stage = Stage {
    name: "needs",
    files: files!["common/common", "common/cone", "shadow/shadow", "shadow/pyramid", "shadow/seen", "scene/needs"],
    entry_points: &["needs"],
};
/// Finds the lights that matter to each caster of a scene.
pub const REACH: Stage = Stage {
    name: "reach",
    files: files!["common/common", "common/cone", "scene/table", "scene/occluded", "scene/reach"],
    entry_points: &["reach"],
};
/// Decides clusters of faces of the casters of a scene as wholes, and lists the chunks of faces that are left.
pub const CLUSTERS: Stage = Stage {
    name: "clusters",
    files: files!["common/common", "scene/table", "scene/many_casters", "scene/cluster_words", "scene/clusters"],
    entry_points: &["clusters"],
};
/// Lists the chunks of edges of the casters of a scene that lights reach.
pub const CHUNKS: Stage = Stage {
    name: "chunks",
    files: files!["common/common", "scene/table", "scene/cluster_words", "scene/chunks"],
    entry_points: &["chunks"],
};
/// [`FACING`] for the casters of a scene.
pub const SCENE_FACING: Stage = Stage {
    files: files![
        "common/common",
        "scene/table",
        "scene/many_casters",
        "scene/listed_faces",
        "scene/caster_positions",
        "common/determinant",
        "common/filter",
        "extract/facing"
    ],
    ..FACING
};
/// [`EXACT_FACING`] for the casters of a scene.
pub const SCENE_EXACT_FACING: Stage = Stage {
    files: files![
        "common/common",
        "scene/table",
        "scene/many_casters",
        "scene/caster_positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "extract/exact_facing"
    ],
    ..EXACT_FACING
};
/// [`EDGES`] for the casters of a scene.
pub const SCENE_EDGES: Stage = Stage {
    files: files![
        "common/common",
        "scene/table",
        "scene/many_casters",
        "scene/listed_edges",
        "scene/scene_lists",
        "extract/edges"
    ],
    ..EDGES
};
/// Computes the bounding box of a caster.
pub const BOUNDS: Stage = Stage {
    name: "bounds",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/choices",
        "shadow/caster",
        "shadow/positions",
        "shadow/bounds"
    ],
    entry_points: &["bounds"],
};
/// Finds the farthest receivers of the tiles of a picture.
pub const RECEIVER_DEPTH: Stage = Stage {
    name: "receiver_depth",
    files: files!["shadow/receivers", "shadow/receiver_tiles", "shadow/receiver_depth"],
    entry_points: &["receiver_depth"],
};
/// [`RECEIVER_DEPTH`] of several samples for each pixel.
pub const RECEIVER_SAMPLES: Stage = Stage {
    name: "receiver_samples",
    files: files!["shadow/receivers", "shadow/receiver_tiles", "shadow/receiver_samples"],
    entry_points: &["receiver_samples"],
};
/// Finds the farthest receivers of larger cells, and the box of all.
pub const RECEIVER_PYRAMID: Stage = Stage {
    name: "receiver_pyramid",
    files: files!["shadow/receivers", "shadow/receiver_pyramid"],
    entry_points: &["receiver_pyramid"],
};
/// Finds the lists for a view that are made anew.
pub const RELIST: Stage = Stage {
    name: "relist",
    files: files!["common/common", "shadow/shadow", "shadow/choices", "shadow/relist"],
    entry_points: &["relist"],
};
/// Chooses the faces that cast and the counting method.
pub const CHOOSE: Stage = Stage {
    name: "choose",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/pyramid",
        "shadow/choices",
        "shadow/caster",
        "shadow/boxes",
        "shadow/seen",
        "shadow/receivers",
        "shadow/hidden",
        "shadow/choose"
    ],
    entry_points: &["choose"],
};
/// Finds the lights for which ZP+ as published changes to z-fail.
pub const ZP_PLUS_2005_CASES: Stage = Stage {
    name: "zp_plus_2005_cases",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/zp_plus_2005",
        "shadow/choices",
        "shadow/caster",
        "shadow/positions",
        "shadow/zp_plus_2005_cases"
    ],
    entry_points: &["zp_plus_2005_cases"],
};
/// Finds the pencils of half planes that bound stencil counts.
pub const STENCIL_PENCIL: Stage = Stage {
    name: "stencil_pencil",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/choices",
        "shadow/caster",
        "shadow/chosen",
        "shadow/boxes",
        "shadow/world",
        "shadow/pencil",
        "shadow/stencil_pencil"
    ],
    entry_points: &["stencil_pencil"],
};
/// Adds sides to the half planes that they cross.
pub const STENCIL_CROSSINGS: Stage = Stage {
    name: "stencil_crossings",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/choices",
        "shadow/caster",
        "shadow/positions",
        "shadow/chosen",
        "shadow/side_lists",
        "shadow/boxes",
        "shadow/world",
        "shadow/pencil",
        "shadow/crossings",
        "shadow/stencil_crossings"
    ],
    entry_points: &["stencil_crossings"],
};
/// Adds the sides of pieces to the half planes that they cross.
pub const PIECE_CROSSINGS: Stage = Stage {
    name: "piece_crossings",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/choices",
        "shadow/caster",
        "shadow/chosen",
        "shadow/boxes",
        "shadow/world",
        "shadow/pencil",
        "shadow/crossings",
        "shadow/piece_lists",
        "shadow/piece_crossings"
    ],
    entry_points: &["piece_crossings"],
};
/// Computes upper bounds of the stencil counts.
pub const STENCIL_BOUND: Stage = Stage {
    name: "stencil_bound",
    files: files!["common/common", "shadow/shadow", "shadow/pencil", "shadow/stencil_bound"],
    entry_points: &["stencil_bound"],
};
/// Lists the faces that caps are drawn from.
pub const CAPS: Stage = Stage {
    name: "caps",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/pyramid",
        "shadow/casting",
        "shadow/choices",
        "shadow/caster",
        "shadow/positions",
        "shadow/caps"
    ],
    entry_points: &["caps"],
};
/// Computes the indirect draw arguments of shadow volumes.
pub const SHADOW_ARGUMENTS: Stage = Stage {
    name: "shadow_arguments",
    files: files!["common/common", "shadow/shadow", "shadow/shadow_arguments"],
    entry_points: &["shadow_arguments"],
};
/// Computes the indirect draw arguments of the pieces of L-twisted polygons.
pub const PIECE_ARGUMENTS: Stage = Stage {
    name: "piece_arguments",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/casting",
        "shadow/choices",
        "shadow/caster",
        "shadow/chosen",
        "shadow/piece_lists",
        "shadow/piece_arguments"
    ],
    entry_points: &["piece_arguments"],
};
/// Lists the edges whose sides are drawn.
pub const LIST_SIDES: Stage = Stage {
    name: "list_sides",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/choices",
        "shadow/caster",
        "shadow/chosen",
        "shadow/multiplicity",
        "shadow/side_lists",
        "shadow/list_sides"
    ],
    entry_points: &["list_sides"],
};

/// Computes boxes around clusters of faces, for the shadow depth query.
pub const SHADOW_BOXES: Stage = Stage {
    name: "shadow_boxes",
    files: files!["common/common", "common/positions", "query/shadow_boxes"],
    entry_points: &["shadow_boxes"],
};
/// Counts the faces strictly between points and lights.
pub const SHADOW_DEPTH: Stage = Stage {
    name: "shadow_depth",
    files: files![
        "common/common",
        "common/positions",
        "common/determinant",
        "common/filter",
        "query/shadow_segments",
        "query/shadow_pairs",
        "query/shadow_depth"
    ],
    entry_points: &["shadow_depth"],
};
/// Decides the faces that the shadow depth stage left undecided.
pub const EXACT_SHADOW_DEPTH: Stage = Stage {
    name: "exact_shadow_depth",
    files: files![
        "common/common",
        "common/positions",
        "common/determinant",
        "common/filter",
        "common/exact_sign",
        "common/fixed_sign",
        "query/shadow_segments",
        "query/shadow_pairs",
        "query/exact_shadow_depth"
    ],
    entry_points: &["exact_shadow_depth", "exact_shadow_depth_recount"],
};
/// Computes the indirect dispatch that counts pairs with many undecided faces again.
pub const DEPTH_ARGUMENTS: Stage = Stage {
    name: "depth_arguments",
    files: files!["common/common", "query/depth_arguments"],
    entry_points: &["depth_arguments"],
};

/// Lists the cells of a depth map that have a triangle to draw.
pub const DEPTH_CELLS: Stage = Stage {
    name: "depth_cells",
    files: files![
        "depth_map/samples",
        "depth_map/world_step",
        "depth_map/edge_code",
        "depth_map/cell_words",
        "depth_map/depth_cells"
    ],
    entry_points: &["depth_cells_count", "depth_cells_places", "depth_cells_list"],
};

/// Marks edges of a depth map by a rule that looks at more than their ends, and decides about cells from the marks.
pub const DEPTH_EDGES: Stage = Stage {
    name: "depth_edges",
    files: files![
        "depth_map/samples",
        "depth_map/world_step",
        "depth_map/edge_code",
        "depth_map/cell_words",
        "depth_map/edge_rule",
        "depth_map/edge_marks",
        "depth_map/depth_edges"
    ],
    entry_points: &["depth_edges_mark", "depth_edges_continue", "depth_edges_count"],
};

/// Marks the edges of a depth map that a contour crosses.
pub const CONTOUR_MARKS: Stage = Stage {
    name: "contour_marks",
    files: files!["depth_map/samples", "depth_map/edge_code", "depth_map/contour", "depth_map/contour_marks"],
    entry_points: &["contour_marks"],
};

/// Places contours on the edges that they cross.
pub const CONTOUR_PLACES: Stage = Stage {
    name: "contour_places",
    files: files![
        "depth_map/samples",
        "depth_map/contour",
        "depth_map/contour_marked",
        "depth_map/contour_rim",
        "depth_map/contour_places"
    ],
    entry_points: &["contour_places"],
};

/// Lists the tiles that contours cross.
pub const CONTOUR_TILES: Stage = Stage {
    name: "contour_tiles",
    files: files!["depth_map/samples", "depth_map/contour", "depth_map/contour_marked", "depth_map/contour_tiles"],
    entry_points: &["contour_tiles_find", "contour_tiles_list"],
};

/// Lists walls over segments that are fitted to the contours of a depth map.
pub const CONTOUR_WALLS: Stage = Stage {
    name: "contour_walls",
    files: files![
        "depth_map/samples",
        "depth_map/contour",
        "depth_map/contour_marked",
        "depth_map/contour_rim",
        "depth_map/contour_walls"
    ],
    entry_points: &["contour_walls_take", "contour_walls_places"],
};

/// Tells whether the near rectangle of a camera may be in the shadow of a depth map.
pub const DEPTH_NEAR: Stage = Stage {
    name: "depth_near",
    files: files!["depth_map/samples", "depth_map/near_box", "depth_map/depth_near"],
    entry_points: &["depth_near"],
};

/// The same for surfaces that go on up to contours.
pub const DEPTH_NEAR_WALLS: Stage = Stage {
    name: "depth_near_walls",
    files: files!["depth_map/samples", "depth_map/contour", "depth_map/near_box", "depth_map/depth_near_walls"],
    entry_points: &["depth_near_walls"],
};

/// Merges two depth maps of one light.
pub const DEPTH_MERGE: Stage = Stage {
    name: "depth_merge",
    files: files!["depth_map/samples", "depth_map/depth_merge"],
    entry_points: &["depth_merge"],
};

/// Makes a depth map from a map of distances.
pub const DEPTH_METRIC: Stage = Stage {
    name: "depth_metric",
    files: files!["depth_map/samples", "depth_map/depth_metric"],
    entry_points: &["depth_metric"],
};

/// Puts the six maps of a cube into one texture.
pub const DEPTH_CUBE: Stage = Stage {
    name: "depth_cube",
    files: files!["depth_map/samples", "depth_map/cube", "depth_map/depth_cube"],
    entry_points: &["depth_cube"],
};

/// Every stage, in the order of the data flow.
pub const STAGES: [Stage; 50] = [
    NEEDS,
    DEFORM,
    FACING,
    EXACT_FACING,
    POLYGON_FACING,
    POLYGON_TURNS,
    OUTLINE,
    POLYGON_MASKS,
    EDGES,
    CUT_EDGES,
    CUT_QUADS,
    PER_EDGE,
    COMPACT,
    ARGUMENTS,
    REACH,
    CLUSTERS,
    CHUNKS,
    SCENE_FACING,
    SCENE_EXACT_FACING,
    SCENE_EDGES,
    RECEIVER_DEPTH,
    RECEIVER_SAMPLES,
    RECEIVER_PYRAMID,
    RELIST,
    BOUNDS,
    CHOOSE,
    ZP_PLUS_2005_CASES,
    CAPS,
    LIST_SIDES,
    SHADOW_ARGUMENTS,
    PIECE_ARGUMENTS,
    STENCIL_PENCIL,
    STENCIL_CROSSINGS,
    PIECE_CROSSINGS,
    STENCIL_BOUND,
    SHADOW_BOXES,
    SHADOW_DEPTH,
    DEPTH_ARGUMENTS,
    EXACT_SHADOW_DEPTH,
    DEPTH_NEAR,
    DEPTH_NEAR_WALLS,
    DEPTH_METRIC,
    DEPTH_MERGE,
    DEPTH_CUBE,
    DEPTH_EDGES,
    DEPTH_CELLS,
    CONTOUR_MARKS,
    CONTOUR_TILES,
    CONTOUR_PLACES,
    CONTOUR_WALLS,
];

/// Vertex shaders of the sides of shadow volumes.
pub const SIDES: Stage = Stage {
    name: "sides",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/polygon",
        "shadow/trim",
        "shadow/zp_plus_2005",
        "shadow/choices",
        "shadow/caster",
        "shadow/positions",
        "shadow/chosen",
        "shadow/multiplicity",
        "shadow/side_lists",
        "shadow/side_vertices",
        "shadow/sides"
    ],
    entry_points: &["side", "side_clipped", "zp_plus_2005_side"],
};
/// Vertex shaders of the caps of shadow volumes.
pub const CAP_FACES: Stage = Stage {
    name: "cap_faces",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/polygon",
        "shadow/trim",
        "shadow/zp_plus_2005",
        "shadow/casting",
        "shadow/choices",
        "shadow/caster",
        "shadow/positions",
        "shadow/chosen",
        "shadow/cap_vertices",
        "shadow/cap_faces"
    ],
    entry_points: &["light_cap", "seen_light_cap", "dark_cap", "near_cap", "zp_plus_2005_cap"],
};

/// Vertex shaders of the sides and caps of pieces of L-twisted polygons.
pub const PIECES: Stage = Stage {
    name: "pieces",
    files: files![
        "common/common",
        "shadow/shadow",
        "shadow/polygon",
        "shadow/trim",
        "shadow/choices",
        "shadow/caster",
        "shadow/chosen",
        "shadow/side_vertices",
        "shadow/cap_vertices",
        "shadow/piece_lists",
        "shadow/pieces"
    ],
    entry_points: &["piece_side", "piece_side_clipped", "piece_near_cap", "piece_light_cap", "piece_dark_cap"],
};
/// Vertex shaders of the boundary that is rebuilt from a depth map, and of its near cap.
pub const DEPTH_SURFACE: Stage = Stage {
    name: "depth_surface",
    files: files![
        "depth_map/samples",
        "depth_map/edge_code",
        "depth_map/cube",
        "depth_map/surface",
        "depth_map/depth_surface"
    ],
    entry_points: &["depth_surface", "depth_near_cap"],
};

/// Vertex shader of walls over the contours of a depth map, and of the near cap between them.
pub const DEPTH_WALLS: Stage = Stage {
    name: "depth_walls",
    files: files![
        "depth_map/samples",
        "depth_map/edge_code",
        "depth_map/cube",
        "depth_map/surface",
        "depth_map/contour",
        "depth_map/contour_marked",
        "depth_map/contour_rim",
        "depth_map/contour_side",
        "depth_map/contour_flaps",
        "depth_map/depth_walls"
    ],
    entry_points: &["depth_walls"],
};

/// Vertex shaders that draw a mesh, and the casters of a scene, into a depth map.
pub const MESH_DEPTH: Stage =
    Stage { name: "mesh_depth", files: files!["depth_map/mesh_depth"], entry_points: &["mesh_depth", "scene_depth"] };

/// WGSL that is not a stage: files that callers include or replace.
pub const INCLUDES: [(&str, &str); 2] = [
    ("deform/displace", include_str!("../wgsl/deform/displace.wgsl")),
    ("extract/results", include_str!("../wgsl/extract/results.wgsl")),
];

impl Stage {
    /// The name of its module. A stage with one text for a single mesh and for scenes has two modules.
    pub fn module_name(&self) -> String {
        let own = self.files.last().map_or("", |(name, _)| name);
        let is_of_scene = self.files.iter().any(|(name, _)| *name == "scene/many_casters");
        if is_of_scene && !own.starts_with("scene/") { format!("scene_{}", self.name) } else { self.name.to_owned() }
    }

    /// The stage's whole WGSL module. The deform stage lacks its `displace`; see [`plain_deform_wgsl`].
    pub fn wgsl(&self) -> String {
        self.files.iter().map(|(_, source)| *source).collect::<Vec<_>>().join("\n")
    }
}

/// The WGSL of the deform stage without a displacement.
pub fn plain_deform_wgsl() -> String {
    let identity = INCLUDES.iter().find(|(name, _)| *name == "deform/displace").map_or("", |(_, source)| source);
    format!("{identity}\n{}", DEFORM.wgsl())
}
