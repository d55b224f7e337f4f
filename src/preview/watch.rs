//! Files that are looked at now and then: simple, and right on network drives, too.

use std::path::PathBuf;
use std::time::SystemTime;

/// The scene's files.
pub struct Watch {
    files: Vec<PathBuf>,
    seen: Vec<Option<(SystemTime, u64)>>,
    /// Has changed, and may change again: files are written in pieces.
    unsettled: bool,
}

impl Watch {
    pub fn new(files: Vec<PathBuf>) -> Self {
        let mut watch = Self { files, seen: Vec::new(), unsettled: false };
        watch.seen = watch.look();
        watch
    }

    fn look(&self) -> Vec<Option<(SystemTime, u64)>> {
        let state = |path: &PathBuf| {
            let data = std::fs::metadata(path).ok()?;
            Some((data.modified().ok()?, data.len()))
        };
        self.files.iter().map(state).collect()
    }

    /// True once after each change, when the files are all there and have kept still since the last look.
    pub fn has_changed(&mut self) -> bool {
        let now = self.look();
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
    fn a_change_is_told_once_it_is_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("scene.glb");
        std::fs::write(&file, "one").expect("written");
        let mut watch = Watch::new(vec![file.clone()]);
        let mut looks = |steps: &[&dyn Fn()]| -> Vec<bool> {
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
        assert_eq!(looks(&[&nothing, &nothing]), [false, false]);
        // Growing is not over; keeping still is, once.
        assert_eq!(
            looks(&[&write("two and"), &write("two and more"), &nothing, &nothing]),
            [false, false, true, false]
        );
        // Written anew under the same name, as many programs do: gone for a moment.
        let remove = || std::fs::remove_file(&file).expect("removed");
        assert_eq!(
            looks(&[&remove, &nothing, &write("three"), &nothing, &nothing]),
            [false, false, false, true, false]
        );
    }
}
