//! What benchmarks render.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::CliError;
use crate::cli::args::picture::PictureArgs;
use crate::cli::args::{BackFaces, CameraNameArgs, InputError, SceneArgs, default_output};
use crate::render::RenderOptions;
use crate::scene::{Instancing, Scene};

/// Scenes, and what is the same for all of them.
#[derive(Args, Debug)]
pub struct BenchSceneArgs {
    /// .gltf or .glb files, or `builtin:NAME`.
    #[arg(value_name = "SCENE", required = true)]
    pub paths: Vec<PathBuf>,
    #[command(flatten)]
    pub seen: SeenArgs,
}

/// What is the same for all scenes.
#[derive(Args, Debug)]
pub struct SeenArgs {
    #[command(flatten)]
    camera: CameraNameArgs,
    #[command(flatten)]
    pub picture: PictureArgs,
    /// Let scenes refer to files outside their folder.
    #[arg(long)]
    allow_outside: bool,
    /// Refuse scenes with any fault, instead of leaving out the part that has it.
    #[arg(long)]
    strict: bool,
}

/// A scene with what is the same for all its renders.
pub struct BenchScene {
    pub name: String,
    pub scene: Scene,
    pub hash: u64,
    pub options: RenderOptions,
}

impl BenchScene {
    /// Refuses a scene that has the name of one of the others.
    ///
    /// # Errors
    /// It has.
    pub fn check_name<'a>(&self, mut others: impl Iterator<Item = &'a Self>) -> Result<(), InputError> {
        match others.any(|other| other.name == self.name) {
            true => Err(InputError::Usage(format!(
                "two scenes are called '{}'; rename one, tables could not tell them apart",
                self.name
            ))),
            false => Ok(()),
        }
    }
}

impl SeenArgs {
    /// Loads one of the scenes.
    ///
    /// # Errors
    /// What the loader reports, no such camera.
    pub fn load(&self, path: &Path) -> Result<BenchScene, CliError> {
        let from = SceneArgs {
            scene: path.to_owned(),
            env: None,
            env_scale: 1.0,
            env_rotate: 0.0,
            allow_outside: self.allow_outside,
            strict: self.strict,
            variant: None,
            back_faces: BackFaces::default(),
            instances: Instancing::default(),
        };
        let mut scene = from.load()?;
        let camera = self.camera.choose(&mut scene)?;
        let options = self.picture.options(&scene, camera);
        let name = default_output(path, "").display().to_string();
        Ok(BenchScene { name, hash: scene.content_hash(), scene, options })
    }
}
