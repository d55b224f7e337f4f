//! The street is one-way: no module uses a layer above its own, no files use each other, methods are told apart in one
//! place, and no file grows beyond reading.

mod imports;
mod methods;
mod tokens;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use imports::{Program, among_files, among_rooms, cycles, describe, module_of};
use methods::{questions, wildcards};

/// Layers from the bottom up; a module may use its own layer and those before it.
const LAYERS: &[&[&str]] = &[
    &["fault", "stdout"],
    &["math"],
    &["picture_file"],
    &["scene"],
    &["accel"],
    &["device"],
    &["film", "subspace"],
    &["integrator"],
    &["training"],
    &["render"],
    &["bench"],
    &["main", "cli", "preview"],
];

const MAX_RUST_LINES: usize = 600;
const MAX_WGSL_LINES: usize = 300;

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|modules| modules.contains(&module))
}

/// All files with that extension below `folder` of the package, sorted; the folder may be absent.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).expect("a readable source file")
}

fn shown(path: &Path) -> String {
    path.strip_prefix(env!("CARGO_MANIFEST_DIR")).expect("inside the package").display().to_string()
}

/// All of `src` by its files' names.
fn sources() -> Vec<(String, String)> {
    files("src", "rs").iter().map(|path| (shown(path), read(path))).collect()
}

fn program(sources: &[(String, String)]) -> Program {
    Program::new(sources.iter().map(|(name, source)| (name.as_str(), source.as_str())))
}

#[test]
fn no_layer_uses_a_higher_one() {
    let mut faults = BTreeSet::new();
    for (name, path) in program(&sources()).paths() {
        let module = module_of(name);
        let (Some(own), Some(used)) = (module.first(), path.first()) else { continue };
        let Some(place) = layer(own) else {
            faults.insert(format!("{name}: `{own}` has no place in LAYERS"));
            continue;
        };
        if layer(used).is_some_and(|other| other > place) {
            faults.insert(format!("{name}: `{own}` may not use `{}`", path.join("::")));
        }
    }
    let faults: Vec<String> = faults.into_iter().collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn no_files_use_each_other() {
    let edges = program(&sources()).edges();
    for edges in [among_rooms(&edges), among_files(&edges)] {
        let found: Vec<String> = cycles(&edges).iter().map(|cycle| describe(cycle, &edges)).collect();
        assert!(found.is_empty(), "\n{}", found.join("\n"));
    }
}

/// What a method is made of is said in its plan; what is to be computed follows from that.
#[test]
fn methods_are_told_apart_in_one_place() {
    const PLACE: &str = "src/integrator/plan.rs";
    let sources = sources();
    for (name, source) in sources.iter().filter(|(name, _)| name != PLACE) {
        let found = questions(source);
        assert!(found.is_empty(), "{name} asks which method it is: {found:?}; ask {PLACE}");
    }
    let (_, plan) = sources.iter().find(|(name, _)| name == PLACE).expect("the plan");
    assert_eq!(wildcards(plan), Vec::<String>::new(), "{PLACE}: a new method would not be noticed");
}

/// A module with children is `foo/mod.rs`.
#[test]
fn modules_with_children_are_folders() {
    for path in ["src", "tests"].iter().flat_map(|folder| files(folder, "rs")) {
        let folder = path.with_extension("");
        assert!(!folder.is_dir(), "{} stands beside {}/: make it mod.rs there", shown(&path), shown(&folder));
    }
}

/// `lib` is functions and constants; what is bound stands in `bind`, once, for all kernels.
#[test]
fn shader_libraries_have_no_bindings() {
    for path in files("shaders/lib", "wgsl") {
        for (number, line) in read(&path).lines().enumerate() {
            let at = format!("{}:{}", shown(&path), number + 1);
            let code = line.split("//").next().unwrap_or_default();
            assert!(!code.contains("@group"), "{at}: a binding in lib: declare it in shaders/bind");
        }
    }
}

#[test]
fn files_stay_readable() {
    let mut faults = Vec::new();
    for (folder, extension, limit) in
        [("src", "rs", MAX_RUST_LINES), ("tests", "rs", MAX_RUST_LINES), ("shaders", "wgsl", MAX_WGSL_LINES)]
    {
        for path in files(folder, extension) {
            let lines = read(&path).lines().count();
            if lines > limit {
                faults.push(format!("{}: {lines} lines, at most {limit}: make it two", shown(&path)));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}
