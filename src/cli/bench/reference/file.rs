//! A reference as a picture's file: what it was made of is in its metadata.

use std::path::PathBuf;

use crate::bench::reference::{AccumulatedReference, Pass, Reference};
use crate::cli::CliError;
use crate::cli::bench::scene::BenchScene;
use crate::cli::text::{grouped, short};
use crate::film::metric::{self, ReferenceNoise};
use crate::film::{Attribute, Picture, Region};
use crate::integrator::View;
use crate::math::fnv::fnv;

/// A picture to compare with.
pub struct ReferenceFile {
    pub picture: Picture,
    pub path: PathBuf,
    pub noise: Option<ReferenceNoise>,
}

impl ReferenceFile {
    /// # Errors
    /// A picture that nothing can be compared with, such as a black one.
    pub fn new(picture: Picture, path: PathBuf) -> Result<Self, CliError> {
        Ok(Self { noise: metric::reference_noise(&picture)?, picture, path })
    }

    /// A number of its metadata.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.picture.attribute(name) {
            Some(Attribute::Number(value)) => Some(*value),
            _ => None,
        }
    }

    /// A text of its metadata.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.picture.attribute(name) {
            Some(Attribute::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// What made it, with how many samples in which time; else its file.
    pub fn origin(&self) -> String {
        match (self.text("integrator"), self.number("spp"), self.number("seconds")) {
            (Some(maker), Some(spp), Some(seconds)) => {
                let part = match self.stride() {
                    1 => String::new(),
                    stride => format!(" of every {}th pixel", stride * stride),
                };
                format!("{maker}, {} spp{part}, {} s", grouped(spp), short(seconds))
            }
            _ => self.path.display().to_string(),
        }
    }

    /// How it compared with a second integrator's picture; `None` before that.
    pub fn checked(&self) -> Option<&str> {
        self.text("checked")
    }

    /// Of the lattice of pixels that it has; 1: all.
    pub fn stride(&self) -> u32 {
        self.number("stride").map_or(1, |stride| stride as u32).max(1)
    }

    /// With the region of the whole picture whose pixels it has.
    pub fn of_whole(&self, bench_scene: &BenchScene) -> Reference<'_> {
        let View { width, height, .. } = bench_scene.options.view;
        Reference { picture: &self.picture, region: Region::lattice(width, height, self.stride()) }
    }

    /// Tells references apart.
    pub fn hash(&self) -> u64 {
        fnv(bytemuck::cast_slice(self.picture.rgb.as_flattened()))
    }

    /// The passes that it is made of, where [`bench reference`](super::run) made it.
    pub fn accumulated(&self) -> Option<AccumulatedReference> {
        let pass = |text: &str| {
            let (samples, mean) = text.split_once(':')?;
            Some(Pass { samples: samples.parse().ok()?, mean: mean.parse().ok()? })
        };
        Some(AccumulatedReference {
            picture: self.picture.clone(),
            samples: self.number("spp")? as u64,
            seconds: self.number("seconds")?,
            non_finite: self.number("nonFiniteSamples")? as u64,
            // Older files call them portions; to make one again takes up to an hour.
            passes: self
                .text("passes")
                .or(self.text("portions"))?
                .split(' ')
                .map(pass)
                .collect::<Option<_>>()?,
        })
    }
}
