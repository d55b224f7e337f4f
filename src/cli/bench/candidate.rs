//! Integrators with settings, as benchmarks take them from the command line.

use std::sync::Arc;

use clap::Parser;

use super::scene::BenchScene;
use crate::cli::args::InputError;
use crate::cli::args::method::MethodArgs;
use crate::cli::args::picture::PathArgs;
use crate::integrator::{Descriptor, Method, View};
use crate::render::RenderOptions;
use crate::training::{Training, When};

/// An integrator as it is named on the command line.
#[derive(Clone)]
pub struct Candidate {
    pub label: String,
    pub method: Method,
    /// Its pictures are denoised before they are compared.
    pub denoise: bool,
    training: Training,
    arguments: Arc<OneIntegrator>,
}

/// The options of one integrator.
#[derive(Parser, Debug)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct OneIntegrator {
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    paths: PathArgs,
    #[arg(long)]
    denoise: bool,
}

impl Candidate {
    /// Settings follow a colon and are the options of `render`: `spcbpt:connections=2,light-tracing`.
    ///
    /// # Errors
    /// No such integrator, a setting that it does not have.
    pub fn parse(label: &str) -> Result<Self, InputError> {
        let (name, settings) = label.split_once(':').unwrap_or((label, ""));
        let settings = settings.split(',').filter(|setting| !setting.is_empty());
        let options = settings.map(|setting| format!("--{setting}"));
        let arguments = [format!("--integrator={name}")].into_iter().chain(options);
        let parsed = OneIntegrator::try_parse_from(arguments).map_err(|error| {
            let text = error.to_string();
            let first = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
            let line: Vec<&str> = first.split_whitespace().collect();
            InputError::Usage(format!("the integrator '{label}': {}", line.join(" ")))
        })?;
        let (method, training) = (parsed.method.method()?, parsed.method.training()?);
        let method = method.ok_or_else(|| {
            InputError::Usage(format!(
                "the integrator '{label}': benchmarks compare what was chosen, not the choice; name an integrator"
            ))
        })?;
        if training.when == Some(When::Meanwhile) {
            return Err(InputError::Usage(format!(
                "the integrator '{label}': benchmarks stop a render's clock to compare its picture, and learning would go \
                 on uncounted; leave out learn=meanwhile, and measure it by 'halfway render --learn meanwhile --reference \
                 REF.exr --trace-error FILE.csv'"
            )));
        }
        // The same seed makes the same picture in every run.
        let training = Training { when: training.when.or(Some(When::First)), ..training };
        Ok(Self {
            label: label.to_owned(),
            method,
            denoise: parsed.denoise,
            training,
            arguments: Arc::new(parsed),
        })
    }

    pub fn options(&self, bench_scene: &BenchScene, seed: u64) -> RenderOptions {
        let options = RenderOptions {
            view: View { seed, ..bench_scene.options.view },
            method: self.method,
            training: self.training.clone(),
            first_hit_layers: self.denoise,
            through_mirrors: self.denoise,
            ..bench_scene.options.clone()
        };
        self.arguments.method.apply(self.arguments.paths.apply(options))
    }

    /// The same, denoised.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn denoised(&self) -> Result<Self, InputError> {
        let separator = if self.label.contains(':') { ',' } else { ':' };
        Self::parse(&format!("{}{separator}denoise", self.label))
    }

    /// Refuses what is denoised where errors are taken for noise.
    ///
    /// # Errors
    /// It is denoised.
    pub fn refuse_denoised(&self) -> Result<(), InputError> {
        match self.denoise {
            true => Err(InputError::Usage(format!(
                "the integrator '{}': what is denoised is measured by 'halfway bench trade'; leave out denoise",
                self.label
            ))),
            false => Ok(()),
        }
    }

    /// The flags by which `render` does the same.
    pub fn flags(&self) -> String {
        let (name, settings) = self.label.split_once(':').unwrap_or((&self.label, ""));
        let settings = settings.split(',').filter(|setting| !setting.is_empty());
        let settings: String = settings.map(|setting| format!(" --{}", setting.replace('=', " "))).collect();
        format!("-i {name}{settings}")
    }
}

/// `path,lvcbpt:connections=2,light-tracing,light`.
///
/// # Errors
/// As [`Candidate::parse`].
pub fn parse_integrators(list: &str) -> Result<Vec<Candidate>, InputError> {
    let mut labels: Vec<String> = Vec::new();
    for part in list.split(',') {
        let is_setting = !part.contains(':') && Descriptor::find(part).is_none();
        match labels.last_mut() {
            Some(last) if is_setting && last.contains(':') => *last = format!("{last},{part}"),
            _ => labels.push(part.to_owned()),
        }
    }
    labels.iter().map(|label| Candidate::parse(label)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::{Bdpt, Connections, LightTracing, LvcBpt};

    #[test]
    fn integrators_with_settings() {
        let list = "path,lvcbpt:connections=2,light-paths=500,light-tracing,bdpt,light:light-paths=7";
        let candidates = parse_integrators(list).expect("a good list");
        let labels: Vec<&str> = candidates.iter().map(|candidate| candidate.label.as_str()).collect();
        let cache = "lvcbpt:connections=2,light-paths=500,light-tracing";
        assert_eq!(labels, ["path", cache, "bdpt", "light:light-paths=7"]);
        let methods: Vec<Method> = candidates.iter().map(|candidate| candidate.method).collect();
        let cached = Method::LvcBpt(LvcBpt {
            light_paths: Some(500),
            connections: Connections::even(2),
            light_tracing: true,
        });
        let light = Method::Light(LightTracing { light_paths: Some(7) });
        assert_eq!(methods, [Method::Path, cached, Method::Bdpt(Bdpt { light_tracing: false }), light]);
        assert_eq!(candidates[1].flags(), "-i lvcbpt --connections 2 --light-paths 500 --light-tracing");
        assert_eq!(candidates[0].flags(), "-i path");
    }

    #[test]
    fn integrators_that_are_none() {
        for (list, phrases) in [
            ("path,photon", ["'photon'", "lvcbpt"]),
            ("", ["''", "path"]),
            ("path,", ["''", "path"]),
            ("lvcbpt:connections=2,photon", ["--photon", "unexpected"]),
            ("path:connections=2", ["--connections", "lvcbpt"]),
            ("lvcbpt:connections=many", ["many", "connections"]),
            ("lvcbpt:subspaces=8", ["--subspaces", "spcbpt"]),
            ("bdpt:integrator=path", ["--integrator", "multiple"]),
            ("bdpt:help", ["--help", "unexpected"]),
            ("path:max-depth=0", ["--max-depth", "0"]),
        ] {
            let said = parse_integrators(list).err().expect(list).to_string();
            for phrase in phrases {
                assert!(said.contains(phrase), "'{phrase}' not in: {said}");
            }
        }
    }
}
