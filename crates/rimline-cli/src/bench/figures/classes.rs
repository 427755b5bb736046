//! Descriptions of the classes of scenes.

use super::super::bench_mesh::ORDINARY;
use super::super::results::Results;
use super::super::text::grouped;
use crate::page::{Figure, Table};

/// Each class in the order of the scenes, with what makes it hard.
const CLASSES: [(&str, &str); 11] = [
    (ORDINARY, "Smooth closed meshes (tori), lights all around. Nothing is hard here."),
    (
        "translation",
        "A body far from the origin; the number is how far. Neighbouring floats lie far apart there, so products of \
         coordinates are rounded coarsely.",
    ),
    ("scale", "A very small or very large body; the number is its size. Products underflow or overflow in f32."),
    (
        "subnormal",
        "A body, or only its thickness, so small that its coordinates are subnormal floats, which have few bits and \
         which GPUs may take as zero.",
    ),
    ("slivers", "Long thin triangles; the number is the longest edge divided by the height above it."),
    (
        "plate",
        "Flat plates with lights in the plane of their faces: a third of the lights, or all. Only exact arithmetic \
         says on which side such a light is.",
    ),
    ("lights", "Lights in hard places: inside the body, on a vertex, on an edge, on a face, in the plane of a face."),
    (
        "afar",
        "A sphere far from its lights, which are near the origin; the number is the distance. Its coordinates have few \
         bits left for its own shape.",
    ),
    ("bent", "A limb that is bent until it folds into itself; the number is the angle in degrees."),
    (
        "noise",
        "A plate with lights in its plane, whose vertices are moved off it at random; the number is by how much. Every \
         face is nearly edge on, each otherwise.",
    ),
    (
        "topology",
        "Meshes that a modelling program should not have let through: faces without area, boxes that touch, a Möbius \
         strip, three faces on an edge.",
    ),
];

/// A table of the classes that were measured.
pub(super) fn classes(results: &Results) -> Figure {
    let rows = CLASSES.iter().filter_map(|(class, what)| {
        let mut names: Vec<String> = Vec::new();
        for row in results.rows.iter().filter(|row| row.subject.class == *class) {
            let name = match row.subject.class {
                ORDINARY => format!("{} faces", grouped(row.subject.faces)),
                _ => row.subject.name.clone(),
            };
            if !names.contains(&name) {
                names.push(name);
            }
        }
        (!names.is_empty()).then(|| vec![(*class).to_owned(), (*what).to_owned(), names.join("; ")])
    });
    Figure {
        id: "classes",
        title: "Classes of scenes".to_owned(),
        lead: "Plots and tables name scenes by these classes. Numbers in a scene's name say how hard it is.".to_owned(),
        chart: None,
        table: Table {
            head: ["Class", "What makes it hard", "Scenes measured"].map(str::to_owned).into(),
            rows: rows.collect(),
            is_prose: true,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_class_is_explained_in_the_order_of_the_scenes() {
        let mut there = vec![ORDINARY];
        there.extend(rimline_bench::stress::scenes(1).map(|scene| scene.class));
        there.dedup();
        assert_eq!(CLASSES.map(|(class, _)| class).as_slice(), there);
    }
}
