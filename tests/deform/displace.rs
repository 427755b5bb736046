//! A displacement's errors name the caller's own line, and what is accepted makes a pipeline.

use rimline::Displacement;
use rimline::displace::DisplaceError;
use rimline::internals::displace::deform_wgsl;

const GOOD: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position; }";

fn error(source: &str) -> DisplaceError {
    Displacement::new(source).expect_err(source)
}

fn wgsl_error_at(source: &str, expected_line: u32, word: &str) {
    match error(source) {
        DisplaceError::Wgsl { line, column, message } => {
            assert_eq!(line, expected_line, "column {column}: {message}\n{source}");
            assert!(message.contains(word), "{message:?} does not say {word:?}");
        }
        other => panic!("{other:?}\n{source}"),
    }
}

#[test]
fn good_displacements_are_taken() {
    for (source, uses_resources) in [
        (GOOD.to_owned(), false),
        (format!("// a comment to the end without a newline\n{GOOD} // and one"), false),
        (format!("fn helper(x: f32) -> f32 {{ return sin(x); }}\n{GOOD}"), false),
        (format!("const AMPLITUDE = 0.5;\nvar<private> state: u32;\n{GOOD}"), false),
        (format!("@group(1) @binding(0) var<uniform> wind: vec4<f32>;\n{GOOD}"), true),
        (
            format!(
                "@group(1) @binding(0) var<storage, read> a: array<f32>;\n@group(1) @binding(1) var<storage, read_write> b: array<f32>;\n{GOOD}"
            ),
            true,
        ),
    ] {
        let displacement = Displacement::new(&source).expect(&source);
        assert_eq!(displacement.uses_resources(), uses_resources, "{source}");
        assert!(deform_wgsl(&displacement).starts_with(&source), "line numbers hold");
    }
}

#[test]
fn wgsl_errors_point_at_the_line() {
    wgsl_error_at("\n\nfn displace(", 3, "expected");
    wgsl_error_at(
        "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {\n  let p = position;\n  return p + nothing;\n}",
        3,
        "nothing",
    );
    wgsl_error_at(
        "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {\n  let i: i32 = 1.5;\n  return position;\n}",
        2,
        "",
    );
    // Found by validation, not by parsing: a function that does not return on every path.
    wgsl_error_at(
        "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {\n  if (time > 0.0) { return position; }\n}",
        1,
        "",
    );
    wgsl_error_at("/* never ends", 1, "");
    wgsl_error_at("\u{0}\u{1}", 1, "");
}

#[test]
fn names_of_the_stage_itself_collide_at_the_callers_line() {
    for name in ["chunk", "rest", "positions", "deform", "transform", "pose_row", "DeformChunk", "DeformDispatch"] {
        wgsl_error_at(&format!("\n{GOOD}\nfn {name}(x: f32) -> f32 {{ return x; }}"), 3, name);
        wgsl_error_at(&format!("const {name} = 1u;\n{GOOD}"), 1, name);
    }
}

#[test]
fn signatures_are_checked() {
    for (source, expected_line) in [
        ("fn displace(position: vec3<f32>, vertex: u32) -> vec3<f32> { return position; }", 1),
        ("\nfn displace(position: vec3<f32>, vertex: i32, time: f32) -> vec3<f32> { return position; }", 2),
        ("fn displace(position: vec4<f32>, vertex: u32, time: f32) -> vec3<f32> { return position.xyz; }", 1),
        ("fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec4<f32> { return position.xyzz; }", 1),
        ("fn displace(position: vec3<f32>, vertex: u32, time: f32) { }", 1),
        (
            "// two\n// lines\nfn displace(time: f32, vertex: u32, position: vec3<f32>) -> vec3<f32> { return position; }",
            3,
        ),
    ] {
        match error(source) {
            DisplaceError::Signature { line } => assert_eq!(line, expected_line, "{source}"),
            other => panic!("{other:?}\n{source}"),
        }
    }
    assert_eq!(error(""), DisplaceError::Missing);
    assert_eq!(error("fn displaced() {}"), DisplaceError::Missing);
}

#[test]
fn resources_belong_in_group_one() {
    for group in [0, 2, 3] {
        let source = format!("{GOOD}\n@group({group}) @binding(0) var<uniform> wind: vec4<f32>;");
        let expected = DisplaceError::Group { line: 2, name: "wind".to_owned(), group };
        assert_eq!(error(&source), expected);
    }
}

#[test]
fn entry_points_are_refused() {
    let source = format!("{GOOD}\n@compute @workgroup_size(1) fn own() {{}}");
    assert_eq!(error(&source), DisplaceError::EntryPoint { name: "own".to_owned() });
}

/// Nothing gives them values, so the pipeline could not be made.
#[test]
fn overrides_without_a_default_are_refused_at_their_line() {
    wgsl_error_at(&format!("{GOOD}\noverride AMPLITUDE: f32;"), 2, "AMPLITUDE");
    Displacement::new(&format!("{GOOD}\noverride AMPLITUDE: f32 = 2.0;")).expect("a default is enough");
}

/// naga computes overrides only for a pipeline, which a number out of range would fail.
#[test]
fn overrides_that_come_to_no_number_are_refused() {
    let powers = |count| vec!["SCALE"; count].join(" * ");
    let source = |count| {
        let head = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32>";
        format!("override SCALE: f32 = 2.0;\n{head} {{ return {} * position; }}", powers(count))
    };
    Displacement::new(&source(100)).expect("2^100 is a float");
    wgsl_error_at(&source(200), 1, "infinite");
}
