//! Pages are true where a program can check it: README has every integrator, the catalogue every numbered test, and
//! links lead somewhere.

use std::collections::BTreeSet;
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

/// The number that the name of a test begins with, `n05_watertight` as N-05.
fn number(line: &str) -> Option<String> {
    let (kind, rest) = line.trim_start().strip_prefix("fn ")?.split_at_checked(1)?;
    let (digits, name) = rest.split_at_checked(2)?;
    let is_number =
        "ncrs".contains(kind) && digits.bytes().all(|b| b.is_ascii_digit()) && name.starts_with('_');
    is_number.then(|| format!("{}-{digits}", kind.to_uppercase()))
}

/// Every number of a test is explained in docs/tests.md, with the test's module beside it, and no other number is.
#[test]
fn the_catalogue_is_complete() {
    let mut found = BTreeSet::new();
    let mut open = vec![root().join("tests/it")];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(
                fs::read_dir(&path).expect("a readable folder").map(|entry| entry.expect("an entry").path()),
            );
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let inside =
                path.strip_prefix(root().join("tests/it")).expect("inside the folder").with_extension("");
            let module = inside.iter().next().expect("a name").to_string_lossy().into_owned();
            found.extend(page(&path).lines().filter_map(number).map(|number| (number, module.clone())));
        }
    }
    let catalogue = page(&root().join("docs/tests.md"));
    let rows = catalogue.lines().filter_map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let numbered = cells.len() == 4 && cells[0].as_bytes().get(1) == Some(&b'-') && cells[0].len() == 4;
        numbered.then(|| (cells[0], cells[3]))
    });
    let listed = rows.flat_map(|(number, modules)| {
        let modules = modules.split('`').skip(1).step_by(2).filter(|module| !module.contains('/'));
        modules.map(move |module| (number.to_owned(), module.to_owned()))
    });
    let listed: BTreeSet<(String, String)> = listed.collect();
    let missing: Vec<_> = found.difference(&listed).collect();
    let gone: Vec<_> = listed.difference(&found).collect();
    assert!(
        missing.is_empty() && gone.is_empty(),
        "docs/tests.md lacks {missing:?}, and has in vain {gone:?}"
    );
}

#[test]
fn links_anchors_and_numbers_are_found() {
    assert_eq!(links("a [b](c.md#d), ![e](f.png) and [g](https://h.org)"), ["c.md#d", "f.png"]);
    assert_eq!(number("    fn n05_watertight() {").as_deref(), Some("N-05"));
    assert_eq!([number("fn name()"), number("fn n5_x()"), number("let n05_x")], [const { None }; 3]);
    assert_eq!(anchors("# One `two`, three\ntext\n## A-b's (c)\n"), ["one-two-three", "a-bs-c"]);
}
