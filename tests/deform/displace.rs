//! A displacement's errors name the caller's own line, and what is accepted makes a pipeline. Those that would end the process in
//! naga, or crash a driver, are refused by name before either sees them.

use rimline::Displacement;
use rimline::displace::DisplaceError;
use rimline::internals::displace::{MAX_FUNCTION_BYTES, MAX_NESTING, MAX_PRIVATE_BYTES, MAX_SOURCE_BYTES, deform_wgsl};

const GOOD: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position; }";

/// `displace` with these statements, after `before`.
fn displace(before: &str, statements: &str) -> String {
    let body = format!("{{ {statements} return position; }}");
    format!("{before}\n{}", GOOD.replace("{ return position; }", &body))
}

#[track_caller]
fn wgsl_error_at(source: &str, expected_line: u32, word: &str) {
    match Displacement::new(source) {
        Err(DisplaceError::Wgsl { line, message, .. }) => {
            assert_eq!(line, expected_line, "{message}\n{source:.300}");
            assert!(message.contains(word), "{message:?} does not say {word:?}");
        }
        other => panic!("{other:?}\n{source:.300}"),
    }
}

#[track_caller]
fn refused(source: &str, word: &str) {
    match Displacement::new(source) {
        Err(error @ DisplaceError::TooLarge { needed, limit, .. }) => {
            assert!(needed > limit && error.to_string().contains(word), "{error} does not say {word:?}");
        }
        other => panic!("{other:?}, expected too much of {word:?}\n{source:.300}"),
    }
}

#[track_caller]
fn accepted(source: &str) {
    if let Err(error) = Displacement::new(source) {
        panic!("{error}\n{source:.300}");
    }
}

#[test]
fn good_displacements_are_taken() {
    let buffers = "@group(1) @binding(0) var<storage, read> a: array<f32>;\n@group(1) @binding(1) var<storage, read_write> b: array<f32>;";
    for (before, uses_resources) in [
        ("// a comment to the end without a newline", false),
        ("fn helper(x: f32) -> f32 { return sin(x); }", false),
        ("const AMPLITUDE = 0.5;\nvar<private> state: u32;", false),
        ("override AMPLITUDE: f32 = 2.0;", false),
        ("@group(1) @binding(0) var<uniform> wind: vec4<f32>;", true),
        (buffers, true),
    ] {
        let source = format!("{before}\n{GOOD} // and one");
        let displacement = Displacement::new(&source).expect(&source);
        assert_eq!(displacement.uses_resources(), uses_resources, "{source}");
        assert!(deform_wgsl(&displacement).starts_with(&source), "line numbers hold");
    }
}

#[test]
fn wgsl_errors_point_at_the_line() {
    wgsl_error_at("\n\nfn displace(", 3, "expected");
    wgsl_error_at(&displace("\n", "\nlet p = position + nothing;"), 4, "nothing");
    wgsl_error_at(&displace("", "\nlet i: i32 = 1.5;"), 3, "");
    // Found by validation, not by parsing: a function that does not return on every path.
    wgsl_error_at(&GOOD.replace("{ return", "{\n  if (time > 0.0) { return").replace("; }", "; }\n}"), 1, "");
    wgsl_error_at("/* never ends", 1, "");
    wgsl_error_at("\u{0}\u{1}", 1, "");
    // Names of the stage itself.
    for name in ["chunk", "rest", "positions", "deform", "transform", "pose_row", "DeformChunk", "DeformDispatch"] {
        wgsl_error_at(&format!("\n{GOOD}\nfn {name}(x: f32) -> f32 {{ return x; }}"), 3, name);
        wgsl_error_at(&format!("const {name} = 1u;\n{GOOD}"), 1, name);
    }
    // Nothing gives it a value, so the pipeline could not be made.
    wgsl_error_at(&format!("{GOOD}\noverride AMPLITUDE: f32;"), 2, "AMPLITUDE");
    wgsl_error_at(&format!("const A = B;\nconst B = A;\n{GOOD}"), 1, "cyclic");
    // naga computes overrides only for a pipeline, which a number out of range would fail: 2^100 is a float.
    let powers = |count| {
        let returned = format!("return {} * position", vec!["SCALE"; count].join(" * "));
        format!("override SCALE: f32 = 2.0;\n{}", GOOD.replace("return position", &returned))
    };
    accepted(&powers(100));
    wgsl_error_at(&powers(200), 1, "infinite");
}

