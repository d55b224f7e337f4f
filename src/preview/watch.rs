//! Checks from time to time whether files have changed: simple, and right on network drives, too.

use std::path::PathBuf;
use std::time::SystemTime;

/// See the module.
pub struct Watch {
    files: Vec<PathBuf>,
    seen: Vec<Option<(SystemTime, u64)>>,
    /// Has changed, and may change again: files are written in pieces.
    unsettled: bool,
}

impl Watch {
    pub fn new(files: Vec<PathBuf>) -> Self {
        let mut watch = Self { files, seen: Vec::new(), unsettled: false };
        watch.seen = watch.states();
        watch
    }

    /// When each was changed, and its size; `None`: it is not there.
    fn states(&self) -> Vec<Option<(SystemTime, u64)>> {
        let state = |path: &PathBuf| {
            let data = std::fs::metadata(path).ok()?;
            Some((data.modified().ok()?, data.len()))
        };
        self.files.iter().map(state).collect()
    }

    /// True once after each change, when all files are there and have not changed since the last call.
    pub fn has_changed(&mut self) -> bool {
        let now = self.states();
        let same = now == self.seen;
        let whole = now.iter().all(Option::is_some);
        let changed = self.unsettled && same && whole;
        self.unsettled = !changed && (self.unsettled || !same);
        self.seen = now;
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_reported_once_it_is_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("scene.glb");
        std::fs::write(&file, "one").expect("written");
        let mut watch = Watch::new(vec![file.clone()]);
        let mut changes = |steps: &[&dyn Fn()]| -> Vec<bool> {
            steps
                .iter()
                .map(|step| {
                    step();
                    watch.has_changed()
                })
                .collect()
        };
        let write = |text: &'static str| {
            let file = file.clone();
            move || std::fs::write(&file, text).expect("written")
        };
        let nothing = || {};
        assert_eq!(changes(&[&nothing, &nothing]), [false, false]);
        // Growing is not over; keeping still is, once.
        assert_eq!(
            changes(&[&write("two and"), &write("two and more"), &nothing, &nothing]),
            [false, false, true, false]
        );
        // Written again under the same name, as many programs do: gone for a moment.
        let remove = || std::fs::remove_file(&file).expect("removed");
        assert_eq!(
            changes(&[&remove, &nothing, &write("three"), &nothing, &nothing]),
            [false, false, false, true, false]
        );
    }
}
