//! Displacement WGSL: its checks, and what wgpu makes of it for a Vulkan driver.

use naga::back::{PipelineConstants, spv};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use rimline::Displacement;
use rimline::internals::displace::deform_wgsl;
use rimline_testkit::random::Random;

use rimline_testkit::mutate;

const HEAD: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {";

/// Before `displace`, and its statements.
const SEEDS: [(&str, &str); 10] = [
    ("", "return position;"),
    ("", "var p = position; p.y += 0.1 * sin(time + f32(vertex % 7u)); return p;"),
    ("const AMPLITUDE = 0.5;\nvar<private> state: u32;", "state = vertex; return AMPLITUDE * position.zyx;"),
    (
        "@group(1) @binding(0) var<storage, read> wind: array<vec4<f32>>;",
        "let n = arrayLength(&wind); if n == 0u { return position; } return position + wind[vertex % n].xyz;",
    ),
    (
        "struct Wave { direction: vec2<f32>, length: f32, height: f32 }\n@group(1) @binding(0) var<uniform> wave: Wave;",
        "return position + vec3(0.0, wave.height * sin(dot(wave.direction, position.xz) / wave.length), 0.0);",
    ),
    (
        "fn hash(x: u32) -> u32 { var h = x; h ^= h >> 16u; h *= 0x7feb352du; return h ^ (h >> 15u); }",
        "var sum = 0.0; for (var i = 0u; i < 8u; i++) { sum += f32(hash(vertex + i)); } return position + sum * 1e-9;",
    ),
    (
        "const TABLE = array<vec2<f32>, 4>(vec2(0.0, 1.0), vec2(1.0, 0.0), vec2(), vec2(-1.0));",
        "var t = TABLE; return position + vec3(t[vertex & 3u], 0.0);",
    ),
    (
        "alias M = mat3x3<f32>;\nfn turn(a: f32) -> M { return M(cos(a), sin(a), 0, -sin(a), cos(a), 0, 0, 0, 1); }",
        "return turn(time) * position;",
    ),
    (
        "var<workgroup> shared_data: array<atomic<u32>, 16>;\nvar<private> mine: array<array<f32, 8>, 8>;",
        "switch vertex { case 0u, 1u: { return position; } default: { mine[vertex % 8u][1] = time; } } loop { break; } \
         let p = &mine; return position * (*p)[0][0];",
    ),
    (
        "override SCALE: f32 = 2.0;",
        "while false { continue; } if time > 1.0 { } else if time > 2.0 { } return SCALE * position;",
    ),
];

const DICTIONARY: [&str; 48] = [
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    "<",
    ">",
    "-",
    "!",
    "~",
    "&",
    "*",
    "+",
    "<<",
    ">>",
    "=",
    ";",
    ",",
    ".",
    "@",
    "/*",
    "//",
    "array<",
    "array<f32, 4000000000>()",
    "vec4<f32>",
    "ptr<function, ",
    "atomic<u32>",
    "f16",
    "else if time > 0.0 {} ",
    "if true {",
    "loop {",
    "var<private> ",
    "var<workgroup> ",
    "let x = ",
    "const N = ",
    "override ",
    "struct S { a: ",
    "alias A = ",
    "fn f() -> f32 { return ",
    "return ",
    "position",
    "displace(position, vertex, time)",
    "select(",
    "bitcast<u32>(",
    "const_assert ",
    "diagnostic(off, derivative_uniformity);",
    "_ = ",
];

pub(crate) struct Seeds(Vec<String>);

impl Seeds {
    pub(crate) fn new() -> Self {
        Self(SEEDS.iter().map(|(before, statements)| format!("{before}\n{HEAD}\n    {statements}\n}}\n")).collect())
    }

    pub(crate) fn case(&self, random: &mut Random) -> String {
        let mut text = self.0[random.below(self.0.len())].clone();
        if random.below(4) == 0 {
            // The text before the function of another seed.
            let other = &self.0[random.below(self.0.len())];
            text.insert_str(0, other.split(HEAD).next().unwrap_or_default());
        }
        for _ in 0..=random.below(4) {
            mutate::text(&mut text, &DICTIONARY, random);
        }
        text
    }
}

pub(crate) fn run(text: &str) -> Result<bool, String> {
    let displacement = match Displacement::new(text) {
        Ok(displacement) => displacement,
        Err(error) if error.to_string().len() > 4000 => return Err(format!("a long message: {error:.500}")),
        Err(_) => return Ok(false),
    };
    // Accepted means that it makes a pipeline.
    let module = naga::front::wgsl::parse_str(&deform_wgsl(&displacement)).map_err(|error| error.to_string())?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module);
    let info = info.map_err(|error| error.to_string())?;
    let (module, info) =
        naga::back::pipeline_constants::process_overrides(&module, &info, None, &PipelineConstants::default())
            .map_err(|error| format!("overrides: {error}"))?;
    spv::write_vec(&module, &info, &spv::Options::default(), None).map_err(|error| format!("SPIR-V: {error}"))?;
    Ok(true)
}