#[test]
fn signatures_entry_points_and_groups_are_checked() {
    let error = |source: &str| Displacement::new(source).expect_err(source);
    for (from, to) in [
        (", time: f32", ""),
        ("vertex: u32", "vertex: i32"),
        ("vec3<f32>, v", "vec4<f32>, v"),
        (" -> vec3<f32> { return position; }", " { }"),
        ("position: vec3<f32>, vertex: u32, time: f32", "time: f32, vertex: u32, position: vec3<f32>"),
    ] {
        let source =
            format!("// two\n// lines\n{}", GOOD.replace(from, to).replace("return position", "return vec3<f32>()"));
        assert_eq!(error(&source), DisplaceError::Signature { line: 3 }, "{source}");
    }
    let wide = GOOD.replace("-> vec3<f32> { return position; }", "-> vec4<f32> { return position.xyzz; }");
    assert_eq!(error(&wide), DisplaceError::Signature { line: 1 });
    assert_eq!(error(""), DisplaceError::Missing);
    assert_eq!(error("fn displaced() {}"), DisplaceError::Missing);
    for group in [0, 2, 3] {
        let source = format!("{GOOD}\n@group({group}) @binding(0) var<uniform> wind: vec4<f32>;");
        assert_eq!(error(&source), DisplaceError::Group { line: 2, name: "wind".to_owned(), group });
    }
    let source = format!("{GOOD}\n@compute @workgroup_size(1) fn own() {{}}");
    assert_eq!(error(&source), DisplaceError::EntryPoint { name: "own".to_owned() });
}

/// Each of these nests as deep as it is long: brackets, unary and binary operators, indices, `else if`, blocks.
fn nested(depth: usize) -> Vec<String> {
    let around =
        |open: &str, middle: &str, close: &str| format!("{}{middle}{}", open.repeat(depth), close.repeat(depth));
    let value = |text: &str| displace("", &format!("let x = {text};"));
    vec![
        value(&around("(", "time", ")")),
        value(&around("- ", "time", "")),
        value(&around("!", "(time > 0.0)", "")),
        value(&around("", "time", " + time")),
        value(&around("abs(", "time", ")")),
        value(&around("", "vec2<f32>(1.0, 1.0).xy", ".xy")),
        displace("", &around("{", "", "}")),
        displace("", &format!("if time > 0.0 {{ }} {}", "else if time > 1.0 { } ".repeat(depth))),
        displace("", &around("if time > 0.0 { ", "", "}")),
        displace("", &around("loop { ", "break;", "break; }")),
    ]
}

/// With 500,000 operators naga overflows a stack of 8 MiB, which ends the process.
#[test]
fn nesting_is_refused_before_it_is_parsed() {
    for source in nested(3000) {
        refused(&source, if source.len() > MAX_SOURCE_BYTES { "source" } else { "within each other" });
    }
    for source in nested(MAX_NESTING as usize + 1) {
        refused(&source, "within each other");
    }
    for source in nested(20) {
        accepted(&source);
    }
    // naga has bounds of its own below this one; what matters is that it comes back, with the stack of a test.
    for depth in [60, 120, MAX_NESTING as usize - 15] {
        for source in nested(depth) {
            drop(Displacement::new(&source));
        }
    }
    // The end of a bracket ends its nesting.
    accepted(&displace("", &"_ = abs(1.0 * (2.0 + time)) + vec3<f32>(1.0, 2.0, 3.0).x;\n".repeat(400)));
    accepted(&displace("", &"if time > 0.0 { _ = -1.0; } else if time > 1.0 { _ = 2.0; }\n".repeat(400)));
    accepted(&displace("", &format!("_ = array({});", "1.0 + 2.0,".repeat(1000))));
}

/// naga cites a word of any length: the fuzzer found messages of 50,000 characters.
#[test]
fn long_source_is_refused_and_messages_stay_short() {
    refused(&displace("", &"_ = time;\n".repeat(MAX_SOURCE_BYTES / 10)), "source");
    refused(&displace(&"const a = 1;\n".repeat(2000), ""), "declarations");
    for source in [displace(&"fn".repeat(20_000), ""), displace(&format!("@{}", "é".repeat(20_000)), "")] {
        let message = Displacement::new(&source).expect_err("it is no WGSL").to_string();
        assert!(message.chars().count() < 600, "{} characters", message.chars().count());
    }
}

/// naga lists the elements of a constant array, four bytes each: 16 GB here. The fuzzer found that the lengths of arrays in their
/// own lengths were followed for minutes.
#[test]
fn arrays_of_constants_are_refused_before_they_are_listed() {
    let source = |count: &str| {
        displace("const N = 4000000000u; const M = 60000;", &format!("const a = -array<i32, {count}>(); _ = a[0];"))
    };
    for count in ["4294967295", "4000000000u", "N", "65536 * 65535", "M * M"] {
        refused(&source(count), "elements");
    }
    // The length may be anything, so the error states no number of elements.
    let chain: Vec<String> = (1..40).map(|n| format!("const N{n} = N{0} * N{0} * N{0};\n", n - 1)).collect();
    let chain = chain.concat();
    for source in [
        source("1 << 30"),
        displace(&format!("const N = {} 1;", "array<u32, N> + ".repeat(30)), ""),
        displace(&format!("const N0 = 1;\n{chain} var<private> a: array<f32, N39>;"), ""),
    ] {
        let refusal = Displacement::new(&source);
        assert!(matches!(refusal, Err(DisplaceError::ArrayLength { line: 1.. })), "{refusal:?}");
    }
}

