//! Which file uses which: by its `use` lines and by the paths in its code.
//!
//! A path leads to the file that defines what it names: what `mod.rs` re-exports is looked for where it comes from. So a
//! `mod.rs` that only declares its children and shows them to others uses none of them, and none of them uses it by being
//! used through it; what it re-exports it uses where its code has the name.
//!
//! A child is a part of its parent: it sees all of it, and may hold a part of what is implemented for its types. That it
//! uses the `mod.rs` of a folder it is in makes no cycle among files. Among rooms, the folders of `src`, it counts.

use std::collections::{BTreeMap, BTreeSet};

use super::tokens::{tokens, without_tests};

type Path = Vec<String>;

/// A `use`, taken apart.
#[derive(Debug, PartialEq)]
struct Use {
    path: Path,
    /// What it is called in its file; `None` of `*` and `_`.
    name: Option<String>,
    public: bool,
}

struct File {
    /// Of its own: `src/scene/gltf/mod.rs` is scene, gltf.
    module: Path,
    uses: Vec<Use>,
    /// Paths in code.
    paths: Vec<Path>,
    /// All identifiers in code.
    words: BTreeSet<String>,
}

/// Files by their names, such as `src/scene/mod.rs`.
pub struct Program {
    files: BTreeMap<String, File>,
    modules: BTreeMap<Path, String>,
}

/// One file uses what is in another, by this path.
pub type Edges = BTreeMap<(String, String), BTreeSet<String>>;

/// The modules between the root of the crate and the code in a file; none of `lib.rs`.
pub fn module_of(name: &str) -> Path {
    let inside = name.strip_prefix("src/").unwrap_or(name);
    let inside = inside.strip_suffix(".rs").unwrap_or(inside);
    let mut module: Path = inside.split('/').map(String::from).collect();
    match module.last().map(String::as_str) {
        Some("mod") => drop(module.pop()),
        Some("lib") if module.len() == 1 => module.clear(),
        _ => {}
    }
    module
}

/// Identifiers joined by `::` from `at` on, and where they end.
fn segments(code: &[&str], mut at: usize) -> (Path, usize) {
    let mut path = vec![code[at].to_string()];
    while code.get(at + 1) == Some(&"::")
        && code.get(at + 2).is_some_and(|next| next.starts_with(|c: char| c.is_alphabetic() || c == '_'))
    {
        path.push(code[at + 2].to_string());
        at += 2;
    }
    (path, at + 1)
}

/// One tree of a `use`, which begins at `at`; where it ends.
fn use_tree(code: &[&str], mut at: usize, stem: &Path, public: bool, found: &mut Vec<Use>) -> usize {
    let mut path = stem.clone();
    loop {
        match code[at] {
            "{" => {
                at += 1;
                while code[at] != "}" {
                    at = use_tree(code, at, &path, public, found);
                    at += usize::from(code[at] == ",");
                }
                return at + 1;
            }
            "*" => {
                found.push(Use { path, name: None, public });
                return at + 1;
            }
            "self" if !path.is_empty() => at += 1,
            "::" => {
                at += 1;
                continue;
            }
            segment => {
                path.push(segment.to_string());
                at += 1;
            }
        }
        if code[at] != "::" {
            let renamed = code[at] == "as";
            let name = if renamed { code[at + 1].to_string() } else { path[path.len() - 1].clone() };
            found.push(Use { path, name: (name != "_").then_some(name), public });
            return at + 2 * usize::from(renamed);
        }
    }
}

fn parse(name: &str, code: &[&str]) -> File {
    let mut file =
        File { module: module_of(name), uses: Vec::new(), paths: Vec::new(), words: BTreeSet::new() };
    let mut at = 0;
    while at < code.len() {
        let before = at.checked_sub(1).map(|before| code[before]);
        if code[at] == "use" {
            let public = before == Some("pub") || before == Some(")");
            at = use_tree(code, at + 1, &Vec::new(), public, &mut file.uses);
        } else if code[at].starts_with(|c: char| c.is_alphabetic())
            && !matches!(before, Some("::" | "." | "$"))
        {
            let (path, end) = segments(code, at);
            file.words.extend(path.iter().cloned());
            if path.len() > 1 {
                file.paths.push(path);
            }
            at = end;
        } else {
            at += 1;
        }
    }
    file
}

