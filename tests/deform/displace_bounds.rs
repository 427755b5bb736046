//! Displacements that would end the process in naga, or crash a driver, are refused by name before either sees them.

use rimline::Displacement;
use rimline::displace::DisplaceError;
use rimline::internals::displace::{MAX_FUNCTION_BYTES, MAX_NESTING, MAX_PRIVATE_BYTES, MAX_SOURCE_BYTES};

/// `displace` with these statements, after `before`.
fn displace(before: &str, statements: &str) -> String {
    format!(
        "{before}\nfn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> {{ {statements} return position; }}"
    )
}

#[track_caller]
fn refused(source: &str, word: &str) {
    match Displacement::new(source) {
        Err(error @ DisplaceError::TooLarge { needed, limit, .. }) => {
            assert!(needed > limit, "{error}");
            assert!(error.to_string().contains(word), "{error} does not say {word:?}");
        }
        Err(error) => panic!("{error}, expected too much of {word:?}\n{source:.300}"),
        Ok(_) => panic!("it is accepted, expected too much of {word:?}\n{source:.300}"),
    }
}

#[track_caller]
fn accepted(source: &str) {
    if let Err(error) = Displacement::new(source) {
        panic!("{error}\n{source:.300}");
    }
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
        value(&around("vec2<f32>(1.0, 1.0).xy", "", ".xy").replacen("vec2<f32>(1.0, 1.0).xy", "", depth - 1)),
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
}

#[test]
fn the_end_of_a_bracket_ends_its_nesting() {
    let sum = "let x = abs(1.0 * (2.0 + time)) + vec3<f32>(1.0, 2.0, 3.0).x;\n".replace("let x", "_");
    accepted(&displace("", &sum.repeat(400)));
    accepted(&displace("", &"if time > 0.0 { _ = -1.0; } else if time > 1.0 { _ = 2.0; }\n".repeat(400)));
    accepted(&displace("", &format!("_ = array({});", "1.0 + 2.0,".repeat(1000))));
}

#[test]
fn long_source_is_refused() {
    refused(&displace("", &"_ = time;\n".repeat(MAX_SOURCE_BYTES / 10)), "source");
    refused(&displace(&"const a = 1;\n".repeat(2000), ""), "declarations");
}

/// naga cites a word of any length: the fuzzer found messages of 50,000 characters.
#[test]
fn messages_stay_short() {
    for source in [displace(&"fn".repeat(20_000), ""), displace(&format!("@{}", "é".repeat(20_000)), "")] {
        let message = Displacement::new(&source).expect_err("it is no WGSL").to_string();
        assert!(message.chars().count() < 600, "{} characters", message.chars().count());
    }
}

/// naga lists the elements of a constant array, four bytes each: 16 GB here.
#[test]
fn arrays_of_constants_are_refused_before_they_are_listed() {
    let source = |count: &str| {
        displace("const N = 4000000000u; const M = 60000;", &format!("const a = -array<i32, {count}>(); _ = a[0];"))
    };
    for count in ["4294967295", "4000000000u", "N", "65536 * 65535", "M * M"] {
        refused(&source(count), "elements");
    }
    unbounded(&source("1 << 30"));
}

/// The length may be anything, so the error states no number of elements.
fn unbounded(source: &str) {
    let refusal = Displacement::new(source);
    assert!(matches!(refusal, Err(DisplaceError::ArrayLength { line: 1.. })), "{refusal:?}");
}

/// The fuzzer found that the lengths of arrays in their own lengths were followed for minutes.
#[test]
fn lengths_that_name_each_other_are_not_followed_for_ever() {
    unbounded(&displace(&format!("const N = {} 1;", "array<u32, N> + ".repeat(30)), ""));
    let chain: Vec<_> = (1..40).map(|n| format!("const N{n} = N{0} * N{0} * N{0};", n - 1)).collect();
    let chain = chain.join("\n");
    unbounded(&displace(&format!("const N0 = 1;\n{chain} var<private> a: array<f32, N39>;"), ""));
}

#[test]
fn variables_of_megabytes_are_refused_before_a_driver_sees_them() {
    let limit = MAX_PRIVATE_BYTES / 4;
    accepted(&displace(&format!("var<private> a: array<f32, {limit}>;"), "a[vertex] = time;"));
    refused(&displace(&format!("var<private> a: array<f32, {}>;", limit + 1), "a[vertex] = time;"), "private");
    refused(&displace("var<private> a: array<array<f32, 1000>, 1000>;", "a[vertex][vertex] = time;"), "private");
    refused(&displace("var<private> a: array<f32, 2000>; var<private> b: array<f32, 2000>;", ""), "private");
    refused(&displace("var<workgroup> a: array<f32, 4097>;", "a[vertex] = time;"), "workgroup");
    let limit = MAX_FUNCTION_BYTES / 4;
    accepted(&displace("", &format!("var a: array<f32, {limit}>; a[vertex] = time;")));
    refused(&displace("", &format!("var a: array<f32, {}>; a[vertex] = time;", limit + 1)), "variables in a function");
    refused(&displace("", "_ = array<array<f32, 1000>, 1000>()[vertex][vertex];"), "one value");
    refused(&displace("const A = array<array<f32, 1000>, 1000>();", "_ = A[0][0];"), "one value");
    let storage = "@group(1) @binding(0) var<storage, read> a: array<f32, 60000>;";
    accepted(&displace(storage, "_ = a[vertex];"));
    refused(&displace(storage, "let all = a; _ = all[vertex];"), "one value");
}

/// Drivers put functions in place of their calls: twice as much with each of these.
#[test]
fn calls_that_multiply_are_refused() {
    let calls = |levels: usize| {
        let double =
            |n: usize| format!("fn call_{}(x: f32) -> f32 {{ return call_{n}(x) + call_{n}(x + 1.0); }}\n", n + 1);
        let functions: String = (0..levels).map(double).collect();
        displace(
            &format!("fn call_0(x: f32) -> f32 {{ return sin(x); }}\n{functions}"),
            &format!("_ = call_{levels}(time);"),
        )
    };
    accepted(&calls(8));
    refused(&calls(40), "operations");
    let variables = "fn g(x: f32) -> f32 { var a: array<f32, 1000>; a[u32(x)] = x; return a[0]; }";
    accepted(&displace(variables, "_ = g(time);"));
    refused(&displace(variables, "_ = g(time) + g(1.0) + g(2.0);"), "variables in a function");
}
