//! `halfway render --debug`: pictures of what a method does, beside the picture that it makes.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use glam::Vec3;

use super::args::InputError;
use super::saves::Saves;
use crate::film::heatmap::{VIRIDIS, color};
use crate::film::{false_color, png};
use crate::integrator::{FirstSubspaces, Method};
use crate::math::kd_tree::KdTree;
use crate::render::{RenderError, Renderer};
use crate::subspace::CentroidMove;
use crate::subspace::guide::GUIDE_SIDE;

/// What to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Debug {
    /// The eye and light subspaces of what is seen first with their centroids, black as they were drawn and white where they were
    /// moved to, and Gamma (spcbpt).
    Subspaces,
    /// Where guided light paths go, as squares of directions by light subspace, and how far what is seen first guides them
    /// (spcbpt).
    Guides,
}

impl Debug {
    /// # Errors
    /// The method has nothing of the kind.
    pub fn check(self, method: Method) -> Result<(), InputError> {
        let name = self.to_possible_value().map_or_else(String::new, |value| value.get_name().into());
        match method.plan().learns() {
            true => Ok(()),
            false => Err(InputError::Usage(format!(
                "--debug {name} shows what spcbpt has learnt; leave it out, or add --integrator spcbpt"
            ))),
        }
    }

    /// Where the pictures beside `output` go, if there are all of them.
    pub fn files(self, output: &Path) -> Vec<PathBuf> {
        match self {
            Self::Subspaces => SIDES.iter().chain(&[GAMMA]).map(|name| beside(output, name)).collect(),
            Self::Guides => GUIDES.iter().map(|name| beside(output, name)).collect(),
        }
    }

    /// Writes the pictures beside `output`.
    ///
    /// # Errors
    /// A lost device.
    pub fn write(self, renderer: &mut Renderer, output: &Path, saves: &mut Saves) -> Result<(), RenderError> {
        match self {
            Self::Subspaces => subspaces(renderer, output, saves),
            Self::Guides => guides(renderer, output, saves),
        }
    }
}

const SIDES: [&str; 2] = ["eye-subspaces", "light-subspaces"];
const GAMMA: &str = "gamma";
/// Pictures of this width have marks of more than a pixel.
const LEAST_MARKED: usize = 320;
const GUIDES: [&str; 2] = ["guides", "guided"];

fn subspaces(renderer: &mut Renderer, output: &Path, saves: &mut Saves) -> Result<(), RenderError> {
    let (Some(first), Some(model)) = (renderer.first_subspaces()?, renderer.model.clone()) else {
        log::warn!("there is no light to connect to, so there are no subspaces to show");
        return Ok(());
    };
    let picture = renderer.picture()?;
    let normals = ["X", "Y", "Z"].map(|axis| picture.channel("normal", axis).unwrap_or_default());
    let normal = |pixel: usize| normals.map(|axis| axis.get(pixel).copied().unwrap_or(0.0));
    let mut sides = &SIDES[..];
    if model.settings.direction_weight > 0.0 {
        log::warn!(
            "with --direction-weight a place has another light subspace for every direction that light comes from; \
             there is no picture of them"
        );
        sides = &sides[..1];
    }
    for (side, name) in sides.iter().enumerate() {
        let pixel = |(index, seen): (usize, &FirstSubspaces)| {
            false_color::label_pixel(seen.labels.map(|labels| labels[side]), seen.facing(normal(index)))
        };
        let mut pixels: Vec<[u8; 3]> = first.iter().enumerate().map(pixel).collect();
        mark_centroids(&mut pixels, picture.width as usize, &first, &model.centroids[side]);
        let path = beside(output, name);
        saves.picture(&path, png::write_bytes(&path, picture.width, picture.height, &pixels));
    }
    let (side, pixels) = false_color::matrix(&model.gamma, model.subspaces as usize);
    let [least, most] = false_color::range(&model.gamma);
    log::info!("gamma from {least:.2e} (violet) to {most:.2e} (yellow), black where it is zero");
    let path = beside(output, GAMMA);
    saves.picture(&path, png::write_bytes(&path, side, side, &pixels));
    Ok(())
}

/// Marks centroids where what is seen lies nearest to them: black as they were drawn, white where they were moved to.
fn mark_centroids(
    pixels: &mut [[u8; 3]],
    width: usize,
    first: &[FirstSubspaces],
    centroids: &[CentroidMove],
) {
    let height = pixels.len() / width;
    let seen: Vec<usize> = (0..first.len()).filter(|&pixel| first[pixel].labels.is_some()).collect();
    let positions: Vec<[f32; 3]> = seen.iter().map(|&pixel| first[pixel].position).collect();
    let (tree, order) = KdTree::build(&positions);
    // One that is not among what is seen next to it is out of sight: beyond twice the distance of the two points nearest to it.
    let spot = |position: Vec3| match tree.nearest(position.to_array())[..] {
        [(place, distance_sq), (next, _), ..] => {
            let [at, beside] = [place, next].map(|place| Vec3::from(tree.points()[place as usize]));
            let is_near = distance_sq <= 4.0 * at.distance_squared(beside);
            is_near.then(|| seen[order[place as usize] as usize])
        }
        _ => None,
    };
    let radius = width / LEAST_MARKED;
    let mut mark = |position: Vec3, color: [u8; 3]| {
        let Some(center) = spot(position) else { return };
        let (x, y) = (center % width, center / width);
        for row in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            for column in x.saturating_sub(radius)..(x + radius + 1).min(width) {
                pixels[row * width + column] = color;
            }
        }
    };
    centroids.iter().for_each(|centroid| mark(centroid.drawn, [0; 3]));
    centroids.iter().for_each(|centroid| mark(centroid.moved, [255; 3]));
}

fn guides(renderer: &mut Renderer, output: &Path, saves: &mut Saves) -> Result<(), RenderError> {
    let guide = renderer.model.as_ref().and_then(|model| model.guide.clone());
    let (Some(first), Some(guide)) = (renderer.first_subspaces()?, guide) else {
        log::warn!("light paths are not guided in this render, so there is no guide to show");
        return Ok(());
    };
    let (side, pixels) = false_color::squares(&guide.cells, GUIDE_SIDE);
    let path = beside(output, GUIDES[0]);
    saves.picture(&path, png::write_bytes(&path, side, side, &pixels));
    let strongest = guide.strongest();
    let most = strongest.iter().copied().fold(1.0, f64::max);
    log::info!("guides: up to {most:.1} times as many light paths into one direction as without (yellow)");
    let pixel = |seen: &FirstSubspaces| match seen.labels {
        Some([_, label]) => color(&VIRIDIS, strongest[label as usize].ln() / most.ln().max(1e-9)),
        None => [0; 3],
    };
    let pixels: Vec<[u8; 3]> = first.iter().map(pixel).collect();
    let picture = renderer.picture()?;
    let path = beside(output, GUIDES[1]);
    saves.picture(&path, png::write_bytes(&path, picture.width, picture.height, &pixels));
    Ok(())
}

/// `out.exr` and `gamma`: `out.gamma.png`.
fn beside(output: &Path, name: &str) -> PathBuf {
    output.with_extension(format!("{name}.png"))
}
