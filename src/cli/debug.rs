//! `halfway render --debug`: pictures of what a method does, beside the picture that it makes.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::args::InputError;
use crate::cli::CliError;
use crate::film::{false_color, png};
use crate::integrator::{FirstSubspaces, Method};
use crate::render::Renderer;

/// What to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Debug {
    /// The eye and light subspaces of what is seen first, and Gamma (spcbpt).
    Subspaces,
}

impl Debug {
    /// # Errors
    /// The method has nothing of the kind.
    pub fn check(self, method: Method) -> Result<(), InputError> {
        match (self, method) {
            (Self::Subspaces, method) if method.plan().learns() => Ok(()),
            (Self::Subspaces, _) => Err(InputError::Usage(
                "--debug subspaces shows what spcbpt has learnt; leave it out, or add --integrator spcbpt"
                    .into(),
            )),
        }
    }

    /// Writes the pictures beside `output`, and returns where.
    ///
    /// # Errors
    /// A lost device, a picture that cannot be written.
    pub fn write(self, renderer: &mut Renderer, output: &Path) -> Result<Vec<PathBuf>, CliError> {
        match self {
            Self::Subspaces => subspaces(renderer, output),
        }
    }
}

fn subspaces(renderer: &mut Renderer, output: &Path) -> Result<Vec<PathBuf>, CliError> {
    let (Some(first), Some(model)) = (renderer.first_subspaces()?, renderer.model.clone()) else {
        log::warn!("there is no light to connect to, so there are no subspaces to show");
        return Ok(Vec::new());
    };
    let picture = renderer.picture()?;
    let normals = ["X", "Y", "Z"].map(|axis| picture.channel("normal", axis).unwrap_or_default());
    let normal = |pixel: usize| normals.map(|axis| axis.get(pixel).copied().unwrap_or(0.0));
    let mut written = Vec::new();
    let mut sides = vec!["eye-subspaces", "light-subspaces"];
    if model.settings.direction_weight > 0.0 {
        log::warn!(
            "with --direction-weight a place has another light subspace for every direction that light comes from; \
             there is no picture of them"
        );
        sides.truncate(1);
    }
    for (side, name) in sides.into_iter().enumerate() {
        let pixel = |(index, seen): (usize, &FirstSubspaces)| {
            false_color::label_pixel(seen.labels.map(|labels| labels[side]), seen.facing(normal(index)))
        };
        let pixels: Vec<[u8; 3]> = first.iter().enumerate().map(pixel).collect();
        let path = beside(output, name);
        png::write_bytes(&path, picture.width, picture.height, &pixels)?;
        written.push(path);
    }
    let (side, pixels) = false_color::matrix(&model.gamma, model.subspaces as usize);
    let [least, most] = false_color::range(&model.gamma);
    log::info!("gamma from {least:.2e} (violet) to {most:.2e} (yellow), black where it is zero");
    let path = beside(output, "gamma");
    png::write_bytes(&path, side, side, &pixels)?;
    written.push(path);
    Ok(written)
}

/// `out.exr` and `gamma`: `out.gamma.png`.
fn beside(output: &Path, name: &str) -> PathBuf {
    output.with_extension(format!("{name}.png"))
}
