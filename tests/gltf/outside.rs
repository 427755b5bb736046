//! Files that a glTF names: only those in its folder are read, wherever links and `..` lead, unless the caller lets the
//! others in.

use std::path::{Path, PathBuf};

use libtest_mimic::Trial;
use rimline::gltf::{Asset, GltfError, LoadOptions};
use rimline::mesh::Weld;
use serde_json::json;

use crate::maker::Maker;
use crate::rows::uri;
use crate::{Outcome, ensure, same, test};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        test("outside::by_name", by_name),
        test("outside::by_link", by_link),
        test("outside::names_with_percent_signs", percent),
        test("outside::a_caller_that_gives_files_is_asked_for_any_path", given),
        test("outside::images_are_not_read", images),
    ]
}

/// A folder `top` with `secret.bin`, and in it a folder `model` with `own.bin`: both hold the square's bytes.
struct Folders {
    top: tempfile::TempDir,
    maker: Maker,
}

impl Folders {
    fn new() -> Result<Self, std::io::Error> {
        let (top, maker) = (tempfile::tempdir()?, Maker::square());
        std::fs::create_dir_all(top.path().join("model/below"))?;
        std::fs::write(top.path().join("secret.bin"), &maker.bytes)?;
        std::fs::write(top.path().join("model/own.bin"), &maker.bytes)?;
        Ok(Self { top, maker })
    }

    fn model(&self) -> PathBuf {
        self.top.path().join("model")
    }

    fn load(&self, name: &str, allow_outside: bool) -> Result<Asset, GltfError> {
        let mut maker = self.maker.clone();
        uri(&mut maker, name);
        let path = self.model().join("model.gltf");
        std::fs::write(&path, maker.json.to_string()).expect("a folder that was made");
        Asset::open(&path, LoadOptions { allow_outside, ..Weld::Keep.into() })
    }

    /// Refused, and the path that it leads to is named; let in where the caller says so.
    fn is_outside(&self, name: &str, leads_to: &Path) -> Outcome {
        let expected =
            GltfError::Outside { json_path: "buffers[0].uri".to_owned(), uri: name.to_owned(), path: leads_to.into() };
        same(&self.load(name, false).map(|_| ()), &Err(expected), name)?;
        same(self.load(name, true)?.model(), self.maker.load()?.model(), name)
    }
}

fn by_name() -> Outcome {
    let folders = Folders::new()?;
    for name in ["own.bin", "./own.bin", "below/../own.bin", "below/./../own.bin"] {
        folders.load(name, false)?;
    }
    for name in ["../secret.bin", "below/../../secret.bin", "./../secret.bin", "../model/own.bin"] {
        folders.is_outside(name, Path::new(name))?;
    }
    // An absolute path; on Windows it has a drive's letter, which is refused as a scheme.
    let rooted = folders.top.path().join("secret.bin");
    if cfg!(unix) {
        folders.is_outside(&rooted.to_string_lossy(), &rooted)?;
    }
    // A missing file cannot be resolved. A path outside is refused before it is looked up.
    let found = [("none.bin", false), ("../none.bin", false), ("../none.bin", true)];
    match found.map(|(name, allow)| folders.load(name, allow)) {
        [Err(GltfError::Read { path, .. }), Err(GltfError::Outside { .. }), Err(GltfError::Read { .. })]
            if path.ends_with("model/none.bin") =>
        {
            Ok(())
        }
        other => Err(format!("{other:?}").into()),
    }
}

#[cfg(unix)]
fn by_link() -> Outcome {
    use std::os::unix::fs::symlink;
    let folders = Folders::new()?;
    let secret = folders.top.path().join("secret.bin").canonicalize()?;
    symlink("../secret.bin", folders.model().join("link.bin"))?;
    symlink(&secret, folders.model().join("rooted.bin"))?;
    symlink("link.bin", folders.model().join("second.bin"))?;
    symlink("../..", folders.model().join("below/up"))?;
    for name in ["link.bin", "rooted.bin", "second.bin", "below/up/secret.bin"] {
        folders.is_outside(name, &secret)?;
    }
    // A folder whose name begins like the glTF's.
    std::fs::create_dir(folders.top.path().join("model2"))?;
    let other = folders.top.path().join("model2/own.bin");
    std::fs::copy(&secret, &other)?;
    symlink("../model2", folders.model().join("beside"))?;
    folders.is_outside("beside/own.bin", &other.canonicalize()?)?;
    // Links that stay, and a link to the glTF's folder itself.
    symlink("own.bin", folders.model().join("stays.bin"))?;
    symlink("model", folders.top.path().join("entry"))?;
    folders.load("stays.bin", false)?;
    Asset::open(folders.top.path().join("entry/model.gltf"), Weld::Keep)?;
    Ok(())
}

#[cfg(not(unix))]
fn by_link() -> Outcome {
    Ok(())
}

/// A name that was written as it is, with percent signs. If there is a file with the decoded name, it is that one.
fn percent() -> Outcome {
    let folders = Folders::new()?;
    let file = |name: &str, bytes: &[u8]| std::fs::write(folders.model().join(name), bytes);
    file("a%20b.bin", &folders.maker.bytes)?;
    same(folders.load("a%20b.bin", false)?.model(), folders.maker.load()?.model(), "the name as it is")?;
    file("a b.bin", &[])?;
    let result = folders.load("a%20b.bin", false).map(|_| ());
    ensure(matches!(result, Err(GltfError::Invalid { .. })), || format!("the decoded name has no bytes: {result:?}"))?;
    // A name that leads outside once it is decoded is refused before.
    file("..%2Fsecret.bin", &folders.maker.bytes)?;
    folders.is_outside("..%2Fsecret.bin", Path::new("../secret.bin"))?;
    // The caller is asked for both.
    let mut maker = Maker::square();
    uri(&mut maker, "a%20b.bin");
    for asked in ["a%20b.bin", "a b.bin"] {
        let find = |path: &str| (path == asked).then(|| maker.bytes.clone());
        Asset::from_slices(maker.json.to_string().as_bytes(), &find, Weld::Keep)?;
    }
    Ok(())
}

/// Paths outside and absolute ones come to the caller as the glTF has them, with percent signs decoded, by default too.
fn given() -> Outcome {
    let mut maker = Maker::square();
    let expected = maker.load()?;
    for (name, asked) in [
        ("own.bin", "own.bin"),
        ("../secret.bin", "../secret.bin"),
        ("below/%2E%2E/../secret.bin", "below/../../secret.bin"),
        ("/secret.bin", "/secret.bin"),
    ] {
        uri(&mut maker, name);
        let find = |path: &str| (path == asked).then(|| maker.bytes.clone());
        let asset = Asset::from_slices(maker.json.to_string().as_bytes(), &find, Weld::Keep)?;
        same(asset.model(), expected.model(), name)?;
    }
    Ok(())
}

/// A picture outside is no reason to refuse a model: nothing of it is read.
fn images() -> Outcome {
    let mut maker = Maker::square();
    maker.json["images"] =
        json!([{ "uri": "../../nowhere.png" }, { "uri": "/dev/zero" }, { "uri": "https://a/b.png" }]);
    maker.json["textures"] = json!([{ "source": 0 }]);
    let asset = maker.load()?;
    ensure(asset.warnings().is_empty(), || format!("{:?}", asset.warnings()))
}
