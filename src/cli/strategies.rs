//! `halfway render --strategies`: each way to find a path in a picture of its own.

use std::path::Path;

use super::args::InputError;
use super::saves::Saves;
use crate::cli::CliError;
use crate::film::contact_sheet::{self, Frame};
use crate::film::tonemap::ViewTransform;
use crate::film::{Picture, exr};
use crate::integrator::{Method, Strategy};
use crate::render::{RenderOptions, Renderer};

/// Longest paths that get pictures: there are about half as many strategies as the square of the length.
pub const LONGEST: u32 = 12;

/// All strategies (s, t) of a method for paths of up to `max_depth` surfaces, by length and then by s.
///
/// # Errors
/// A method with a single strategy, or no (or too large a) limit of the length.
pub fn list(method: Method, max_depth: Option<u32>) -> Result<Vec<[u32; 2]>, InputError> {
    let plan = method.plan();
    if !plan.has_strategies() {
        return Err(InputError::Usage(
            "--strategies shows bidirectional integrators; add --integrator bdpt or lvcbpt".into(),
        ));
    }
    let shortest_t = if plan.to_camera { 1 } else { 2 };
    let Some(longest) = max_depth.filter(|depth| *depth <= LONGEST) else {
        return Err(InputError::Usage(format!(
            "--strategies makes two pictures for every strategy; add --max-depth N, at most {LONGEST}"
        )));
    };
    Ok((1..=longest)
        .flat_map(|length| (0..=length).map(move |s| [s, length + 1 - s]))
        // Lights that are seen directly have one strategy only.
        .filter(|&[s, t]| t >= shortest_t && !(s == 1 && t == 1))
        .collect())
}

/// Renders every strategy, weighted and alone, with the budget of the options each, and writes
/// `s{s}-t{t}-weighted.exr`, `s{s}-t{t}-unweighted.exr`, and for all of them `weighted.png` and `unweighted.png`.
///
/// # Errors
/// A lost device, a folder that cannot be made.
pub fn write(
    renderer: &mut Renderer,
    options: &RenderOptions,
    strategies: &[[u32; 2]],
    directory: &Path,
    view: ViewTransform,
    saves: &mut Saves,
    mut interrupted: impl FnMut() -> bool,
) -> Result<(), CliError> {
    std::fs::create_dir_all(directory).map_err(CliError::folder(directory))?;
    for (name, weighted) in [("weighted", true), ("unweighted", false)] {
        let mut pictures: Vec<([u32; 2], Picture)> = Vec::new();
        for &[s, t] in strategies {
            renderer.restart(options.view.seed, Some(Strategy { s, t, weighted }))?;
            renderer.run(|_| interrupted())?;
            if interrupted() {
                return Ok(());
            }
            let picture = renderer.picture()?;
            let path = directory.join(format!("s{s}-t{t}-{name}.exr"));
            saves.part(exr::write(&path, &picture));
            pictures.push(([s, t], picture));
        }
        let title = format!("{} strategies, {name}: a row for each path length", options.method.name());
        let exposures: Vec<f32> = row_exposures(&pictures);
        let frames: Vec<Frame> = pictures
            .iter()
            .map(|([s, t], picture)| {
                let row = (s + t - 2) as usize;
                let exposure = exposures[row];
                let gain = if exposure > 0.0 { format!(" +{exposure}EV") } else { String::new() };
                Frame { column: *s as usize, row, caption: format!("s={s} t={t}{gain}"), picture, exposure }
            })
            .collect();
        let path = directory.join(format!("{name}.png"));
        saves.part(contact_sheet::write(&path, &title, &frames, view));
    }
    Ok(())
}

/// Whole stops that bring the brightest picture of each row to the brightness of the brightest row: longer paths
/// are dimmer.
fn row_exposures(pictures: &[([u32; 2], Picture)]) -> Vec<f32> {
    let mean = |picture: &Picture| {
        picture.rgb.iter().flatten().map(|&c| f64::from(c)).sum::<f64>() / picture.rgb.len() as f64
    };
    let rows = pictures.iter().map(|([s, t], _)| s + t - 1).max().unwrap_or(0) as usize;
    let mut brightest = vec![0.0f64; rows];
    for ([s, t], picture) in pictures {
        let row = (s + t - 2) as usize;
        brightest[row] = brightest[row].max(mean(picture));
    }
    let top = brightest.iter().copied().fold(0.0, f64::max);
    brightest
        .iter()
        .map(|&row| if row > 0.0 { (top / row).log2().round().clamp(0.0, 20.0) as f32 } else { 0.0 })
        .collect()
}