/// naga copies all elements of a constant into a function that reads one. With 28 short lines there are 2^28.
#[test]
fn constants_that_double_are_refused_before_they_are_copied() {
    let lines: Vec<String> = (1..18).map(|n| format!("const A{n} = array(A{0}, A{0});\n", n - 1)).collect();
    let reversed: String = lines.iter().rev().cloned().collect();
    let (ordered, read) = (lines.concat(), "_ = A17[0];");
    // Other names, of one more character.
    let others = (1..18).map(|n| format!("const A{n}\u{301} = 1u;\n")).collect::<Vec<_>>().concat();
    // Members with the names of constants that need these.
    let members = (1..12).map(|n| format!("A{n}: i32, ")).collect::<Vec<_>>().concat();
    let of_members = |n: i32| format!("const A{n} = array(A{0}, array(A{0}, A{0})[Q().A{1}]);\n", n - 1, n + 1);
    let of_members: String = (1..11).map(of_members).collect();
    for source in [
        displace(&format!("const A0 = 1u; {ordered}"), read),
        displace(&format!("{reversed} const A0 = 1u;"), read),
        displace("", &format!("const A0 = 1u; {ordered} {read}")),
        displace(&format!("const A0 = 1u; //\r{}", ordered.replace('\n', " ")), read),
        displace(&format!("const A0 = 1u; //\u{2028}{}", ordered.replace('\n', " ")), read),
        displace(&format!("const A0 = 1u; {}", ordered.replace("const ", "const \u{200e}")), read),
        displace(&format!("{reversed} const A0 = 1u; {others}"), read),
        displace(&format!("struct Q {{ {members} }} const A0 = 1u; {of_members}"), "_ = A10[0];"),
        displace(
            "const A = array(1u, 1u);",
            &format!("{} _ = A[0]; {}", "{ const A = array(A, A); ".repeat(17), "}".repeat(17)),
        ),
    ] {
        refused(&source, "constants");
    }
    // It makes a list of all elements for each of these sums, which are wrong, and goes on.
    let long = "array<i32, 60000>";
    for (before, zero) in [
        (format!("const Z = {long}();"), "Z"),
        (format!("alias Z = {long};"), "Z()"),
        (format!("struct Z {{ z: {long} }}"), "Z()"),
    ] {
        let sums = format!("_ = {zero} + {zero};\n").repeat(100);
        refused(&displace(&before, &format!("{{ const Z = 1; }} {sums}")), "constants");
    }
    accepted(&displace(&format!("const A0 = 1u; {}", lines[..7].concat()), &"_ = A7[0];\n".repeat(100)));
}

/// Drivers inline functions: twice as much with each of the last ones.
#[test]
fn variables_of_megabytes_are_refused_before_a_driver_sees_them() {
    let limit = MAX_PRIVATE_BYTES / 4;
    accepted(&displace(&format!("var<private> a: array<f32, {limit}>;"), "a[vertex] = time;"));
    refused(&displace(&format!("var<private> a: array<f32, {}>;", limit + 1), "a[vertex] = time;"), "private");
    refused(&displace("var<private> a: array<array<f32, 1000>, 1000>;", "a[vertex][vertex] = time;"), "private");
    refused(&displace("var<private> a: array<f32, 2000>; var<private> b: array<f32, 2000>;", ""), "private");
    refused(&displace("var<workgroup> a: array<f32, 4097>;", "a[vertex] = time;"), "workgroup");
    // Only defaults say how long it is.
    refused(&displace("override M = 4096; var<workgroup> a: array<f32, M + 1>;", "a[vertex] = time;"), "workgroup");
    accepted(&displace("override M = 4095; var<workgroup> a: array<f32, M + 1>;", "a[vertex] = time;"));
    let limit = MAX_FUNCTION_BYTES / 4;
    accepted(&displace("", &format!("var a: array<f32, {limit}>; a[vertex] = time;")));
    refused(&displace("", &format!("var a: array<f32, {}>; a[vertex] = time;", limit + 1)), "variables in a function");
    refused(&displace("", "_ = array<array<f32, 1000>, 1000>()[vertex][vertex];"), "one value");
    refused(&displace("const A = array<array<f32, 1000>, 1000>();", "_ = A[0][0];"), "one value");
    let storage = "@group(1) @binding(0) var<storage, read> a: array<f32, 60000>;";
    accepted(&displace(storage, "_ = a[vertex];"));
    refused(&displace(storage, "let all = a; _ = all[vertex];"), "one value");
    let variables = "fn g(x: f32) -> f32 { var a: array<f32, 1000>; a[u32(x)] = x; return a[0]; }";
    accepted(&displace(variables, "_ = g(time);"));
    refused(&displace(variables, "_ = g(time) + g(1.0) + g(2.0);"), "variables in a function");
    let calls = |levels: usize| {
        let double =
            |n: usize| format!("fn call_{}(x: f32) -> f32 {{ return call_{n}(x) + call_{n}(x + 1.0); }}\n", n + 1);
        let functions: String = (0..levels).map(double).collect();
        let before = format!("fn call_0(x: f32) -> f32 {{ return sin(x); }}\n{functions}");
        displace(&before, &format!("_ = call_{levels}(time);"))
    };
    accepted(&calls(8));
    refused(&calls(40), "operations");
}
