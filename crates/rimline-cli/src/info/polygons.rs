//! Report on polygons: how many corners they have, how many are not planar, and how lights see them.

use rimline::internals::cpu::{Boundary, Orientation};
use rimline::{Light, Mesh};
use serde_json::{Value, json};

use super::text::Text;

#[derive(Debug, Default)]
pub(super) struct PolygonReport {
    triangles: usize,
    quadrilaterals: usize,
    larger: usize,
    most_corners: usize,
    with_holes: usize,
    nonplanar: usize,
    /// With a corner that is not finite. They are in no other count of how polygons are seen.
    non_finite: usize,
    /// For each light.
    seen: Vec<SeenCounts>,
}

#[derive(Clone, Debug, Default)]
struct SeenCounts {
    facing: usize,
    back_facing: usize,
    in_plane: usize,
    twisted: usize,
}

impl PolygonReport {
    /// `None` if all faces are triangles.
    pub(super) fn of_mesh(mesh: &Mesh, positions: &[[f32; 3]], lights: &[Light]) -> Option<Self> {
        let polygons = mesh.polygons()?;
        let mut report = Self { seen: vec![SeenCounts::default(); lights.len()], ..Self::default() };
        for polygon in 0..polygons.len() {
            let loops = polygons.loops(polygon);
            report.with_holes += usize::from(loops.len() > 1);
            let corners = loops.map(<[u32]>::len).sum::<usize>();
            report.most_corners = report.most_corners.max(corners);
            *match corners {
                ..=3 => &mut report.triangles,
                4 => &mut report.quadrilaterals,
                _ => &mut report.larger,
            } += 1;
            let Some(boundary) = Boundary::new(polygons.boundary(polygon), positions) else {
                report.non_finite += 1;
                continue;
            };
            report.nonplanar += usize::from(!boundary.is_planar());
            for (counts, light) in report.seen.iter_mut().zip(lights) {
                *match boundary.orientation(light.to_array()).0 {
                    Orientation::FrontFacing => &mut counts.facing,
                    Orientation::BackFacing => &mut counts.back_facing,
                    Orientation::InPlane => &mut counts.in_plane,
                    Orientation::Twisted => &mut counts.twisted,
                } += 1;
            }
        }
        Some(report)
    }

    pub(super) fn json(&self) -> Value {
        let seen = |counts: &SeenCounts| {
            let SeenCounts { facing, back_facing, in_plane, twisted } = counts;
            json!({ "facing": facing, "averted": back_facing, "in_plane": in_plane, "twisted": twisted })
        };
        json!({
            "triangles": self.triangles,
            "quadrilaterals": self.quadrilaterals,
            "larger": self.larger,
            "most_corners": self.most_corners,
            "with_holes": self.with_holes,
            "nonplanar": self.nonplanar,
            "non_finite": self.non_finite,
            "seen": self.seen.iter().map(seen).collect::<Vec<_>>(),
        })
    }

    /// `are_cut`: the faces are their triangles.
    pub(super) fn text(&self, text: &mut Text, are_cut: bool) {
        let Self { triangles, quadrilaterals, larger, most_corners, with_holes, nonplanar, non_finite, .. } = self;
        let up_to = if *larger > 0 { format!(", {larger} of up to {most_corners}") } else { String::new() };
        text.line("polygons", format_args!("{triangles} of 3 corners, {quadrilaterals} of 4{up_to}"));
        text.more(format_args!("{nonplanar} not planar, {with_holes} with holes"));
        if are_cut {
            text.more("cut into the triangles above; --polygons takes each as one face");
        }
        if *non_finite > 0 {
            text.more(format_args!("{non_finite} with a corner that is not finite"));
        }
        for (number, SeenCounts { facing, back_facing, in_plane, twisted }) in self.seen.iter().enumerate() {
            text.line(
                &format!("light {number}"),
                format_args!(
                    "{facing} facing, {back_facing} averted, {in_plane} in a plane with it, {twisted} twisted"
                ),
            );
        }
    }
}
