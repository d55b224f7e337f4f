//! Where the library may be.

use std::env;
use std::path::{Path, PathBuf};

/// The variable that names the library, or its folder.
const VARIABLE: &str = "HALFWAY_OIDN";

/// As the dynamic linker knows version 2.
const FILE: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_os = "macos") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// Paths to try, in order. What the user names is the only one then; the last is no path but a name, which the system
/// looks for.
pub(super) fn places() -> Vec<PathBuf> {
    if let Some(named) = env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        return vec![within(Path::new(&named))];
    }
    let executable = env::current_exe().ok();
    let beside = executable.as_deref().and_then(Path::parent).map(within);
    let data = env::var_os("XDG_DATA_HOME").map(PathBuf::from).filter(|folder| folder.is_absolute());
    let data = data.or_else(|| env::home_dir().map(|home| home.join(".local/share")));
    // Where `tools/setup --denoiser` puts it.
    let set_up = data.map(|data| data.join("halfway/oidn/lib").join(FILE));
    let mut places: Vec<PathBuf> = beside.into_iter().chain(set_up).filter(|path| path.exists()).collect();
    places.push(PathBuf::from(FILE));
    places
}

/// The library's file: the path itself, or in the folder that it leads to.
fn within(path: &Path) -> PathBuf {
    let candidates = [path.join(FILE), path.join("lib").join(FILE)];
    let found = candidates.into_iter().find(|candidate| path.is_dir() && candidate.exists());
    found.unwrap_or_else(|| if path.is_dir() { path.join(FILE) } else { path.to_owned() })
}
