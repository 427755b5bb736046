//! Lists, for messages, of a file's items of one kind: index and name of each.

use rimline::gltf::{AnimationInfo, Asset};

/// The file's animations.
pub(crate) fn listed_animations(asset: &Asset) -> String {
    format!("the file has {}", listed("animation", asset.animations().iter().map(|info| info.name.as_deref())))
}

/// Lists what there is of a kind: `2 lights: 0 (without a name), 1 `sun``.
pub(crate) fn listed<'a>(kind: &str, names: impl ExactSizeIterator<Item = Option<&'a str>>) -> String {
    const SHOWN: usize = 20;
    let count = names.len();
    let (plural, more) = (if count == 1 { "" } else { "s" }, if count > SHOWN { ", …" } else { "" });
    if count == 0 {
        return "none".into();
    }
    let shown: Vec<String> = names.take(SHOWN).enumerate().map(|(index, name)| numbered(index, name)).collect();
    format!("{count} {kind}{plural}: {}{more}", shown.join(", "))
}

/// A number, and the name if there is one.
fn numbered(index: usize, name: Option<&str>) -> String {
    name.map_or_else(|| format!("{index} (without a name)"), |name| format!("{index} `{name}`"))
}

/// An animation's number, and its name if it has one.
pub(crate) fn animation_name(index: usize, info: &AnimationInfo) -> String {
    numbered(index, info.name.as_deref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names() {
        assert_eq!(listed("light", [].into_iter()), "none");
        assert_eq!(listed("light", [Some("sun")].into_iter()), "1 light: 0 `sun`");
        assert_eq!(listed("light", [None, Some("sun")].into_iter()), "2 lights: 0 (without a name), 1 `sun`");
        let many = listed("light", vec![None; 30].into_iter());
        assert!(many.starts_with("30 lights: 0 ") && many.ends_with("19 (without a name), …"), "{many}");
    }
}
