//! Integrators with settings, as benchmarks are told of them.

use clap::{Parser, ValueEnum};

use super::input::InputError;
use super::method::{IntegratorName, MethodArgs};
use super::subject::Subject;
use crate::integrator::{Method, Training};
use crate::render::RenderOptions;

/// An integrator as it is named on the command line.
#[derive(Clone)]
pub struct Candidate {
    pub label: String,
    pub method: Method,
    training: Training,
    max_depth: Option<u32>,
}

/// The options of one integrator.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct OneIntegrator {
    #[command(flatten)]
    method: MethodArgs,
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    max_depth: Option<u32>,
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
        Ok(Self { label: label.to_owned(), method, training, max_depth: parsed.max_depth })
    }

    pub fn options(&self, subject: &Subject, seed: u64) -> RenderOptions {
        RenderOptions {
            method: self.method,
            training: self.training.clone(),
            max_depth: self.max_depth.or(subject.options.max_depth),
            seed,
            ..subject.options.clone()
        }
    }
}

/// `path,lvcbpt:connections=2,light-tracing,light`.
///
/// # Errors
/// As [`Candidate::parse`].
pub fn parse_integrators(list: &str) -> Result<Vec<Candidate>, InputError> {
    let mut labels: Vec<String> = Vec::new();
    for part in list.split(',') {
        let is_setting = !part.contains(':') && IntegratorName::from_str(part, false).is_err();
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

    #[test]
    fn integrators_with_settings() {
        let list = "path,lvcbpt:connections=2,light-paths=500,light-tracing,bdpt,light:light-paths=7";
        let candidates = parse_integrators(list).expect("a good list");
        let labels: Vec<&str> = candidates.iter().map(|candidate| candidate.label.as_str()).collect();
        let cache = "lvcbpt:connections=2,light-paths=500,light-tracing";
        assert_eq!(labels, ["path", cache, "bdpt", "light:light-paths=7"]);
        let methods: Vec<Method> = candidates.iter().map(|candidate| candidate.method).collect();
        let cached = Method::LvcBpt { light_paths: Some(500), connections: 2, light_tracing: true };
        let light = Method::Light { light_paths: Some(7) };
        assert_eq!(methods, [Method::Path, cached, Method::Bdpt { light_tracing: false }, light]);
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
