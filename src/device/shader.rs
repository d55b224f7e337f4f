//! WGSL from files: imports, features, and errors that name the file and line.
//!
//! Three directives, each alone on its line:
//!
//! * `#import lib/rng` puts the text of `shaders/lib/rng.wgsl` here, the first time only.
//! * `#if feature`, `#if !feature`, `#else`, `#endif` keep or drop lines. What a scene does not need is gone
//!   from the text, its bindings too, so the driver never sees it. Features are those of [`Feature`].
//!
//! Buffers that take several bindings in a scene are read by page: `super::pages`.

use std::collections::BTreeSet;
use std::sync::Arc;

use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::features::{Feature, Features};
use super::pages::paged;
use crate::device::DeviceError;

macro_rules! sources {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../shaders/", $name, ".wgsl")))),*]
    };
}

/// Every shader file, by its path under `shaders/` without the extension.
pub const SOURCES: &[(&str, &str)] = sources![
    "bind/accel",
    "bind/arguments",
    "bind/batch",
    "bind/bucket_sums",
    "bind/buckets",
    "bind/eye_links",
    "bind/eye_records",
    "bind/film",
    "bind/ggx_albedo",
    "bind/guide",
    "bind/light_cache",
    "bind/light_ends",
    "bind/lights",
    "bind/page",
    "bind/queue",
    "bind/ray_counts",
    "bind/ray_query",
    "bind/records",
    "bind/splats",
    "bind/subpath",
    "bind/subspace_mis",
    "bind/subspaces",
    "bind/surface",
    "bind/training",
    "lib/advance",
    "lib/alias",
    "lib/alpha",
    "lib/bend",
    "lib/bsdf",
    "lib/bsdf_lambert",
    "lib/bsdf_microfacet",
    "lib/camera",
    "lib/color",
    "lib/coincident",
    "lib/connect",
    "lib/connect_lambert",
    "lib/connections",
    "lib/culling",
    "lib/deliver",
    "lib/deliver_film",
    "lib/deliver_records",
    "lib/dielectric",
    "lib/emission",
    "lib/environment",
    "lib/equal_area",
    "lib/frame",
    "lib/fresnel",
    "lib/ggx",
    "lib/ggx_albedo",
    "lib/guide",
    "lib/hit",
    "lib/instance",
    "lib/intersect",
    "lib/kronecker",
    "lib/lambert",
    "lib/light",
    "lib/light_vertex",
    "lib/math",
    "lib/medium",
    "lib/mis",
    "lib/nearest_records",
    "lib/path_key",
    "lib/plain_light_rays",
    "lib/ray_query",
    "lib/record_draws",
    "lib/record_edge",
    "lib/record_light",
    "lib/record_shares",
    "lib/record_sight",
    "lib/rng",
    "lib/roulette",
    "lib/sampling",
    "lib/scan",
    "lib/select_one_record",
    "lib/select_own_path",
    "lib/select_records",
    "lib/select_subspaces",
    "lib/select_uniform",
    "lib/selection",
    "lib/shading",
    "lib/splat",
    "lib/spot",
    "lib/strategies",
    "lib/subpath",
    "lib/subspaces",
    "lib/surface",
    "lib/texture",
    "lib/thinning",
    "lib/training",
    "lib/traverse",
    "lib/tree",
    "lib/two_levels",
    "lib/weights",
    "lib/weights_at_records",
    "lib/weights_ratio",
    "lib/weights_records",
    "lib/weights_subspaces",
    "lib/workgroup_sum",
    "bucket_counts",
    "bucket_order",
    "bucket_scan",
    "bucket_tables",
    "camera_connections",
    "camera_rays",
    "closest_hit",
    "eye_labels",
    "eye_reach",
    "eye_records",
    "eye_shade",
    "film_accumulate",
    "first_hit",
    "light_connections",
    "light_edges",
    "light_order",
    "light_rays",
    "light_samples",
    "light_scan",
    "light_shade",
    "loop_check",
    "mirror_follow",
    "occlusion",
    "path_shade",
    "queue_advance",
    "record_tables",
    "record_vertices",
    "record_weights",
    "shadow_advance",
    "splat_page",
    "training_shade",
];

/// One WGSL text with the origin of each of its lines.
#[derive(Clone, Debug)]
pub struct Stitched {
    pub code: String,
    /// File and 1-based line of every line of `code`.
    origin: Vec<(Arc<str>, u32)>,
}

