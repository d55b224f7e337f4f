//! The scene that is rendered.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::InputError;
use crate::cli::CliError;
#[cfg(feature = "preview")]
use crate::picture_file::split_layer;
use crate::scene::gltf::{self, LoadOptions};
use crate::scene::{Environment, Instancing, Scene, SceneFeatures, builtin};

/// A scene and what is added to it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// A .gltf or .glb file, or `builtin:NAME` (see `halfway info --builtins`).
    pub scene: PathBuf,
    /// An .exr or .hdr latitude-longitude picture as environment light; of an .exr with several layers FILE#LAYER.
    #[arg(long, value_name = "FILE[#LAYER]")]
    pub env: Option<PathBuf>,
    /// Factor on the environment.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub env_scale: f32,
    /// Rotation of the environment about the vertical axis, degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    pub env_rotate: f32,
    /// Show the materials of this variant of the file (KHR_materials_variants); `halfway info` lists them.
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Let the scene refer to files outside its folder.
    #[arg(long)]
    pub allow_outside: bool,
    /// Refuse a scene with any fault, such as a missing texture, instead of showing it without the part that has it.
    #[arg(long)]
    pub strict: bool,
    /// What the camera sees of the backs of single-sided surfaces (`doubleSided` false).
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    pub back_faces: BackFaces,
    /// How meshes are held that are shown in many places.
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    pub instances: Instancing,
}

/// Backs of surfaces that have no second side in glTF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum BackFaces {
    /// They are there and lit as the front is, as Blender's Cycles has them.
    #[default]
    Show,
    /// The camera looks through them, as glTF and rasterisers have it; light still meets them, and glass stays whole.
    Cull,
}

/// Warnings shown one by one before the rest is only counted.
const WARNINGS_SHOWN: usize = 20;

impl SceneArgs {
    /// The files that it is read from, as far as they are named here: none of a built-in scene.
    #[cfg(feature = "preview")]
    pub fn files(&self) -> Vec<PathBuf> {
        let is_file = |path: &&PathBuf| !path.to_string_lossy().starts_with("builtin:");
        let environment = self.env.as_deref().map(|path| split_layer(path).0);
        std::iter::once(&self.scene).filter(is_file).cloned().chain(environment).collect()
    }

    /// Loads the scene as [`Self::read`] does, and prints the loader's warnings.
    ///
    /// # Errors
    /// What the loader reports.
    pub fn load(&self) -> Result<Scene, CliError> {
        let scene = self.read()?;
        scene.warnings.iter().take(WARNINGS_SHOWN).for_each(|warning| log::warn!("{warning}"));
        if let Some(more) = scene.warnings.len().checked_sub(WARNINGS_SHOWN + 1) {
            log::warn!("and {} more; halfway info lists them all", more + 1);
        }
        Ok(scene)
    }

    /// Loads the scene and adds the environment.
    ///
    /// # Errors
    /// What the loader reports.
    pub fn read(&self) -> Result<Scene, CliError> {
        let mut scene = match self.scene.to_str().and_then(|name| name.strip_prefix("builtin:")) {
            Some(_) if self.variant.is_some() => {
                let usage = "--variant is for files, and built-in scenes have no variants; leave it out";
                return Err(InputError::Usage(usage.into()).into());
            }
            Some(name) => builtin::builtin(name).ok_or_else(|| {
                InputError::Usage(format!(
                    "no built-in scene '{name}'; there are: {}",
                    builtin::NAMES.join(", ")
                ))
            })?,
            None => {
                let options = LoadOptions {
                    allow_outside: self.allow_outside,
                    strict: self.strict,
                    variant: self.variant.clone(),
                    instancing: self.instances,
                    ..LoadOptions::default()
                };
                gltf::load(&self.scene, &options)?
            }
        };
        if self.back_faces == BackFaces::Cull {
            scene.cull_backs();
        }
        if let Some(path) = &self.env {
            let mut environment = Environment::load(path, &mut scene.warnings)?;
            environment.scale = self.env_scale;
            environment.rotation = self.env_rotate.to_radians();
            scene.environment = Some(environment);
        }
        Ok(scene)
    }
}

/// Warns of a scene whose picture will be empty or black.
pub fn say_what_is_missing(scene: &Scene) {
    if scene.triangle_count() == 0 {
        log::warn!("the scene has no triangles; only its environment, if any, will be seen");
    }
    if !SceneFeatures::of(scene).lights() {
        log::warn!(
            "the scene has no light: the picture will be black. Give it an emissive material, a \
             KHR_lights_punctual light, or an environment with --env"
        );
    }
}
