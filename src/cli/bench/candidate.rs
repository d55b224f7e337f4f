//! Integrators with settings, as benchmarks are told of them.

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
    training: Training,
    paths: PathArgs,
}

/// The options of one integrator.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct OneIntegrator {
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    paths: PathArgs,
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
        if training.when == Some(When::Meanwhile) {
            return Err(InputError::Usage(format!(
                "the integrator '{label}': benchmarks stop a render's clock to look at it, and learning would go on for \
                 nothing; leave out learn=meanwhile, and measure it by 'halfway render --learn meanwhile --reference \
                 REF.exr --trace-error FILE.csv'"
            )));
        }
        // Who is measured does the same every time.
        let training = Training { when: training.when.or(Some(When::First)), ..training };
        Ok(Self { label: label.to_owned(), method, training, paths: parsed.paths })
    }

    pub fn options(&self, subject: &BenchScene, seed: u64) -> RenderOptions {
        let options = RenderOptions {
            view: View { seed, ..subject.options.clone().view },
            method: self.method,
            training: self.training.clone(),
            ..subject.options.clone()
        };
        self.paths.apply(options)
    }

    /// All that it does otherwise than others, defaults written out.
    pub fn settings(&self) -> String {
        format!("{:?} {:?} {:?}", self.method, self.training, self.paths)
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

/// A setting that is tried with several values, all others as they are.
pub struct Sweep {
    pub name: String,
    /// The integrator as it is without the setting, then with each of its values.
    pub candidates: Vec<Candidate>,
}

/// `connections=1,2,4` (of spcbpt), `lvcbpt:light-paths=100,1000`, `spcbpt:lessons=2,connections=1,2` (with two lessons
/// throughout), `bdpt:light-tracing` (without and with it).
///
/// # Errors
/// No values, or as [`Candidate::parse`].
pub fn parse_sweep(text: &str) -> Result<Sweep, InputError> {
    let (integrator, settings) = text.split_once(':').unwrap_or(("spcbpt", text));
    let parts: Vec<&str> = settings.split(',').collect();
    // The values of the last setting that has any; a flag has none.
    let last = parts.iter().rposition(|part| part.contains('=')).unwrap_or(parts.len() - 1);
    let (name, first) = parts[last].split_once('=').map_or((parts[last], None), |(name, v)| (name, Some(v)));
    if name.is_empty() || first.is_some_and(str::is_empty) {
        return Err(InputError::Usage(format!(
            "--knob '{text}' names no values; write INTEGRATOR:SETTING=VALUE,VALUE,..., for example \
             spcbpt:connections=1,2,4"
        )));
    }
    let fixed = parts[..last].join(",");
    let label = |setting: String| {
        let settings = [fixed.as_str(), &setting].into_iter().filter(|part| !part.is_empty());
        let settings = settings.collect::<Vec<_>>().join(",");
        if settings.is_empty() { integrator.to_owned() } else { format!("{integrator}:{settings}") }
    };
    let mut labels = vec![label(String::new())];
    match first {
        None => labels.push(label(name.to_owned())),
        Some(first) => {
            let values = std::iter::once(first).chain(parts[last + 1..].iter().copied());
            labels.extend(values.map(|value| label(format!("{name}={value}"))));
        }
    }
    let candidates = labels.iter().map(|label| Candidate::parse(label)).collect::<Result<_, _>>()?;
    let of = label(String::new());
    Ok(Sweep { name: format!("{name} of {of}"), candidates })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::{Bdpt, LightTracing, LvcBpt};

    #[test]
    fn integrators_with_settings() {
        let list = "path,lvcbpt:connections=2,light-paths=500,light-tracing,bdpt,light:light-paths=7";
        let candidates = parse_integrators(list).expect("a good list");
        let labels: Vec<&str> = candidates.iter().map(|candidate| candidate.label.as_str()).collect();
        let cache = "lvcbpt:connections=2,light-paths=500,light-tracing";
        assert_eq!(labels, ["path", cache, "bdpt", "light:light-paths=7"]);
        let methods: Vec<Method> = candidates.iter().map(|candidate| candidate.method).collect();
        let cached = Method::LvcBpt(LvcBpt { light_paths: Some(500), connections: 2, light_tracing: true });
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

    #[test]
    fn knobs_make_candidates() {
        for (text, name, labels) in [
            (
                "connections=1,4",
                "connections of spcbpt",
                &["spcbpt", "spcbpt:connections=1", "spcbpt:connections=4"][..],
            ),
            ("path:max-depth=3", "max-depth of path", &["path", "path:max-depth=3"]),
            ("bdpt:light-tracing", "light-tracing of bdpt", &["bdpt", "bdpt:light-tracing"]),
            (
                "spcbpt:lessons=2,light-tracing,connections=1,2",
                "connections of spcbpt:lessons=2,light-tracing",
                &[
                    "spcbpt:lessons=2,light-tracing",
                    "spcbpt:lessons=2,light-tracing,connections=1",
                    "spcbpt:lessons=2,light-tracing,connections=2",
                ],
            ),
        ] {
            let knob = parse_sweep(text).expect(text);
            assert_eq!(knob.name, name);
            assert_eq!(knob.candidates.iter().map(|one| one.label.as_str()).collect::<Vec<_>>(), labels);
        }
        for (text, phrase) in [
            ("", "no values"),
            ("connections=", "no values"),
            ("path:connections=1", "--connections"),
            ("lessons=x", "x"),
        ] {
            let said = parse_sweep(text).err().expect(text).to_string();
            assert!(said.contains(phrase), "'{phrase}' not in: {said}");
        }
    }
}