/// Resolves the directives of the file `name` of [`SOURCES`].
///
/// # Errors
/// An unknown file, feature or directive, a second `#else`, an `#if` without its end: at their file and line.
pub fn stitch(name: &str, features: Features) -> Result<Stitched, DeviceError> {
    let text = source(name).ok_or_else(|| DeviceError::UnknownShader { name: name.to_string() })?;
    stitch_text(name, text, features)
}

/// Resolves the directives of a text that is no file of ours (tests' kernels).
///
/// # Errors
/// As [`stitch`].
pub fn stitch_text(name: &str, text: &str, features: Features) -> Result<Stitched, DeviceError> {
    let mut stitched = Stitched { code: String::new(), origin: Vec::new() };
    let mut seen = BTreeSet::new();
    append(&mut stitched, &mut seen, name, text, features)?;
    Ok(stitched)
}

fn source(name: &str) -> Option<&'static str> {
    SOURCES.iter().find(|(file, _)| *file == name).map(|(_, text)| *text)
}

/// The part of an open `#if` that a line stands in.
struct Branch {
    keep: bool,
    is_else: bool,
}

fn append(
    out: &mut Stitched,
    seen: &mut BTreeSet<String>,
    file: &str,
    text: &str,
    features: Features,
) -> Result<(), DeviceError> {
    let directive_error = |line: usize, message: &str| DeviceError::Shader {
        location: format!("shaders/{file}.wgsl:{}", line + 1),
        message: message.to_string(),
    };
    let origin: Arc<str> = file.into();
    let mut branches: Vec<Branch> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let trimmed = line.trim();
        if let Some(condition) = trimmed.strip_prefix("#if ") {
            let condition = condition.trim();
            let (name, wanted) = match condition.strip_prefix('!') {
                Some(name) => (name.trim(), false),
                None => (condition, true),
            };
            let feature = Feature::find(name).ok_or_else(|| {
                let message =
                    format!("unknown feature '{name}'; features are listed in src/device/features.rs");
                directive_error(number, &message)
            })?;
            branches.push(Branch { keep: features.contains(feature) == wanted, is_else: false });
        } else if trimmed == "#else" {
            let branch = branches.last_mut().ok_or_else(|| directive_error(number, "#else without #if"))?;
            if branch.is_else {
                return Err(directive_error(number, "second #else of one #if"));
            }
            *branch = Branch { keep: !branch.keep, is_else: true };
        } else if trimmed == "#endif" {
            branches.pop().ok_or_else(|| directive_error(number, "#endif without #if"))?;
        } else if branches.iter().all(|branch| branch.keep) {
            if let Some(import) = trimmed.strip_prefix("#import ") {
                let import = import.trim();
                if seen.insert(import.to_string()) {
                    let text = source(import)
                        .ok_or_else(|| directive_error(number, &format!("no shader file '{import}'")))?;
                    append(out, seen, import, text, features)?;
                }
            } else if trimmed.starts_with('#') {
                return Err(directive_error(number, &format!("unknown directive '{trimmed}'")));
            } else {
                let replaced =
                    paged(line, features.pages()).map_err(|error| directive_error(number, &error))?;
                for line in replaced.as_deref().unwrap_or(line).lines() {
                    out.code.push_str(line);
                    out.code.push('\n');
                    out.origin.push((origin.clone(), number as u32 + 1));
                }
            }
        }
    }
    if branches.is_empty() {
        Ok(())
    } else {
        Err(directive_error(text.lines().count(), "#if without #endif"))
    }
}

impl Stitched {
    /// `file.wgsl:line` of a 1-based line of the stitched code.
    pub fn locate(&self, line: u32) -> String {
        match self.origin.get(line.saturating_sub(1) as usize) {
            Some((file, line)) => format!("shaders/{file}.wgsl:{line}"),
            None => format!("line {line} of the stitched shader"),
        }
    }

    /// Parses and validates with naga.
    ///
    /// # Errors
    /// What naga found, at its file and line.
    pub fn validate(&self) -> Result<(naga::Module, naga::valid::ModuleInfo), DeviceError> {
        let module = naga::front::wgsl::parse_str(&self.code).map_err(|error| {
            let location =
                error.location(&self.code).map_or_else(|| "?".into(), |at| self.locate(at.line_number));
            DeviceError::Shader { location, message: error.message().to_string() }
        })?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).map_err(
            |error| {
                let location =
                    error.location(&self.code).map_or_else(|| "?".into(), |at| self.locate(at.line_number));
                let inner = error.into_inner();
                let mut message = inner.to_string();
                let mut source = std::error::Error::source(&inner);
                while let Some(cause) = source {
                    message = format!("{message}: {cause}");
                    source = cause.source();
                }
                DeviceError::Shader { location, message }
            },
        )?;
        Ok((module, info))
    }
}
