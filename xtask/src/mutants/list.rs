//! Mutations: single changes, made in the shader and in its twin alike where both exist, since a suite that only compares
//! the two cannot see them.

/// One mutation.
pub(super) struct Mutation {
    /// What is wrong then.
    pub(super) name: &'static str,
    /// File, a text that stands there once, and what replaces it.
    pub(super) changes: &'static [(&'static str, &'static str, &'static str)],
    /// Cargo's arguments for the tests that ought to notice, each up to the first that does.
    pub(super) tests: &'static [&'static str],
}

const DEFORM: &[&str] = &["--test deform_gpu", "--test deform_cpu"];
const SCENES: &[&str] = &["--test scene_gpu", "--test shadow_gpu"];
const CLUSTERS: &[&str] = &["--test mesh clusters", "--test rounding clusters"];
const POLYGON_MESHES: &[&str] = &["--test mesh polygons"];
const POLYGONS: &[&str] = &["--test polygon_cpu"];
const HIDDEN: &[&str] = &["--test hidden_cpu"];
const MARGINS: &[&str] = &["--test shadow_margins", "--test shadow_cpu", "--test shadow_gpu"];

pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "hidden faces: faces of closed casters that face the light hide others",
        changes: &[("src/cpu/hidden/hidden_faces.rs", "side < 0 || (side > 0 && !is_closed)", "side != 0")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: one corner behind the hider is enough",
        changes: &[(
            "src/cpu/hidden/tree.rs",
            "face.corners.iter().all(|&corner| plane.side(corner) != *side)",
            "face.corners.iter().any(|&corner| plane.side(corner) != *side)",
        )],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: the outline inside a body costs nothing",
        changes: &[("src/cpu/hidden/outline.rs", "=> cut.cost_of_leaving_out(node),", "=> drop(node),")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: an open boundary costs nothing",
        changes: &[("src/cpu/hidden/outline.rs", "cut.cost_of_keeping(node(edge.face_0));", "")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: a flow is never sent back",
        changes: &[("src/cpu/hidden/min_cut.rs", "self.left[arc ^ 1] += 1;", "")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: a polygon is hidden if one of its triangles is",
        changes: &[("src/cpu/hidden/hidden_faces.rs", "of.len() == triangles(face)", "of.len() <= triangles(face)")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: polygons that are not planar take part",
        changes: &[("src/cpu/hidden/hidden_faces.rs", "[x, y, z, 1.0]) == 0", "[x, y, z, 1.0]) < 2")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: a face is in one cone alone",
        changes: &[("src/cpu/hidden/cones.rs", "is_flat || sides.contains(&side)", "is_flat || sides[0] == side")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: a part ends before the plane",
        changes: &[("src/cpu/hidden/clipped.rs", "let part = heights[inner]", "let part = 0.5 * heights[inner]")],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: a tree sees the directions beside its cone",
        changes: &[(
            "src/cpu/hidden/tree.rs",
            "if side > 0 { [next, Place::Elsewhere] }",
            "if side < 0 { [next, Place::Elsewhere] }",
        )],
        tests: HIDDEN,
    },
    Mutation {
        name: "hidden faces: what lies in a plane is on no side of it",
        changes: &[("src/cpu/hidden/tree.rs", "(sides.contains(&sign) || sides == [0; 3])", "sides.contains(&sign)")],
        tests: HIDDEN,
    },
    Mutation {
        name: "deform: morph targets are ignored",
        changes: &[
            ("wgsl/deform/deform.wgsl", "p += weight * vec3", "p += 0.0 * weight * vec3"),
            (
                "src/cpu/deform/deform.rs",
                "add_scaled(p, weight, target[vertex])",
                "add_scaled(p, 0.0 * weight, target[vertex])",
            ),
        ],
        tests: DEFORM,
    },
    Mutation {
        name: "deform: all influences of a vertex weigh the same",
        changes: &[
            (
                "wgsl/deform/deform.wgsl",
                "bitcast<f32>(skin[influence + 1u]) * transform",
                "(1.0 / f32(end - first)) * transform",
            ),
            (
                "src/cpu/deform/deform.rs",
                "add_scaled(sum, weight, transform(pose, joint, p))",
                "add_scaled(sum, 0.0 * weight + 1.0 / influences.range(vertex).len() as f32, transform(pose, joint, p))",
            ),
        ],
        tests: DEFORM,
    },
    Mutation {
        name: "deform: translations of matrices are dropped",
        changes: &[
            ("wgsl/deform/deform.wgsl", "row.z * p.z + row.w;", "row.z * p.z + 0.0 * row.w;"),
            ("src/cpu/deform/deform.rs", "z * p[2] + w)", "z * p[2] + 0.0 * w)"),
        ],
        tests: DEFORM,
    },
    Mutation {
        name: "deform: only the first four influences",
        changes: &[
            ("wgsl/deform/deform.wgsl", "at < end; at++", "at < min(end, first + 4u); at++"),
            ("src/cpu/deform/deform.rs", "joints.fold(", "joints.take(4).fold("),
        ],
        tests: DEFORM,
    },
    Mutation {
        name: "deform: negative morph weights are ignored",
        changes: &[
            ("wgsl/deform/deform.wgsl", "p += weight * vec3", "p += max(weight, 0.0) * vec3"),
            ("src/cpu/deform/deform.rs", "if weight != 0.0 {", "if weight > 0.0 {"),
        ],
        tests: DEFORM,
    },
    Mutation {
        name: "deform: morph weights are capped at 1",
        changes: &[
            ("wgsl/deform/deform.wgsl", "p += weight * vec3", "p += min(weight, 1.0) * vec3"),
            ("src/cpu/deform/deform.rs", "add_scaled(p, weight, target", "add_scaled(p, weight.min(1.0), target"),
        ],
        tests: DEFORM,
    },
    Mutation {
        name: "stencil bound: a third of the weights instead of half",
        changes: &[
            ("wgsl/shadow/stencil_bound.wgsl", "(most + 1u) / 2u", "(most + 2u) / 3u"),
            ("src/cpu/shadow/stencil_bound.rs", "most.div_ceil(2)", "most.div_ceil(3)"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "stencil crossings: an edge ends in its own bin",
        changes: &[
            ("wgsl/shadow/pencil.wgsl", "row + last + 1u", "row + last"),
            ("src/cpu/shadow/stencil_crossings.rs", "bins[last + 1] = bins[last + 1]", "bins[last] = bins[last]"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "stencil crossings: edges go the long way around the axis",
        changes: &[
            ("wgsl/shadow/pencil.wgsl", "abs(p - q) > 2.0", "abs(p - q) > 4.0"),
            ("src/cpu/shadow/stencil_crossings.rs", "(p - q).abs() > 2.0", "(p - q).abs() > 4.0"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "stencil pencil: casters that the axis meets count nowhere",
        changes: &[
            ("wgsl/shadow/stencil_bound.wgsl", "(most + 1u) / 2u + crossings[row + MET_FACES]", "(most + 1u) / 2u"),
            (
                "src/cpu/shadow/stencil_bound.rs",
                "all.min(most.div_ceil(2) + met)",
                "all.min(most.div_ceil(2) + 0 * met)",
            ),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "stencil pencil: it aims at the middle of the box",
        changes: &[
            (
                "wgsl/shadow/stencil_pencil.wgsl",
                "clamp(by.place, low, high) - by.place",
                "0.5 * (low + high) - by.place",
            ),
            ("src/cpu/shadow/stencil_pencil.rs", "place.clamp(low, high) - place", "0.5 * (low + high) - place"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "bounds: all joints are where the first one is",
        changes: &[("src/model/bounds.rs", "pose.palette().get(*joint)?", "pose.palette().get(0 * *joint)?")],
        tests: &["--test deform_cpu bounds"],
    },
    Mutation {
        name: "bounds: rounding is forgotten",
        changes: &[(
            "src/model/bounds.rs",
            "relative * absolute * placed_size",
            "0.0 * relative * absolute * placed_size",
        )],
        tests: &["--test deform_cpu bounds"],
    },
    Mutation {
        name: "bounds: negative weights are forgotten",
        changes: &[("src/model/bounds.rs", "widened(negative * placed", "widened(0.0 * negative * placed")],
        tests: &["--test deform_cpu bounds"],
    },
    Mutation {
        name: "bounds: weights sum to one",
        changes: &[("src/model/bounds.rs", "placed[axis].times_span(sums)", "placed[axis].plus(sums.times(0.0))")],
        tests: &["--test deform_cpu bounds"],
    },
    Mutation {
        name: "deform: what is not needed stays where it was",
        changes: &[("wgsl/deform/deform.wgsl", "if (pose[chunk.before] == 0u) {", "if (pose[chunk.before] == 7u) {")],
        tests: &["--test scene_gpu need"],
    },
    Mutation {
        name: "deform: a frame that deforms all does not note it",
        changes: &[(
            "src/gpu/deform/deformer.rs",
            "encoder.copy_buffer_to_buffer(&self.pose, 4 * self.before + bytes, &self.held, 0, bytes);",
            "if needs.is_some() { encoder.copy_buffer_to_buffer(&self.pose, 4 * self.before + bytes, &self.held, 0, bytes); }",
        )],
        tests: &["--test scene_gpu need"],
    },
    Mutation {
        name: "needs: the first light has no shadow",
        changes: &[
            ("wgsl/scene/needs.wgsl", "if (has_light && may_shade(", "if (has_light && number > 0u && may_shade("),
            ("src/cpu/scene/needs.rs", "has_light(*number)", "*number > 0 && has_light(*number)"),
        ],
        tests: &["--test scene_gpu need"],
    },
    Mutation {
        name: "needs: figures in sight are not looked at",
        changes: &[
            ("wgsl/scene/needs.wgsl", "if (!box_is_unseen(", "if (frame.figures == 0u && !box_is_unseen("),
            ("src/cpu/scene/needs.rs", "!box_is_unseen(", "frame.figures == 0 && !box_is_unseen("),
        ],
        tests: &["--test scene_gpu need"],
    },
    Mutation {
        name: "reach: lights matter to figures that are not needed",
        changes: &[(
            "wgsl/scene/reach.wgsl",
            "select(lights_that_matter(caster, batch), 0u, unneeded)",
            "select(lights_that_matter(caster, batch), 0u, unneeded && batch > 100u)",
        )],
        tests: &["--test scene_gpu need"],
    },
    Mutation {
        name: "reach: figures are told from others at the first frame alone",
        changes: &[("src/gpu/scene/needs.rs", "self.note_change(key);", "let _ = key;")],
        tests: &["--test scene_gpu need"],
    },
    Mutation {
        name: "cones: rounding is forgotten",
        changes: &[
            ("wgsl/common/casters.wgsl", "const CONE_SLACK: f32 = 0x1p-14;", "const CONE_SLACK: f32 = 0.0;"),
            (
                "src/cpu/common/cone.rs",
                "const SLACK: f32 = f32::from_bits((127 - 14) << 23);",
                "const SLACK: f32 = 0.0;",
            ),
        ],
        tests: &["--test scene_gpu cone"],
    },
    Mutation {
        name: "cones: those of more than a right angle are as others",
        changes: &[
            ("wgsl/common/casters.wgsl", "if (cosine < 0.0) {", "if (cosine < -2.0) {"),
            ("src/cpu/common/cone.rs", "if cosine < 0.0 {", "if cosine < -2.0 {"),
        ],
        tests: &["--test scene_gpu cone"],
    },
    Mutation {
        name: "cones: a plane across the middle separates beside the cone, too",
        changes: &[
            ("wgsl/common/casters.wgsl", "along < -sine * distance", "along < 0.5 * distance"),
            ("src/cpu/common/cone.rs", "along < -sine * distance", "along < 0.5 * distance"),
        ],
        tests: &["--test scene_gpu cone"],
    },
    Mutation {
        name: "cones: boxes of rigid casters are not moved",
        changes: &[
            ("wgsl/scene/reach.wgsl", "begin.x + begin.y + begin.z + row.w", "begin.x + begin.y + begin.z"),
            ("wgsl/scene/reach.wgsl", "end.x + end.y + end.z + row.w", "end.x + end.y + end.z"),
            ("src/cpu/scene/reach.rs", "begin[0] + begin[1] + begin[2] + row[3]", "begin[0] + begin[1] + begin[2]"),
            ("src/cpu/scene/reach.rs", "end[0] + end[1] + end[2] + row[3]", "end[0] + end[1] + end[2]"),
        ],
        tests: &["--test scene_gpu cone"],
    },
    Mutation {
        name: "lights: another cone is no change",
        changes: &[(
            "src/gpu/scene/lights.rs",
            "light.cone.map(cone_bits)",
            "light.cone.map(cone_bits).and(None::<u8>)",
        )],
        tests: &["--test scene_gpu cone"],
    },
    Mutation {
        name: "reach: bits of lights that moved are kept",
        changes: &[
            (
                "wgsl/scene/reach.wgsl",
                "kept[kept_lights_at(batch) + light] == light_version(batch, light)",
                "light < 32u",
            ),
            (
                "src/cpu/scene/reach.rs",
                "word(4 + 32 * batch + bit) == versions[(32 * batch + bit) as usize]",
                "*bit < 32",
            ),
        ],
        tests: SCENES,
    },
    Mutation {
        name: "reach: lights that cease to matter leave their lists as they are",
        changes: &[
            ("wgsl/scene/reach.wgsl", "(matter & ~keeps) | (before & ~matter)", "(matter & ~keeps)"),
            ("src/cpu/scene/reach.rs", "matter & !keeps | before & !matter", "matter & !keeps"),
        ],
        tests: SCENES,
    },
    Mutation {
        name: "reach: bits of another layout are kept",
        changes: &[
            ("wgsl/scene/reach.wgsl", "group.keeps != 0u && kept[0] == group.structure", "group.keeps != 0u"),
            ("src/cpu/scene/reach.rs", "keeps != 0 && word(0) == structure", "keeps != 0"),
        ],
        tests: SCENES,
    },
    Mutation {
        name: "list sides: lights in planes of kept faces are forgotten",
        changes: &[("wgsl/shadow/list_sides.wgsl", " || (MANY && silhouette_counts[KEPT_ZEROS] != 0u)", "")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "scene: masks are kept where what describes them is made anew",
        changes: &[(
            "src/gpu/scene/buffers.rs",
            "old.is_some_and(|old| Maker::fits(&old.kept, kept))",
            "old.is_some()",
        )],
        tests: SCENES,
    },
    Mutation {
        name: "choose: volumes end 20 % early",
        changes: &[
            ("wgsl/shadow/choose.wgsl", "light.end = min(scale *", "light.end = min(1.25 * scale *"),
            ("src/cpu/shadow/choose.rs", "light.end = (distance_below", "light.end = (1.25 * distance_below"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "filter: 8 units of the last place instead of 10",
        changes: &[
            ("wgsl/common/determinant.wgsl", "0x1.4p-20", "0x1p-20"),
            ("src/cpu/common/filter.rs", "10.0 / 8_388_608.0", "8.0 / 8_388_608.0"),
        ],
        tests: &["--test rounding", "--test extract_cpu", "--test extract_gpu"],
    },
    Mutation {
        name: "filter: a tiny w counts as exact",
        changes: &[("src/layout.rs", "given[3] != 0.0 && w < TINY_W", "given[3] != given[3] && w < TINY_W")],
        tests: &["--test rounding", "--test extract_cpu", "--test extract_gpu"],
    },
    Mutation {
        name: "choose: boxes meet without slack",
        changes: &[
            (
                "wgsl/shadow/choose.wgsl",
                "let slack = SLACK * max(size, max(abs(view.near_min[axis]), abs(view.near_max[axis])));",
                "let slack = 0.0 * max(size, max(abs(view.near_min[axis]), abs(view.near_max[axis])));",
            ),
            (
                "src/cpu/shadow/choose.rs",
                "let slack = SLACK * size.max(near_min.abs().max(near_max.abs()));",
                "let slack = 0.0 * size.max(near_min.abs().max(near_max.abs()));",
            ),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "pyramid: no slack",
        changes: &[
            ("wgsl/shadow/visibility.wgsl", "const SLACK: f32 = 4e-6;", "const SLACK: f32 = 0.0;"),
            ("src/cpu/shadow/pyramid.rs", "SLACK: f32 = 4e-6;", "SLACK: f32 = 0.0;"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "sides: depths before the near plane stay there",
        changes: &[
            ("wgsl/shadow/shadow.wgsl", "select(max(clip.z, 0.0), min(clip.z, clip.w), view.near_z != 0.0)", "clip.z"),
            (
                "src/cpu/shadow/shadow.rs",
                "if view.near_z == 0.0 { clip.z.max(0.0) } else { clip.z.min(clip.w) }",
                "if view.near_z == 0.0 { clip.z } else { clip.z }",
            ),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "relist: cameras that moved go unnoticed",
        changes: &[("wgsl/shadow/relist.wgsl", "seen[entry].version.x);", "0u * seen[entry].version.x);")],
        tests: SCENES,
    },
    Mutation {
        name: "relist: silhouettes made anew go unnoticed",
        changes: &[(
            "wgsl/shadow/relist.wgsl",
            "vec2<u32>(kept[shape.lists_at + bit],",
            "vec2<u32>(0u * kept[shape.lists_at + bit],",
        )],
        tests: SCENES,
    },
    Mutation {
        name: "relist: lists that are made anew are not emptied",
        changes: &[("wgsl/shadow/relist.wgsl", "    sides[2u * bit] = 0u;\n", "")],
        tests: SCENES,
    },
    Mutation {
        name: "choose: what was chosen before stays",
        changes: &[(
            "wgsl/shadow/choose.wgsl",
            "    for (var word = CASTS; word <= EXCLUDES; word++) {",
            "    for (var word = EVERY; word <= EXCLUDES; word++) {",
        )],
        tests: SCENES,
    },
    Mutation {
        name: "scene: cameras keep their version",
        changes: &[(
            "src/gpu/scene/encode.rs",
            "if bytes(&before) == bytes(view) && of == seen =>",
            "if of == seen =>",
        )],
        tests: SCENES,
    },
    Mutation {
        name: "receivers: lists are kept whatever the version of the depths",
        changes: &[(
            "src/gpu/scene/receivers.rs",
            "Some(version) => Self::Known(version, of.sky_receives, of.pixels()),",
            "Some(version) => Self::Known(0 * version, of.sky_receives, of.pixels()),",
        )],
        tests: &["--test shadow_gpu receivers"],
    },
    Mutation {
        name: "receivers: lists are kept whether the sky receives or not",
        changes: &[(
            "src/gpu/scene/receivers.rs",
            "Some(version) => Self::Known(version, of.sky_receives, of.pixels()),",
            "Some(version) => Self::Known(version, false, of.pixels()),",
        )],
        tests: &["--test shadow_gpu receivers"],
    },
    Mutation {
        name: "caps: light caps of proxies are not clipped with ZP+",
        changes: &[
            ("wgsl/shadow/vertices.wgsl", "if (ends_at_near_plane) {", "if (false) {"),
            ("src/cpu/shadow/cap_faces.rs", "if !has_near_cap(light) {", "if !has_near_cap(light) || true {"),
        ],
        tests: &["--test shadow_cpu", "--test shadow_gpu"],
    },
    Mutation {
        name: "caps: proxies have no light caps",
        changes: &[
            ("wgsl/shadow/lists.wgsl", " || (flags & PROXY) != 0u;", ";"),
            ("src/cpu/shadow/casting.rs", " || !in_depth\n", "\n"),
        ],
        tests: &["--test shadow_gpu proxies"],
    },
    Mutation {
        name: "caps: casters in the depth buffer have light caps with z-pass",
        changes: &[(
            "wgsl/shadow/cap_faces.wgsl",
            "!own.valid || (caster_flags(own.caster) & PROXY) == 0u",
            "!own.valid",
        )],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "choose: of proxies averted faces cast",
        changes: &[
            ("wgsl/shadow/choose.wgsl", " && (flags & PROXY) == 0u;", ";"),
            ("src/cpu/shadow/choose.rs", " && shape.proxies == 0 ", " "),
        ],
        tests: &["--test shadow_gpu proxies"],
    },
    Mutation {
        name: "shadow: `project_to_near_plane` computes by V, also with a far light",
        changes: &[
            ("wgsl/shadow/shadow.wgsl", "if (v.is_far) {", "if (true) {"),
            ("src/cpu/shadow/shadow.rs", "if v.is_far {", "if v.is_far || true {"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "shadow: `project_to_near_plane` computes by V - L, also with a near light",
        changes: &[
            ("wgsl/shadow/shadow.wgsl", "if (v.is_far) {", "if (false) {"),
            ("src/cpu/shadow/shadow.rs", "if v.is_far {", "if v.is_far && false {"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "choose: the near end of the published light's frustum is at least 0.5",
        changes: &[
            ("wgsl/shadow/choose.wgsl", "/ farthest, 0.001, 0.99)", "/ farthest, 0.5, 0.99)"),
            ("src/cpu/shadow/choose.rs", ".clamp(0.001, 0.99)", ".clamp(0.5, 0.99)"),
        ],
        tests: MARGINS,
    },
    Mutation {
        name: "excluded faces: lights in their plane are not marked",
        changes: &[
            (
                "wgsl/extract/exact_facing.wgsl",
                "excluded_masks[slot] |= signs.excluded;",
                "excluded_masks[slot] |= 0u;",
            ),
            (
                "src/cpu/extract/exact_facing.rs",
                "exact.sign(light.to_array()) == 0)",
                "exact.sign(light.to_array()) == 2)",
            ),
        ],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "excluded faces: they are left out of averted faces, and count as averted elsewhere",
        changes: &[
            (
                "wgsl/shadow/lists.wgsl",
                "return select(select(-1, 1, facing), 0, excluded);",
                "return select(-1, 1, facing);",
            ),
            (
                "src/cpu/shadow/multiplicity.rs",
                "EdgeFace { excluded: true, .. } => 0_i32,",
                "EdgeFace { excluded: true, .. } => -1_i32,",
            ),
        ],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "excluded faces: their bits are not heeded for casters with holes",
        changes: &[
            (
                "wgsl/shadow/choose.wgsl",
                "select(0u, 1u, has_holes || is_cut || (light_is_inside",
                "select(0u, 1u, (light_is_inside",
            ),
            (
                "src/cpu/shadow/choose.rs",
                "u32::from(has_holes != 0 || is_cut || (light_is_inside && zeros))",
                "u32::from(light_is_inside && zeros)",
            ),
        ],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "sides: those of weight 2 are wound the other way",
        changes: &[
            ("wgsl/shadow/lists.wgsl", "multiplicity > 0);", "multiplicity > 0 && multiplicity < 2);"),
            ("src/cpu/shadow/multiplicity.rs", "multiplicity > 0)", "multiplicity == 1)"),
        ],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "query: no margin in the test of boxes",
        changes: &[
            ("wgsl/query/shadow_segments.wgsl", "const MARGIN: f32 = 0x1p-18;", "const MARGIN: f32 = 0.0;"),
            ("src/cpu/query/shadow_depth.rs", "const MARGIN: f64 = 1e-14;", "const MARGIN: f64 = 0.0;"),
        ],
        tests: &["--test query_cpu", "--test query_gpu"],
    },
    Mutation {
        name: "query: no bound on underflow in the test of boxes",
        changes: &[("wgsl/query/shadow_segments.wgsl", "const TINY: f32 = 0x1p-100;", "const TINY: f32 = 0.0;")],
        tests: &["--test rounding"],
    },
    Mutation {
        name: "query: the face that a point names counts",
        changes: &[("wgsl/query/shadow_pairs.wgsl", "return NAMES_FACES &&", "return false &&")],
        tests: &["--test query_gpu", "--test polygon_gpu depths"],
    },
    Mutation {
        name: "query: faces have the numbers of their places",
        changes: &[(
            "src/cpu/query/shadow_boxes.rs",
            "cluster.first_face = number as u32;",
            "cluster.first_face = place as u32;",
        )],
        tests: &["--test polygon_gpu depths"],
    },
    Mutation {
        name: "query: the recount reads past its range",
        changes: &[(
            "wgsl/query/exact_shadow_depth.wgsl",
            "min(first + CLUSTER, range.end) * CLUSTER",
            "(first + CLUSTER) * CLUSTER",
        )],
        tests: &["--test query_gpu"],
    },
    Mutation {
        name: "volumes: draws of lights no longer used stay",
        changes: &[("src/gpu/shadow/buffers.rs", "encoder.clear_buffer(draws, 0, None);", "let _ = draws;")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "volumes: counts of caps stay",
        changes: &[("src/gpu/shadow/buffers.rs", "Some(counts[1])", "Some(4)")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "scenes: volumes of mirrored casters are wound as others",
        changes: &[("wgsl/shadow/sides.wgsl", "winding != turned_over", "winding != (turned_over && !turned_over)")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "scenes: rigid casters are extruded from the light's place in the world",
        changes: &[("wgsl/shadow/caster.wgsl", "vec4<f32>(given.xyz * light.scale, light.light.w)", "light.light")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "scenes: faces that callers exclude count",
        changes: &[("src/gpu/scene/table.rs", "flag(entry.is_excluding(), EXCLUDING)", "flag(false, EXCLUDING)")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "scenes: each batch of casters counts all casters",
        changes: &[("wgsl/shadow/choices.wgsl", "== count_batch;", "<= count_batch + shape.count_batches;")],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "extractor: bind groups of another offset or stride stay",
        changes: &[(
            "src/gpu/extract/extractor.rs",
            "if self.bound_to.as_ref() == Some(place) {",
            "if self.bound_to.as_ref().is_some_and(|bound| bound.buffer == place.buffer) {",
        )],
        tests: &["--test extract_gpu"],
    },
    Mutation {
        name: "volumes: bind groups of another offset or stride stay",
        changes: &[(
            "src/gpu/shadow/volumes.rs",
            "&& *place == extraction.place",
            "&& place.buffer == extraction.place.buffer",
        )],
        tests: &["--test shadow_gpu"],
    },
    Mutation {
        name: "weld: -0 and 0 stay apart",
        changes: &[("src/mesh/weld.rs", "if value == 0.0 { 0 } else { value.to_bits() }", "value.to_bits()")],
        tests: &["--test mesh", "--test deform_cpu", "--lib weld"],
    },
    Mutation {
        name: "weld: skin weights are ignored",
        changes: &[(
            "src/model/geometry.rs",
            "                && influences.weights[a]",
            "                || influences.weights[a]",
        )],
        tests: &["--test mesh", "--test deform_cpu"],
    },
    Mutation {
        name: "glTF: sparse indices may repeat",
        changes: &[("src/gltf/reader.rs", "least = u64::from(index) + 1;", "least = u64::from(index);")],
        tests: &["--test gltf sparse"],
    },
    Mutation {
        name: "area: a part of the disc is mirrored",
        changes: &[("src/area.rs", "FRAC_PI_2 - FRAC_PI_4 * (x / y)", "FRAC_PI_2 + FRAC_PI_4 * (x / y)")],
        tests: &["--lib area", "--test soft"],
    },
    Mutation {
        name: "query: points where a binding may not begin are read from its begin",
        changes: &[(
            "src/gpu/query/shadow_query.rs",
            "((first_byte - query.split.align_down(first_byte)) / 4) as u32",
            "(0 * first_byte) as u32",
        )],
        tests: &["--test query_gpu"],
    },
    Mutation {
        name: "clusters: bounds have no room for rounding",
        changes: &[(
            "src/mesh/clusters/bound.rs",
            "pub const WIDENING: f64 = 14.0",
            "pub const WIDENING: f64 = 0.0 * 14.0",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: heights are those of the first face",
        changes: &[(
            "src/mesh/clusters/bound.rs",
            "heights.add(height_and_distance(plane));",
            "heights.add(height_and_distance(&planes[0 * plane.len()]));",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: faces that name a vertex twice may be facing",
        changes: &[(
            "src/mesh/clusters/bound.rs",
            "(_, true, true) => cluster_kinds::AT_MOST_AVERTED",
            "(_, true, true) => cluster_kinds::BOUNDED",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: faces without a bound are left out",
        changes: &[(
            "src/mesh/clusters/bound.rs",
            "(true, _, _) => cluster_kinds::MIXED",
            "(true, _, _) => cluster_kinds::BOUNDED",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: needles have a normal",
        changes: &[(
            "src/mesh/clusters/plane.rs",
            "largest > LEAST_NORMAL * terms",
            "largest > 0.0 * LEAST_NORMAL * terms",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: large coordinates have a bound",
        changes: &[(
            "src/mesh/clusters/plane.rs",
            "magnitude < LARGE.to_bits() as i32 &&",
            "magnitude < f32::INFINITY.to_bits() as i32 &&",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: the range of heights is forgotten",
        changes: &[(
            "src/cpu/scene/clusters.rs",
            "+ half[3] * w.abs().max(inexact_w);",
            "+ 0.0 * half[3] * w.abs().max(inexact_w);",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: the height of the centre is forgotten",
        changes: &[("src/cpu/scene/clusters.rs", "+ middle[3] * w;", "+ 0.0 * middle[3] * w;")],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: the rounding of the light's product is forgotten",
        changes: &[("src/cpu/scene/clusters.rs", "PRODUCT * inexact_w *", "0.0 * PRODUCT * inexact_w *")],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: underflow is forgotten",
        changes: &[("src/cpu/scene/clusters.rs", "+ LEAST]", "+ 0.0 * LEAST]")],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: planes that hold the light are decided",
        changes: &[("src/cpu/scene/clusters.rs", "if height > spread &&", "if height >= 0.0 * spread &&")],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: inconsistent records are skipped",
        changes: &[(
            "src/mesh/clusters/edges.rs",
            "if face_1 == NO_FACE || face_0 & INCONSISTENT_BIT != 0 {",
            "if face_1 == NO_FACE {",
        )],
        tests: CLUSTERS,
    },
    Mutation {
        name: "clusters: faces are counted from the run of a thread",
        changes: &[("src/mesh/clusters/order.rs", "(first + keys.len()) as u64", "(0 * first + keys.len()) as u64")],
        tests: CLUSTERS,
    },
    Mutation {
        name: "polygons: edges that are walked both ways stay",
        changes: &[(
            "src/mesh/polygons/outline.rs",
            "self.is_cancelled[other as usize] = true;",
            "self.is_cancelled[other as usize] = false;",
        )],
        tests: POLYGON_MESHES,
    },
    Mutation {
        name: "polygons: what earcut leaves open stays open",
        changes: &[(
            "src/mesh/polygons/triangulate.rs",
            "self.open.append_fans(triangles);",
            "self.open.append_fans(&mut Vec::new());",
        )],
        tests: POLYGON_MESHES,
    },
    Mutation {
        name: "polygons: holes are not told to earcut",
        changes: &[("src/mesh/polygons/triangulate.rs", "if index > 0 {", "if index > usize::MAX - 1 {")],
        tests: POLYGON_MESHES,
    },
    Mutation {
        name: "polygons: the last vertex of an index range is out of range",
        changes: &[("src/mesh/polygons/check.rs", "v as usize >= vertex_count", "v as usize > vertex_count")],
        tests: POLYGON_MESHES,
    },
    Mutation {
        name: "polygons: ties are not broken",
        changes: &[("src/cpu/polygon/turn.rs", ".find(|&sign| sign != 0)", ".find(|&sign| sign == 0)")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: ties are broken in another order",
        changes: &[("src/cpu/polygon/turn.rs", "0 => AXES.into_iter().map", "0 => AXES.into_iter().rev().map")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: crossings go unnoticed",
        changes: &[("src/cpu/polygon/edge_pair.rs", "(-1, -1) => of_e[0] == of_f[1],", "(-1, -1) => false,")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: opposite directions cross",
        changes: &[("src/cpu/polygon/edge_pair.rs", "(-1, -1) => of_e[0] == of_f[1],", "(-1, -1) => true,")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: a corner on an edge goes unnoticed",
        changes: &[("src/cpu/polygon/edge_pair.rs", "(0, -1) | (-1, 0) => true,", "(0, -1) | (-1, 0) => false,")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: edges that overlap go unnoticed",
        changes: &[("src/cpu/polygon/edge_pair.rs", "return overlaps([a, b], [c, d]);", "return false;")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: edges back along themselves go unnoticed",
        changes: &[("src/cpu/polygon/edge_pair.rs", "&& !is_between(end, from, other_end)", "&& false")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: an edge that begins at an end does not pass it",
        changes: &[("src/cpu/polygon/edge_pair.rs", "i32::from(b_of_f >= 0)", "i32::from(b_of_f > 0)")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: any outline fits a half-space",
        changes: &[("src/cpu/polygon/half_space.rs", "..0 => return false,", "..0 => {}")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: half-spaces are sought on the other side",
        changes: &[(
            "src/cpu/polygon/half_space.rs",
            "turn(corner, best, other, light) < 0",
            "turn(corner, best, other, light) > 0",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: convex outlines may go around twice",
        changes: &[(
            "src/cpu/polygon/polygon_turns.rs",
            "(3..count.max(4) - 1).flat_map(",
            "(count..count.max(4) - 1).flat_map(",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: outlines in a plane with the light have a side",
        changes: &[(
            "src/cpu/polygon/outline.rs",
            "turn_as_given(a, b, c, light) == 0))",
            "turn_as_given(a, b, c, light) == 2))",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: triangles with the light in their plane say it of all corners",
        changes: &[(
            "src/cpu/polygon/outline.rs",
            "self.edges.iter().all(|&[a, b]| self.corners",
            "self.edges.iter().take(1).all(|&[a, b]| self.corners[..3]",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: only the first edge has its winding number looked at",
        changes: &[(
            "src/cpu/polygon/outline.rs",
            "Some(1) if windings.iter().all(|&winding| winding == 1)",
            "Some(1) if !windings.is_empty()",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: edges beside a twisted face 0 are wound as if they had none",
        changes: &[(
            "src/cpu/extract/edges.rs",
            "winding: counts_0 & f0 | !counts_0 & counts_1 & turned_1",
            "winding: counts_0 & f0",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: edges beside twisted faces are no boundaries",
        changes: &[("src/cpu/extract/edges.rs", "silhouette: alone | both", "silhouette: both")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: faces in one sense count as against each other",
        changes: &[(
            "src/cpu/extract/edges.rs",
            "let turned_1 = if is_inconsistent { f1 } else { !f1 };",
            "let turned_1 = if is_inconsistent { !f1 } else { !f1 };",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: crossings along an edge do not exchange the sides",
        changes: &[(
            "src/cpu/polygon/cut_edges.rs",
            "(crossings.len() - piece).is_multiple_of(2)",
            "(piece <= crossings.len())",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: edges are cut by opposite directions",
        changes: &[("src/cpu/polygon/cut_edges.rs", "|| sides[0] == ends[1])", "|| sides[0] * ends[1] != 0)")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: the left of an edge is its right",
        changes: &[("src/cpu/polygon/cut_edges.rs", "{ 1 } else { -1 })", "{ -1 } else { 1 })")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: directions at an end are those of the end",
        changes: &[("src/cpu/polygon/cut_edges.rs", "turn(p, q, a, light)];", "0];")],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: signs that are not certain decide",
        changes: &[(
            "src/cpu/polygon/turns_batch.rs",
            "self.are_certain &= is_certain;",
            "self.are_certain &= is_certain | true;",
        )],
        tests: POLYGONS,
    },
    Mutation {
        name: "polygons: turns of both senses are convex",
        changes: &[("src/cpu/polygon/turns_batch.rs", "undecided: once & !facing }", "undecided: 0 & once }")],
        tests: POLYGONS,
    },
];
