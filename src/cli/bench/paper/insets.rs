//! What each method has made of a part of a scene after the same time, beside the reference.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::{PaperArgs, Rendered, methods};
use crate::bench::trade::Plan;
use crate::cli::CliError;
use crate::cli::bench::candidate::Candidate;
use crate::cli::bench::runs::{SceneRenders, seed_of};
use crate::cli::progress::{interrupted, learn};
use crate::cli::text::short;
use crate::film::contact_sheet::{self, Frame};
use crate::film::tonemap::ViewTransform;
use crate::film::{Attribute, Exposure, Picture, Region, exr, metric};
use crate::render::{Budget, Prepared, RenderError, RenderOptions, TimeLimit};
use crate::training::When;

/// Parts that are shown of a picture, and their share of its width and height: 1 / this.
const PARTS: usize = 2;
const PART: u32 = 4;
/// Width of a part on the sheet.
const SHOWN_WIDTH: u32 = 192;

/// Pictures of a scene.
pub struct Insets {
    /// As published and as they are by turns; none where references lack pixels.
    pictures: Vec<Picture>,
}

impl Insets {
    /// Renders them, or reads what was rendered before; `None` where Ctrl-C ended that.
    ///
    /// # Errors
    /// What rendering reports, pictures that cannot be kept.
    pub fn render(
        renders: &SceneRenders,
        candidates: &[Candidate],
        args: &PaperArgs,
    ) -> Result<Option<Self>, CliError> {
        let mut pictures = Vec::new();
        if renders.reference.stride() > 1 {
            return Ok(Some(Self { pictures }));
        }
        let folder = args.output.join("insets");
        std::fs::create_dir_all(&folder).map_err(CliError::folder(&folder))?;
        for candidate in candidates {
            if !renders.quiet {
                let seconds = short(args.inset_time.as_secs_f64());
                eprintln!("{}: a picture of {}, {seconds} s", renders.bench_scene.name, candidate.label);
            }
            match picture(renders, candidate, args, &folder)? {
                Some(picture) => pictures.push(picture),
                None => return Ok(None),
            }
        }
        Ok(Some(Self { pictures }))
    }

    /// Writes the sheet: the parts where the methods differ most, each once as published and once as it is.
    ///
    /// # Errors
    /// A picture that is not finite, a file that cannot be written.
    pub fn write(&self, path: &Path, scene: &Rendered, time: Duration) -> Result<(), CliError> {
        let reference = &scene.renders.reference.picture;
        if self.pictures.is_empty() {
            return Ok(());
        }
        let exposure = Exposure::Auto.stops(reference);
        let parts = self.parts(reference);
        let shown: Vec<Picture> = parts.iter().map(|part| enlarged(&reference.part(part))).collect();
        let mut all: Vec<(usize, usize, String, Picture)> = Vec::new();
        for (place, part) in parts.iter().enumerate() {
            for (index, picture) in self.pictures.iter().enumerate() {
                let (column, published) = (1 + index / 2, index % 2 == 0);
                let name = methods().nth(index / 2).unwrap_or_default();
                let error = 100.0 * metric::mape_paper(picture, reference);
                let kind = if published { " AS PUBLISHED" } else { "" };
                let caption = match place {
                    0 => format!("{name}{kind}"),
                    _ => format!("{} SPP, {} %", samples(picture), short(error)),
                };
                let row = 2 * usize::from(!published) + place;
                all.push((column, row, caption, enlarged(&picture.part(part))));
            }
        }
        let of_reference = [0, 1].into_iter().flat_map(|half| {
            parts.iter().zip(&shown).enumerate().map(move |(place, (part, picture))| {
                let caption = match place {
                    0 => "REFERENCE".to_owned(),
                    _ => format!("{}x{} AT {},{}", part.width, part.height, part.x, part.y),
                };
                Frame { column: 0, row: 2 * half + place, caption, picture, exposure }
            })
        });
        let of_methods = all.iter().map(|(column, row, caption, picture)| Frame {
            column: *column,
            row: *row,
            caption: caption.clone(),
            picture,
            exposure,
        });
        let frames: Vec<Frame> = of_reference.chain(of_methods).collect();
        let seconds = short(time.as_secs_f64());
        let title = format!("{} AFTER {seconds} S BESIDE LEARNING", scene.renders.bench_scene.name);
        Ok(contact_sheet::write(path, &title, &frames, ViewTransform::default())?)
    }

