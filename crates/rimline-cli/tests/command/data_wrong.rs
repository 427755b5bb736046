//! Cases with a wrong expectation fail, and facts of pictures that would be misread.

use super::data::{check, differences};
use super::run::folder;
use super::{Outcome, Test, ensure, facts};

pub(crate) const TESTS: &[Test] = &[
    ("data::a_wrong_expectation_fails::archives", archives),
    ("data::a_wrong_expectation_fails::pictures", pictures),
    ("data::a_wrong_expectation_fails::masks", masks),
    ("data::a_wrong_expectation_fails::misread", misread),
];

/// A part of a case, and the wrong text that replaces it.
type Wrong = (&'static str, &'static str);

const ARCHIVES: &str = "a case
make t.npz tetrahedron
npz points.npz
  points <f4 (1, 3) 0.1 0.1 0.1

$ rimline query t.npz --points points.npz --light dir:1,0,0 --device cpu --out {} --json
0 a.npz
json /points 1
json /adapter \"cpu\"
files a.npz
array a.npz depth <i4 (1, 1) 1
size points.npz 258
lacks a.npz:origin
entries a.npz points lights depth
0 b.npz
same a.npz b.npz
4 no/such";

const WRONG_ARCHIVES: &[Wrong] = &[
    ("0 a.npz", "2 a.npz"),
    ("cannot be written", "cannot be read"),
    ("! rimline: error: no/such", "! rimline: no/such"),
    ("json /points 1", "json /points 2"),
    ("json /points 1", "json /points > 1"),
    ("json /adapter \"cpu\"", "json /adapter \"gpu\""),
    ("json /adapter \"cpu\"", "jsn /adapter \"cpu\""),
    ("files a.npz", "files"),
    ("files a.npz", "lacks a.npz"),
    ("files a.npz", "has b.npz"),
    ("files a.npz", "says nothing"),
    ("files a.npz", "hides points"),
    ("(1, 1) 1", "(1, 1) 2"),
    ("(1, 1) 1", "(1, 2) 1"),
    ("depth <i4", "depth <u4"),
    ("size points.npz 258", "size points.npz 259"),
    ("lacks a.npz:origin", "lacks a.npz:depth"),
    ("entries a.npz points lights", "entries a.npz lights points"),
    ("same a.npz b.npz", "other a.npz b.npz"),
    ("0.1 0.1 0.1", "9 0.1 0.1"),
];

const PICTURES: &str = "a case
make t.npz tetrahedron
$ rimline draw t.npz --size 20x10 --eye 3,2,4 --out p.png
$ rimline draw t.npz --size 20x10 --eye 4,2,3 --out q.png
> wrote [..]
size p.png 20x10
count p.png ink > 4
apart p.png q.png > 4 by 9";

const WRONG_PICTURES: &[Wrong] = &[
    ("> wrote [..]", "> wrote nothing"),
    ("> wrote [..]", "> [..]\n> ...\n> more"),
    ("size p.png 20x10", "size p.png 10x20"),
    ("count p.png ink > 4", "count p.png ink > 200"),
    ("> 4 by 9", "< 4 by 9"),
];

const MASKS: &str = "a case
make t.npz tetrahedron
$ rimline shadow t.npz --light dir:0,1,0 --size 20x10 --mask m --out r.png
pixel m.0.png 0,0 255
count m.0.png 255 > 9
values m.0.png 255
apart m.0.png m.0.png = 0";

const WRONG_MASKS: &[Wrong] = &[
    ("0,0 255", "0,0 128"),
    ("m.0.png 255 > 9", "m.0.png 255 < 9"),
    ("m.0.png 255 > 9", "r.png 255 > 9"),
    ("values m.0.png 255", "values m.0.png 128 255"),
    ("m.0.png m.0.png = 0", "m.0.png m.0.png > 0"),
];

fn passes(case: &str) -> Outcome {
    differences(case, &check(case)?)
}

/// The case, completed by a first run as `RIMLINE_CASES=write` does, passes, and with each wrong part it fails.
fn negative(case: &str, all_wrong: &[Wrong]) -> Result<String, String> {
    let right = check(case)?;
    passes(&right)?;
    for &(part, wrong) in all_wrong {
        ensure!(right.contains(part), "the case lacks `{part}`");
        let changed = right.replacen(part, wrong, 1);
        ensure!(passes(&changed).is_err(), "`{wrong}` passed instead of `{part}`");
    }
    Ok(right)
}

fn archives() -> Outcome {
    let right = negative(ARCHIVES, WRONG_ARCHIVES)?;
    ensure!(right.contains("! rimline: error: no/such: cannot be written"), "{right}");
    let shown = passes(&right.replace("cannot be written", "cannot be read")).err().unwrap_or_default();
    let signs = [
        "\n-4 no/such ! rimline: error: no/such: cannot be read",
        "\n+4 no/such ! rimline: error: no/such: cannot be written",
    ];
    ensure!(signs.iter().all(|line| shown.contains(line)), "the difference is not shown: {shown}");
    Ok(())
}

fn pictures() -> Outcome {
    negative(PICTURES, WRONG_PICTURES).map(drop)
}

fn masks() -> Outcome {
    negative(MASKS, WRONG_MASKS).map(drop)
}

/// Pictures of other kinds, and comparisons of other shapes.
fn misread() -> Outcome {
    use png::{BitDepth, ColorType, Encoder, EncodingError};
    let folder = folder();
    let write = |name: &str, [width, height]: [u32; 2], color: ColorType, depth: BitDepth, values: &[u8]| -> Outcome {
        let text = |error: EncodingError| error.to_string();
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().map_err(text)?;
        writer.write_image_data(values).map_err(text)?;
        writer.finish().map_err(text)?;
        folder.write(name, bytes)
    };
    write("rgba.png", [1, 1], ColorType::Rgba, BitDepth::Eight, &[0; 4])?;
    write("deep.png", [1, 1], ColorType::Grayscale, BitDepth::Sixteen, &[0; 2])?;
    write("wide.png", [2, 1], ColorType::Grayscale, BitDepth::Eight, &[0; 2])?;
    write("tall.png", [1, 2], ColorType::Grayscale, BitDepth::Eight, &[0; 2])?;
    facts::check(&folder, "", &[], "apart wide.png wide.png = 0")?;
    for fact in ["values rgba.png 0", "values deep.png 0", "apart wide.png tall.png = 0"] {
        ensure!(facts::check(&folder, "", &[], fact).is_err(), "`{fact}` holds");
    }
    Ok(())
}