impl Program {
    /// Of files with their sources; modules of unit tests do not count.
    pub fn new<'a>(sources: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let files: BTreeMap<String, File> = sources
            .into_iter()
            .map(|(name, source)| (name.to_string(), parse(name, &without_tests(&tokens(source)))))
            .collect();
        let modules = files.iter().map(|(name, file)| (file.module.clone(), name.clone())).collect();
        Self { files, modules }
    }

    /// The path from the crate's root on; `None` of what is not the crate's, or is in scope without being imported.
    fn absolute(&self, file: &File, path: &[String], depth: u32) -> Option<Path> {
        let own = &file.module;
        let (first, rest) = path.split_first()?;
        let child: Path = own.iter().chain([first]).cloned().collect();
        let stem = match first.as_str() {
            "crate" | "halfway" => Vec::new(),
            "self" => own.clone(),
            "super" => {
                let ups = path.iter().take_while(|segment| *segment == "super").count();
                let stem = own[..own.len().checked_sub(ups)?].to_vec();
                return Some([stem, path[ups..].to_vec()].concat());
            }
            _ if self.modules.contains_key(&child) => child,
            _ => self.imported(file, first, depth)?,
        };
        Some([stem, rest.to_vec()].concat())
    }

    /// Where a name of a file comes from.
    fn imported(&self, file: &File, name: &str, depth: u32) -> Option<Path> {
        let import = file.uses.iter().find(|import| import.name.as_deref() == Some(name))?;
        // A crate may have the name of what is imported from it.
        let is_itself = import.path.first().map(String::as_str) == Some(name);
        (depth > 0 && !is_itself).then(|| self.absolute(file, &import.path, depth - 1)).flatten()
    }

    /// The file that defines what a path from the root names; `None` of a module.
    fn definer(&self, path: &[String], depth: u32) -> Option<&String> {
        let known = (0..=path.len()).rev().find(|&length| self.modules.contains_key(&path[..length]))?;
        let parent = known - usize::from(known == path.len() && known > 0);
        let name = &self.modules[&path[..parent]];
        let again = path.get(parent).and_then(|item| self.imported(&self.files[name], item, depth));
        match again {
            Some(again) if depth > 0 && again != path[..=parent] => {
                self.definer(&[&again, &path[parent + 1..]].concat(), depth - 1)
            }
            _ if known == path.len() => None,
            _ => Some(&self.modules[&path[..known]]),
        }
    }

    /// Every path that a file names, from the root on.
    pub fn paths(&self) -> impl Iterator<Item = (&String, Path)> {
        self.files.iter().flat_map(move |(name, file)| {
            let imports = file.uses.iter().filter(|import| {
                let shown = import.public.then(|| self.absolute(file, &import.path, 8)).flatten();
                let is_child = shown.is_some_and(|shown| shown.starts_with(&file.module));
                // What it only shows to others, of its own children.
                !is_child || import.name.as_ref().is_some_and(|name| file.words.contains(name))
            });
            let paths = imports.map(|import| &import.path).chain(&file.paths);
            paths.filter_map(move |path| Some((name, self.absolute(file, path, 8)?)))
        })
    }

    /// Which file uses which.
    pub fn edges(&self) -> Edges {
        let mut edges = Edges::new();
        for (name, path) in self.paths() {
            if let Some(definer) = self.definer(&path, 8).filter(|definer| *definer != name) {
                edges.entry((name.clone(), definer.clone())).or_default().insert(path.join("::"));
            }
        }
        edges
    }
}

/// As between files, but for what a child uses of its parents.
pub fn among_files(edges: &Edges) -> Edges {
    let is_part = |from: &str, to: &str| module_of(from).starts_with(&module_of(to));
    edges
        .iter()
        .filter(|((from, to), _)| !is_part(from, to))
        .map(|(pair, paths)| (pair.clone(), paths.clone()))
        .collect()
}

/// As between the first modules of the crate.
pub fn among_rooms(edges: &Edges) -> Edges {
    let mut rooms = Edges::new();
    for ((from, to), paths) in edges {
        if let [Some(from), Some(to)] = [from, to].map(|name| module_of(name).into_iter().next())
            && from != to
        {
            rooms.entry((from, to)).or_default().extend(paths.iter().cloned());
        }
    }
    rooms
}

/// The files that one uses, directly or not.
fn reached<'a>(start: &'a String, uses: &BTreeMap<&'a String, Vec<&'a String>>) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![start];
    while let Some(from) = open.pop() {
        open.extend(uses.get(from).into_iter().flatten().filter(|to| reached.insert(**to)));
    }
    reached
}

