//! The street is one-way: no module uses a layer above its own, and no file grows beyond reading.

use std::fs;
use std::path::{Path, PathBuf};

/// Layers from the bottom up; a module may use its own layer and those before it.
const LAYERS: &[&[&str]] = &[
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

/// Free for all, and free to name all: each of its enums belongs to one layer.
const FREE: [&str; 2] = ["lib", "error"];

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

/// The modules between the crate's root and the code in `path`: `src/scene/builtin/mod.rs` is scene, builtin.
fn module_path(path: &Path) -> Vec<String> {
    let inside = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).expect("inside src");
    let mut modules: Vec<String> =
        inside.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if modules.last().is_some_and(|last| last == "mod") {
        modules.pop();
    }
    modules
}

/// The identifier at the start of `text`, empty if there is none.
fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// The first identifiers of what follows a `::`, more than one in front of a group: `{a::b, c::{d, e}}` is a, c.
fn heads(text: &str) -> Vec<String> {
    let Some(group) = text.strip_prefix('{') else { return vec![identifier(text).into()] };
    let mut heads = Vec::new();
    let mut depth = 0;
    let mut at_start = true;
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => at_start = true,
            _ if at_start && !c.is_whitespace() => {
                heads.push(identifier(&group[i..]).into());
                at_start = false;
            }
            _ => {}
        }
    }
    heads
}

/// Top-level items that `source`, `depth` modules below the root, names by `crate::`, `halfway::` or enough `super::`s.
fn root_items(source: &str, depth: usize) -> Vec<String> {
    let code: Vec<&str> = source.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code = code.join("\n");
    let mut found = Vec::new();
    for root in ["crate::", "halfway::", &"super::".repeat(depth)] {
        for (at, _) in code.match_indices(root) {
            let is_whole_path =
                !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$');
            if is_whole_path {
                found.extend(heads(&code[at + root.len()..]));
            }
        }
    }
    found
}

#[test]
fn no_layer_uses_a_higher_one() {
    let mut faults = Vec::new();
    for path in files("src", "rs") {
        let modules = module_path(&path);
        if FREE.contains(&modules[0].as_str()) {
            continue;
        }
        let Some(own) = layer(&modules[0]) else {
            faults.push(format!("{}: `{}` has no place in LAYERS", shown(&path), modules[0]));
            continue;
        };
        for used in root_items(&read(&path), modules.len()) {
            if layer(&used).is_some_and(|other| other > own) {
                faults.push(format!("{}: `{}` may not use `{used}`", shown(&path), modules[0]));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn root_items_are_found_however_they_are_written() {
    let source = "use crate::{math::rng, film::{self, Film},\n scene};\n// use crate::cli;\n\
                  fn f() -> crate::error::E { super::super::render::go(super::near()) }\nuse other_crate::cli;";
    assert_eq!(root_items(source, 2), ["math", "film", "scene", "error", "render"]);
    assert_eq!(root_items("use halfway::cli::run;", 1), ["cli"]);
    assert_eq!(root_items("use super::device;", 1), ["device"]);
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
