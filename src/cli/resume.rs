//! `halfway resume`

use std::path::PathBuf;

use clap::Args;

use super::args::InputError;
use super::keep::without;
use super::render::RenderArgs;
use super::{CliError, Exit, render};
use crate::film::checkpoint::SavedRender;

/// Options of `halfway resume`.
#[derive(Args, Debug)]
pub struct ResumeArgs {
    /// A file that `halfway render --checkpoint` wrote. It says how the render was started, and in which folder; the checkpoints
    /// of what is rendered from now on replace it.
    checkpoint: PathBuf,
    /// Samples per pixel, those that are there included, in place of the render's own limits.
    #[arg(long, value_name = "N")]
    spp: Option<u32>,
    /// Time, that before the checkpoint included, in place of the render's own limits.
    #[arg(long, value_name = "TIME")]
    time: Option<String>,
    /// Stop at this estimated error, in place of the render's own limits.
    #[arg(long, value_name = "ERROR")]
    error: Option<f64>,
}

/// Goes on with a render.
///
/// # Errors
/// As `render`; a file that is no checkpoint.
pub fn run(args: &ResumeArgs, quiet: bool) -> Result<Exit, CliError> {
    let path = &args.checkpoint;
    let path = path.canonicalize().unwrap_or_else(|_| path.clone());
    let header = SavedRender::read_header(&path)?;
    let limits = [
        args.spp.map(|spp| ["--spp".to_owned(), spp.to_string()]),
        args.time.clone().map(|time| ["--time".to_owned(), time]),
        args.error.map(|error| ["--error".to_owned(), error.to_string()]),
    ];
    let limits: Vec<String> = limits.into_iter().flatten().flatten().collect();
    let mut command = header.command;
    if !limits.is_empty() {
        command = without(&command, &["--spp", "--time", "--error"]);
        command.extend(limits);
    }
    let (mut render, was_quiet) = RenderArgs::of(&command).map_err(|reason| {
        InputError::Usage(format!(
            "{} does not say how to go on: {reason}; give the render's own command again, with --resume",
            path.display()
        ))
    })?;
    // Where that is gone, perhaps on another machine, the files may lie here.
    if std::env::set_current_dir(&header.folder).is_err() {
        log::warn!("the folder {} is not there; files are looked for in this one", header.folder);
    }
    render.keep = std::mem::take(&mut render.keep).going_on(&path, command);
    render::run(&render, quiet || was_quiet)
}