/// The sets of files each of which uses, directly or not, every other one of its set.
pub fn cycles(edges: &Edges) -> Vec<BTreeSet<String>> {
    let mut uses: BTreeMap<&String, Vec<&String>> = BTreeMap::new();
    for (from, to) in edges.keys() {
        uses.entry(from).or_default().push(to);
    }
    let all: BTreeMap<&String, BTreeSet<&String>> =
        uses.keys().map(|from| (*from, reached(from, &uses))).collect();
    let cycle_of = |file: &String| -> BTreeSet<String> {
        let there = all[file].iter();
        there
            .filter(|other| all.get(*other).is_some_and(|back| back.contains(file)))
            .map(|other| other.to_string())
            .collect()
    };
    let found: BTreeSet<BTreeSet<String>> = all.keys().map(|file| cycle_of(file)).collect();
    found.into_iter().filter(|cycle| cycle.len() > 1).collect()
}

/// For people: the files, and by what they use one another.
pub fn describe(cycle: &BTreeSet<String>, edges: &Edges) -> String {
    let inside = edges.iter().filter(|((from, to), _)| cycle.contains(from) && cycle.contains(to));
    let lines = inside.map(|((from, to), paths)| {
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        format!("  {from} -> {to}: {}", paths.join(", "))
    });
    [format!("a cycle of {}:", cycle.len())].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
}

/// A house of four rooms: `a` shows what its children have, `b` uses it, and `c` has items that its child uses.
#[cfg(test)]
const HOUSE: [(&str, &str); 7] = [
    ("src/lib.rs", "pub mod a; pub mod b; pub mod c;"),
    ("src/a/mod.rs", "mod left; mod right; pub use left::{self, Left}; pub use right::Right;"),
    ("src/a/left.rs", "use super::Right; use std::fmt; pub struct Left(fmt::Error, Right);"),
    ("src/a/right.rs", "pub struct Right;"),
    ("src/b.rs", "use crate::{a::{self, Left}, c}; fn f(_: Left) -> a::Right { c::child::g() }"),
    ("src/c/mod.rs", "pub mod child; pub struct Item;"),
    ("src/c/child.rs", "pub fn g() { super::Item }\n#[cfg(test)] mod tests { use crate::b::f; }"),
];

#[test]
fn edges_lead_to_the_file_that_defines() {
    let edges = Program::new(HOUSE).edges();
    let found: Vec<(&str, &str)> = edges.keys().map(|(from, to)| (from.as_str(), to.as_str())).collect();
    assert_eq!(
        found,
        [
            ("src/a/left.rs", "src/a/right.rs"),
            ("src/b.rs", "src/a/left.rs"),
            ("src/b.rs", "src/a/right.rs"),
            ("src/b.rs", "src/c/child.rs"),
            ("src/c/child.rs", "src/c/mod.rs"),
        ]
    );
    assert_eq!(cycles(&edges), Vec::<BTreeSet<String>>::new());
}

#[test]
fn a_cycle_that_is_put_in_is_found() {
    let edges_with = |at: usize, source| {
        let mut house = HOUSE;
        house[at].1 = source;
        Program::new(house).edges()
    };
    let found = |edges: &Edges| -> Vec<Vec<String>> {
        cycles(edges).into_iter().map(|cycle| cycle.into_iter().collect()).collect()
    };
    let siblings = edges_with(3, "use super::Left; pub struct Right(Left);");
    assert_eq!(found(&among_files(&siblings)), [["src/a/left.rs", "src/a/right.rs"]]);
    assert!(describe(&cycles(&siblings)[0], &siblings).contains("a::Left"));
    for used in [
        "pub mod child; pub struct Item; fn h() { child::g() }",
        "pub mod child; pub use child::g; pub struct Item; fn h() { g() }",
    ] {
        let parent = edges_with(5, used);
        assert_eq!(found(&parent), [["src/c/child.rs", "src/c/mod.rs"]], "{used}");
        assert_eq!(
            found(&among_files(&parent)),
            Vec::<Vec<String>>::new(),
            "a child is a part of its parent"
        );
    }
    let rooms = edges_with(5, "pub mod child; pub struct Item; use crate::b; fn h() { b::f() }");
    assert_eq!(found(&among_files(&rooms)), Vec::<Vec<String>>::new());
    assert_eq!(found(&among_rooms(&rooms)), [["b", "c"]]);
}
