//! `cargo bench --bench depth_maps`: volumes from depth maps. How many triangles they have where the map's side is doubled, what
//! each phase of a frame takes, detection against the least it could take, and frames against volumes of meshes and a lookup.
//! Words after `--` choose: `growth`, `phases`, `speed` (`--stages` for each stage), `casters` (`--json FILE` for a plot by
//! `rimline bench --depth-maps FILE`). `--rotations N` for another number than 1,000, `--quick` for few of all.

mod casters;
mod growth;
mod phases;
mod scenes;
mod shade;
mod speed;
mod stage;

const SEED: u64 = 16;

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |wanted: &str| arguments.iter().any(|argument| argument == wanted);
    let parts = ["growth", "phases", "speed", "casters"];
    let is_wanted = |part: &str| has(part) || !parts.iter().any(|part| has(part));
    let given = arguments.iter().skip_while(|argument| *argument != "--rotations").nth(1);
    let rotations = given.map(|given| given.parse().map_err(|error| format!("--rotations: {error}"))).transpose()?;
    let rotations = rotations.unwrap_or(if has("--quick") { 20 } else { 1000 });
    let rounds = if has("--quick") { 3 } else { 15 };
    let bench = stage::Bench::new()?;
    println!("{}", bench.gpu.name);
    if is_wanted("growth") {
        growth::measure(&bench, rotations, SEED)?;
    }
    if is_wanted("phases") {
        phases::measure(&bench, rounds, SEED)?;
    }
    if is_wanted("speed") {
        speed::measure(&bench, rounds, SEED)?;
    }
    if is_wanted("casters") {
        let json = arguments.iter().skip_while(|argument| *argument != "--json").nth(1);
        casters::measure(&bench, rounds, json.map(String::as_str))?;
    }
    Ok(())
}
