//! The pages are true where a program can tell: README has every integrator, and links lead somewhere.

use std::fs;
use std::path::{Path, PathBuf};

use halfway::integrator::METHODS;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All Markdown pages that a reader of the repository meets.
fn pages() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in [root().to_owned(), root().join("docs"), root().join("scenes")] {
        let entries = fs::read_dir(folder).expect("a readable folder");
        found.extend(entries.map(|entry| entry.expect("a readable entry").path()));
    }
    found.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    found.sort();
    found
}

/// The anchors that a page offers, as code hosts make them of headings: lower case, hyphens, nothing but words.
fn anchors(page: &str) -> Vec<String> {
    let anchor = |heading: &str| {
        let kept = heading.trim().to_lowercase().replace(' ', "-");
        kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
    };
    page.lines()
        .filter(|line| line.starts_with('#'))
        .map(|line| anchor(line.trim_start_matches('#')))
        .collect()
}

/// What stands in the brackets of `[text](target)`, of this repository alone.
fn links(page: &str) -> Vec<&str> {
    let targets = page.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.contains("://")).collect()
}

/// The rows of the integrators' table are the descriptors', in the order of `--help`.
#[test]
fn readme_describes_every_integrator() {
    let rows: Vec<String> = METHODS
        .iter()
        .map(|method| format!("| `{}` | {} | {} |\n", method.name, method.how, method.suits))
        .collect();
    let table = format!("| name | how | suits |\n|---|---|---|\n{}\n", rows.concat());
    assert!(
        page(&root().join("README.md")).contains(&table),
        "README.md needs this table, and no other row:\n\n{table}"
    );
}

/// Every link to a file of the repository leads to one, and every anchor to a heading.
#[test]
fn links_lead_somewhere() {
    let mut faults = Vec::new();
    let mut checked = 0;
    for path in pages() {
        let text = page(&path);
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.with_file_name(file) };
            let offers = || anchors(&page(&target)).iter().any(|heading| heading == anchor);
            if !target.exists() || !(anchor.is_empty() || offers()) {
                faults.push(format!("{}: {link}", path.display()));
            }
            checked += 1;
        }
    }
    assert!(checked > 30, "only {checked} links were found");
    assert!(faults.is_empty(), "these lead nowhere:\n{}", faults.join("\n"));
}

#[test]
fn links_and_anchors_are_found() {
    assert_eq!(links("a [b](c.md#d), ![e](f.png) and [g](https://h.org)"), ["c.md#d", "f.png"]);
    assert_eq!(anchors("# One `two`, three\ntext\n## A-b's (c)\n"), ["one-two-three", "a-bs-c"]);
}