    /// The parts of a lattice where the methods' errors are largest, on average over methods.
    fn parts(&self, reference: &Picture) -> Vec<Region> {
        let size = [reference.width, reference.height].map(|length| (length / PART).max(1));
        let places = |length: u32, size: u32| (0..length / size).map(move |place| place * size);
        let mut parts: Vec<(f64, Region)> = places(reference.height, size[1])
            .flat_map(|y| places(reference.width, size[0]).map(move |x| Region::new(x, y, size[0], size[1])))
            .map(|part| {
                let there = reference.part(&part);
                let error = |picture: &Picture| metric::mape_paper(&picture.part(&part), &there);
                (self.pictures.iter().map(error).sum(), part)
            })
            .collect();
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        parts.into_iter().take(PARTS).map(|(_, part)| part).collect()
    }
}

/// Samples per pixel that a picture of [`Insets::render`] has.
fn samples(picture: &Picture) -> f64 {
    match picture.attribute("spp") {
        Some(Attribute::Number(samples)) => *samples,
        _ => 0.0,
    }
}

/// Every pixel as a square.
fn enlarged(picture: &Picture) -> Picture {
    let scale = (SHOWN_WIDTH / picture.width).max(1);
    let (width, height) = (picture.width * scale, picture.height * scale);
    let pixel = |index: u32| {
        let (column, row) = (index % width / scale, index / width / scale);
        picture.rgb[(row * picture.width + column) as usize]
    };
    Picture::new(width, height, (0..width * height).map(pixel).collect())
}

/// A picture of a candidate; `None` where Ctrl-C ended it.
fn picture(
    renders: &SceneRenders,
    candidate: &Candidate,
    args: &PaperArgs,
    folder: &Path,
) -> Result<Option<Picture>, CliError> {
    let plan = Plan { time: Some(args.inset_time), as_paper: true, ..Plan::default() };
    let key = serde_json::to_string(&renders.key(&plan, candidate, seed_of(candidate, args.seed))?)?;
    let name = format!("{}-{}.exr", renders.bench_scene.name, candidate.label.replace([':', ',', '='], "-"));
    let path: PathBuf = folder.join(name);
    if path.exists() {
        let kept = Picture::read(&path)?;
        if kept.attribute("key") == Some(&Attribute::Text(key.clone())) {
            return Ok(Some(kept));
        }
    }
    let options = candidate.options(&renders.bench_scene, seed_of(candidate, args.seed));
    let options = RenderOptions { budget: plan.budget(), ..options };
    let mut prepared = Prepared::new(renders.context, &renders.bench_scene.scene, options)?;
    if prepared.learns() == Some(When::First) {
        match learn(&mut prepared, true) {
            Err(RenderError::Interrupted) => return Ok(None),
            learnt => drop(learnt?),
        }
    }
    let mut renderer = prepared.renderer()?;
    renderer.set_budget(Budget { time: Some(TimeLimit::Rendering(args.inset_time)), ..Budget::default() });
    renderer.run(|_| interrupted())?;
    if interrupted() {
        return Ok(None);
    }
    let mut picture = renderer.radiance()?;
    picture.metadata = vec![
        ("spp".into(), Attribute::Number(f64::from(renderer.report()?.samples))),
        ("key".into(), Attribute::Text(key)),
    ];
    exr::write(&path, &picture)?;
    Ok(Some(picture))
}
