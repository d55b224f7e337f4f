//! `halfway merge`

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::args::picture::ViewArgs;
use super::args::try_format;
use super::output::{is_part, is_png};
use super::render::faults;
use super::saves::Saves;
use super::{CliError, Exit, summary, text};
use crate::film::checkpoint::SavedRender;
use crate::film::{Attribute, FilmError, Lost, exr, merge, png};
use crate::integrator::RayCounts;
use crate::render::{ERROR, rays_of};

/// Options of `halfway merge`.
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Portions of one render, in any order: files that `halfway render --samples` or `halfway merge` wrote.
    #[arg(required = true, value_name = "PART")]
    portions: Vec<PathBuf>,
    /// Where the picture goes: .exr or .png; or .part, a portion of all their samples, to be merged with others later. May be
    /// given several times.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Samples per pixel of the whole picture: all from the first to the last have to be there.
    #[arg(long, value_name = "N")]
    spp: Option<u32>,
    /// Merge what there is where portions are missing or were stopped. The picture has more noise and no bias.
    #[arg(long)]
    allow_missing: bool,
    #[command(flatten)]
    view: ViewArgs,
}

/// Adds portions up and writes the picture.
///
/// # Errors
/// Portions that make no picture together; files that cannot be read or written.
pub fn run(args: &MergeArgs, quiet: bool) -> Result<Exit, CliError> {
    args.output.iter().try_for_each(|file| try_format(file, &["exr", "png", "part"]))?;
    let start = Instant::now();
    let mut merged = merge::merge(&args.portions, args.spp.map(|spp| 0..spp), args.allow_missing)?;
    for range in &merged.missing {
        log::warn!("samples {}..{} are missing", range.start, range.end);
    }
    let mut saves = Saves::default();
    for file in args.output.iter().filter(|file| is_part(file)) {
        saves.picture(file, save(&merged, file));
    }
    let rays = merged.runs.iter().map(rays_of).fold(RayCounts::default(), |sum, rays| sum + rays);
    let SavedRender { header, film, layers, .. } = std::mem::take(&mut merged.saved);
    let samples = header.samples;
    let radiance_scale = 2f64.powi(header.radiance_exponent);
    let sums = film.into_sums();
    let mut picture = sums.picture(radiance_scale);
    picture.layers.extend(layers);
    picture.metadata = header.metadata;
    picture.metadata.retain(|(name, _)| name != "commandLine");
    picture.metadata.push(("commandLine".into(), Attribute::Text(text::command_line())));
    if picture.channel("normal", "X").is_none()
        && args.output.iter().any(|file| file.extension().is_some_and(|e| e == "exr"))
    {
        log::warn!(
            "the portion of the first samples is not there, so there are no layers albedo, normal and depth"
        );
    }
    let error = sums.estimated_error();
    picture.metadata.extend(error.map(|error| (ERROR.to_owned(), Attribute::Number(error))));
    let stops = args.view.exposure.stops(&picture);
    for file in args.output.iter().filter(|file| !is_part(file)) {
        let written = match is_png(file) {
            true => png::write(file, &picture, args.view.view, stops),
            false => exr::write(file, &picture),
        };
        saves.picture(file, written);
    }
    if !quiet {
        let error = error.map_or(String::new(), |error| format!(", estimated error {:.2} %", 100.0 * error));
        let missing: u32 = merged.missing.iter().map(|range| range.end - range.start).sum();
        eprintln!(
            "{} spp from {} portions, merged in {:.2} s{error}; made by {}",
            samples.next - samples.first - missing,
            args.portions.len(),
            start.elapsed().as_secs_f64(),
            header.devices.join("; ")
        );
    }
    for name in ["warnings", "caveats"] {
        if let Some(Attribute::Text(lines)) = picture.attribute(name) {
            lines.lines().for_each(|line| log::warn!("{line}"));
        }
    }
    summary::warn_of_depth(rays.deep_paths());
    Lost::judge(&picture, args.view.view, stops).iter().for_each(|lost| log::warn!("{lost}"));
    saves.end()?;
    let infinite = picture.non_finite_values();
    let vertices = rays.non_finite_vertices;
    Ok(faults(infinite, sums.non_finite() + vertices).unwrap_or(Exit::Done))
}

fn save(merged: &merge::Merged, file: &Path) -> Result<(), FilmError> {
    match merged.missing.is_empty() {
        true => merged.saved.save(file),
        false => Err(FilmError::Merge {
            path: file.to_owned(),
            reason: "a portion has no gaps; name a picture in its place, or render what is missing".into(),
        }),
    }
}
