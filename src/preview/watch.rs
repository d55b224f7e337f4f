//! Files that are looked at now and then: simple, and right on network drives, too.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use super::Settings;

/// The scene's files.
pub struct Watch {
    settings: Arc<Settings>,
    seen: Vec<Option<(SystemTime, u64)>>,
    /// Has changed, and may change again: files are written in pieces.
    unsettled: bool,
}

impl Watch {
    pub fn new(settings: &Arc<Settings>) -> Self {
        let mut watch = Self { settings: settings.clone(), seen: Vec::new(), unsettled: false };
        watch.seen = watch.look();
        watch
    }

    fn look(&self) -> Vec<Option<(SystemTime, u64)>> {
        let state = |path: &PathBuf| {
            let data = std::fs::metadata(path).ok()?;
            Some((data.modified().ok()?, data.len()))
        };
        self.settings.files.iter().map(state).collect()
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
