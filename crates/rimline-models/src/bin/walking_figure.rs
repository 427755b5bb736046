//! Writes a walking human figure as a glTF binary: skinned, animated, closed, and made by code alone.
//!
//! `cargo run --release --package rimline-models --bin walking_figure -- OUT.glb`

use std::process::ExitCode;

use rimline_models::figure;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let [out] = arguments.as_slice() else {
        eprintln!("usage: walking_figure OUT.glb");
        return ExitCode::from(2);
    };
    let figure = figure::Figure::new();
    if let Err(error) = std::fs::write(out, figure::glb::encode(&figure)) {
        eprintln!("cannot write {}: {error}", out.display());
        return ExitCode::FAILURE;
    }
    println!(
        "{}: {} faces, {} vertices, {} joints, a walk of {} s",
        out.display(),
        figure.faces.len(),
        figure.positions.len(),
        figure::skeleton::JOINTS.len(),
        figure::walk::DURATION,
    );
    ExitCode::SUCCESS
}
