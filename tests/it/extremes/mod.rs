//! The audit of `tools/extremes`, which writes `docs/extremes.md`: cases with right values, and relations between pictures of
//! all scenes. It takes minutes; what of it is quick is a test of its own elsewhere (C-20 to C-25, N-10, N-27, N-28).

mod cases;
mod relations;

use std::path::Path;
use std::sync::Mutex;

use halfway::integrator::{Bdpt, Connections, LightTracing, LvcBpt, Method, SpcBpt};

/// A part of the page, and what in it is wrong.
#[derive(Default)]
struct Table {
    text: String,
    faults: Vec<String>,
}

impl Table {
    /// Replaces this part of the page, where that is asked for; what is stopped leaves what it has found.
    fn publish(&self, title: &str, of: usize, done: usize) {
        if std::env::var_os("UPDATE_DOCS").is_none() {
            return;
        }
        // Both tables may be made at the same time.
        static PAGE: Mutex<()> = Mutex::new(());
        let _page = PAGE.lock().expect("no panic");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/extremes.md");
        let page = std::fs::read_to_string(&path).unwrap_or_else(|_| include_str!("page.md").into());
        let heading = format!("## {title}\n");
        let (before, rest) = page.split_once(&heading).unwrap_or((&page, ""));
        let after = rest.find("\n## ").map_or("", |at| &rest[at..]);
        let left_out = if done < of { format!("\n{done} of {of}: it was stopped.\n") } else { String::new() };
        let page = format!("{}\n\n{heading}\n{}{left_out}{after}", before.trim_end(), self.text);
        std::fs::write(path, page).expect("a page");
    }

    fn assert_right(self) {
        assert!(self.faults.is_empty(), "{}", self.faults.join("\n"));
    }
}

/// All integrators, as they are asked for without further settings but for few light paths.
const METHODS: [Method; 5] = [
    Method::Path,
    Method::Bdpt(Bdpt { light_tracing: false }),
    Method::LvcBpt(LvcBpt {
        light_paths: Some(1024),
        connections: Connections::even(2),
        light_tracing: false,
    }),
    Method::SpcBpt(SpcBpt {
        light_paths: Some(1024),
        connections: Connections::even(2),
        light_tracing: false,
    }),
    Method::Light(LightTracing { light_paths: Some(1024) }),
];

#[test]
#[ignore = "minutes: tools/extremes runs it"]
fn the_extremes_have_their_right_values() {
    cases::table().assert_right();
}

#[test]
#[ignore = "minutes: tools/extremes runs it"]
fn the_extremes_keep_their_relations() {
    relations::table().assert_right();
}
