//! Is there a Vulkan driver? If not, install Mesa's software one.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::packages::Manager;
use crate::process;

/// Makes sure that there is a driver. macOS has Metal and Windows Direct3D 12, so only Linux and its like need one.
pub(crate) fn ensure() -> Result<(), String> {
    if cfg!(any(target_os = "macos", target_os = "windows")) || is_there() {
        return Ok(());
    }
    let Some(manager) = Manager::of_this_system() else {
        return Err(
            "no Vulkan driver found, and this distribution is not one that this program knows; install a Vulkan \
             loader (libvulkan.so.1) and a driver, such as Mesa's software driver lavapipe, and try again"
                .into(),
        );
    };
    println!("No Vulkan driver found; installing Mesa's software driver.");
    manager.install("Vulkan driver", manager.vulkan)?;
    let line = manager.one_command(manager.vulkan);
    if is_there() { Ok(()) } else { Err(format!("`{line}` succeeded, but there still is no Vulkan driver")) }
}

fn is_there() -> bool {
    has_loader() && has_driver()
}

/// Whether the loader is where the dynamic linker looks.
fn has_loader() -> bool {
    const LOADER: &str = "libvulkan.so.1";
    // Not on an ordinary user's PATH on Debian.
    let lists = ["ldconfig", "/sbin/ldconfig", "/usr/sbin/ldconfig"];
    let mut known = lists.iter().filter_map(|ldconfig| process::output(Command::new(ldconfig).arg("-p")).ok());
    let mut folders: Vec<PathBuf> =
        env::var_os("LD_LIBRARY_PATH").map_or_else(Vec::new, |paths| env::split_paths(&paths).collect());
    // Without a cache that ldconfig lists, the linker looks in these.
    for folder in ["/usr/lib", "/usr/lib64", "/usr/local/lib", "/usr/local/lib64", "/lib", "/lib64"] {
        folders.push(folder.into());
        // Debian's directory for the architecture.
        folders.extend(entries(Path::new(folder)).filter(|path| path.to_string_lossy().ends_with("-linux-gnu")));
    }
    known.any(|list| list.contains(LOADER)) || folders.iter().any(|folder| folder.join(LOADER).exists())
}

/// Whether some driver's manifest is installed that can work here: a software driver's, or any beside a GPU.
fn has_driver() -> bool {
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        // The loader looks nowhere else then, and the user knows what they want.
        if let Some(files) = env::var_os(variable) {
            return env::split_paths(&files).any(|file| file.exists());
        }
    }
    let is_software = |manifest: &PathBuf| {
        let name = manifest.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        ["lvp", "lavapipe", "swiftshader"].iter().any(|driver| name.contains(driver))
    };
    let manifests = manifests();
    manifests.iter().any(is_software) || (!manifests.is_empty() && has_gpu())
}

/// The manifests of installed drivers, where the loader looks for them.
pub(crate) fn manifests() -> Vec<PathBuf> {
    let home = env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
    let of = |variable: &str, otherwise: PathBuf| {
        let value = env::var_os(variable).filter(|value| !value.is_empty()).unwrap_or_else(|| otherwise.into());
        env::split_paths(&value).collect::<Vec<_>>()
    };
    let mut bases = of("XDG_CONFIG_HOME", home.join(".config"));
    bases.extend(of("XDG_DATA_HOME", home.join(".local/share")));
    bases.extend(of("XDG_CONFIG_DIRS", "/etc/xdg".into()));
    bases.extend(of("XDG_DATA_DIRS", "/usr/local/share:/usr/share".into()));
    bases.extend(["/etc", "/usr/local/etc", "/usr/local/share", "/usr/share"].map(PathBuf::from));
    let files = bases.iter().flat_map(|base| entries(&base.join("vulkan/icd.d")));
    files.filter(|path| path.extension().is_some_and(|extension| extension == "json")).collect()
}

/// Whether the kernel offers a GPU: distributions install all of Mesa's manifests on every machine.
fn has_gpu() -> bool {
    let is_render_node =
        |node: PathBuf| node.file_name().is_some_and(|name| name.to_string_lossy().starts_with("renderD"));
    let nodes = ["/dev/nvidia0", "/dev/dxg", "/dev/mali0", "/dev/kgsl-3d0"];
    entries(Path::new("/dev/dri")).any(is_render_node) || nodes.iter().any(|node| Path::new(node).exists())
}

fn entries(directory: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    std::fs::read_dir(directory).into_iter().flatten().flatten().map(|entry| entry.path())
}
