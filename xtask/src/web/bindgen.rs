//! Makes the JavaScript of a compiled program: `bindgen PROGRAM FOLDER`. `cargo xtask web` makes a package of this file.

use std::process::ExitCode;

fn main() -> ExitCode {
    let [program, folder] = [1, 2].map(|index| std::env::args_os().nth(index).unwrap_or_default());
    let made = wasm_bindgen_cli_support::Bindgen::new()
        .input_path(program)
        .out_name("rimline")
        .web(true)
        .and_then(|bindgen| bindgen.typescript(false).remove_name_section(true).remove_producers_section(true).generate(folder));
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
