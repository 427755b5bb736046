//! Outlines in a renderer that has its own passes: lines over its picture of a walking figure, hidden behind its depth.
//! Writes `outline_drop_in.png`. Run it with `cargo run --release --example outline_drop_in`.

#[path = "../support/stage.rs"]
mod stage;
#[path = "../support/mod.rs"]
mod support;

use rimline::gltf::{Asset, LoadOptions};
use rimline::gpu::{Deformer, DeformerOptions, Extractor, ExtractorOptions, ShadowFormat};
use rimline::gpu::{OutlineFormat, OutlineInputs, OutlinePipeline, OutlineSource, OutlineStyle};
use rimline::{DepthDirection, Light, ShadowCamera, wgpu};
use rimline_models::figure;
use stage::{COLOR, Camera, Lamp, Stage};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Yours: a device, a renderer that leaves its depth, and a skinned model.
    let canvas = support::Canvas::new(640)?;
    let device = &canvas.device;
    let camera = Camera::new([2.1, 1.9, 3.6], [0.0, 0.86, 0.0], 30.0);
    let lamp = Lamp { light: Light::directional([0.4, 1.0, 0.9]), color: [0.95, 0.90, 0.82] };
    let stage = Stage::new(&canvas, &camera, &[lamp], ShadowFormat::default().light_pass_depth_stencil());
    let asset = Asset::from_slice(&figure::glb::encode(&figure::Figure::new()), None, LoadOptions::default())?;
    let pose = asset.pose([0], 0.3)?;
    let deformer = Deformer::new(device, asset.model(), DeformerOptions::default())?;
    let mesh = asset.model().mesh(&pose)?;
    let bodies = [stage.body(deformer.positions().buffer, mesh.faces())];

    // Once: a pipeline. Once a mesh: an extractor.
    let outlines = OutlinePipeline::new(device, &OutlineFormat { color: COLOR, ..OutlineFormat::default() })?;
    let mut extractor = Extractor::new(device, &mesh, ExtractorOptions::default())?;

    // Every frame: move the vertices, extract what the eye sees, draw yours, then the lines. Nothing is read back.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    deformer.encode(&mut encoder, &pose)?;
    let eye = Light::point(camera.eye);
    let extraction = &extractor.encode(&mut encoder, deformer.positions(), &[eye])?;
    stage.draw_part(&mut encoder, 0, &bodies, |_, _| Ok::<_, std::convert::Infallible>(()))?;
    let Camera { eye: origin, view_projection } = camera;
    let camera = &ShadowCamera { view_projection, origin, depth: DepthDirection::Reversed };
    let style = OutlineStyle { width: 6.0, ..OutlineStyle::default() };
    let depth = &stage.depth();
    let of = OutlineSource::Extraction(extraction, 0);
    let outline = outlines.prepare(&OutlineInputs { of, camera, depth, style, marked: None })?;
    outline.draw(&mut stage.overlay(&mut encoder))?;
    stage.develop(&mut encoder);
    canvas.save(encoder, "outline_drop_in.png")
}
