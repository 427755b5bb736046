//! Base colours of materials and vertices, and what becomes of them where vertices are welded.

use libtest_mimic::Trial;
use rimline::gltf::{Asset, Colors};
use rimline::mesh::Weld;
use serde_json::json;

use crate::check::warned_once;
use crate::maker::{F32, Maker, SQUARE, U8, U16};
use crate::rows::primitive;
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("colors::white_is_none", || same(&Maker::square().load()?.colors(0), &None, "colours")),
        test("colors::factors_of_two_primitives", factors),
        test("colors::all_component_types", component_types),
        test("colors::numbers_that_are_no_colours", clamped),
        test("colors::welded_vertices_keep_theirs", welded),
        test("colors::seams_give_means", seams),
        test("colors::the_first_of_shared_positions", shared),
    ]
}

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];
const WHITE: [f32; 3] = [1.0; 3];

fn colors(asset: &Asset) -> Colors {
    asset.colors(0).cloned().unwrap_or_default()
}

fn material(maker: &mut Maker, factor: [f32; 4]) -> usize {
    maker.push("materials", json!({ "pbrMetallicRoughness": { "baseColorFactor": factor } }))
}

/// The second primitive has a colour, and the third none.
fn factors() -> Outcome {
    let mut maker = Maker::square();
    let mut second = primitive(&mut maker).clone();
    let third = second.clone();
    second["material"] = json!(material(&mut maker, [1.0, 0.0, 0.0, 0.5]));
    let primitives = maker.json["meshes"][0]["primitives"].as_array_mut().ok_or("a list")?;
    primitives.extend([second, third]);
    let expected = Colors { faces: Some(vec![WHITE, WHITE, RED, RED, WHITE, WHITE]), vertices: None };
    same(&colors(&maker.load()?), &expected, "colours")
}

/// The same colours, with and without alpha.
fn component_types() -> Outcome {
    let single = |v: f32| v.to_le_bytes().to_vec();
    let [of_f32, of_u8, of_u16]: [&dyn Fn(f32) -> Vec<u8>; 3] =
        [&single, &|v| vec![(v * 255.0) as u8], &|v| ((v * 65535.0) as u16).to_le_bytes().to_vec()];
    for (component, bytes) in [(F32, of_f32), (U8, of_u8), (U16, of_u16)] {
        for (kind, width) in [("VEC3", 3), ("VEC4", 4)] {
            let mut maker = Maker::square();
            let all = [[1.0, 0.0, 0.0, 0.2], [0.0, 0.2, 1.0, 1.0], [1.0; 4], [0.6, 0.0, 0.0, 0.0]];
            let data: Vec<u8> = all.iter().flat_map(|color| &color[..width]).flat_map(|&v| bytes(v)).collect();
            let accessor = maker.accessor(component, kind, 4, &data);
            maker.json["accessors"][accessor]["normalized"] = json!(component != F32);
            primitive(&mut maker)["attributes"]["COLOR_0"] = json!(accessor);
            let expected = all.map(|[red, green, blue, _]| [red, green, blue]).to_vec();
            same(&colors(&maker.load()?), &Colors { faces: None, vertices: Some(expected) }, kind)?;
        }
    }
    Ok(())
}

fn with_colors(mut maker: Maker, colors: &[[f32; 3]]) -> Maker {
    let accessor = maker.floats("VEC3", colors.as_flattened());
    primitive(&mut maker)["attributes"]["COLOR_0"] = json!(accessor);
    maker
}

fn clamped() -> Outcome {
    let given = [[f32::NAN, -1.0, 2.0], [f32::INFINITY, f32::NEG_INFINITY, 0.5], WHITE, WHITE];
    let mut maker = with_colors(Maker::square(), &given);
    primitive(&mut maker)["material"] = json!(material(&mut maker, [7.0, 0.5, -0.0, 1.0]));
    let vertices = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.5], WHITE, WHITE];
    let expected = Colors { faces: Some(vec![[1.0, 0.5, 0.0]; 2]), vertices: Some(vertices) };
    same(&colors(&maker.load()?), &expected, "colours")
}

/// Two triangles with six vertices.
fn soup(colors: [[f32; 3]; 6]) -> Maker {
    let mut maker = Maker::new();
    let corners = [0, 1, 2, 0, 2, 3].map(|corner| [0, 1, 2].map(|axis| SQUARE[3 * corner + axis]));
    let positions = maker.floats("VEC3", corners.as_flattened());
    maker.mesh(&json!({ "attributes": { "POSITION": positions } }));
    maker.push("nodes", json!({ "mesh": 0 }));
    with_colors(maker, &colors)
}

fn welded() -> Outcome {
    let maker = soup([RED, BLUE, WHITE, RED, WHITE, BLUE]);
    let expected = Colors { faces: None, vertices: Some(vec![RED, BLUE, WHITE, BLUE]) };
    let asset = Asset::from_slice(&maker.glb(), None, Weld::Data)?;
    same(&asset.model().geometries()[0].faces().to_vec(), &vec![[0, 1, 2], [0, 2, 3]], "faces")?;
    same(&colors(&asset), &expected, "colours")?;
    same(&colors(&maker.load()?).vertices.map(|all| all.len()), &Some(6), "vertices that are not welded")
}

fn seams() -> Outcome {
    let mut maker = soup([RED, RED, RED, RED, BLUE, BLUE]);
    let asset = Asset::from_slice(&maker.glb(), None, Weld::Data)?;
    same(&asset.model().geometries()[0].positions().len(), &4, "vertices")?;
    let mixed = [1.0 / 3.0, 0.0, 2.0 / 3.0];
    same(&colors(&asset), &Colors { faces: Some(vec![RED, mixed]), vertices: None }, "colours")?;
    primitive(&mut maker)["material"] = json!(material(&mut maker, [0.5, 1.0, 1.0, 1.0]));
    let halved = [RED, mixed].map(|[red, green, blue]| [0.5 * red, green, blue]);
    same(&colors(&maker.load()?).faces, &Some(halved.to_vec()), "colours with a material")
}

fn shared() -> Outcome {
    let mut maker = with_colors(Maker::square(), &[RED, BLUE, RED, BLUE]);
    let mut second = primitive(&mut maker).clone();
    second["attributes"].as_object_mut().ok_or("an object")?.remove("COLOR_0");
    maker.json["meshes"][0]["primitives"].as_array_mut().ok_or("a list")?.push(second);
    let asset = maker.load()?;
    warned_once(&asset, &["meshes[0].primitives[1]: COLOR_0 differs"])?;
    ensure(colors(&asset).vertices == Some(vec![RED, BLUE, RED, BLUE]), || format!("{:?}", colors(&asset)))
}
