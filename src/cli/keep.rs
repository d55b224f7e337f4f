//! Renders of hours: checkpoints to go on from, and portions of one render.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use super::args::{InputError, parse_duration, try_output};
use super::{CliError, text};
use crate::device::Traversal;
use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::FilmError;
use crate::film::checkpoint::{SavedRender, most_bytes};
use crate::film::write::remove_leftovers;
use crate::integrator::Method;
use crate::integrator::method::Setting;
use crate::render::{Keeping, Origin, RenderError, RenderOptions, Renderer, maker, picture_of, take_up};
use crate::scene::Scene;

const HEADING: &str = "Long renders";
/// Between two checkpoints, unless asked for.
const EVERY: Duration = Duration::from_secs(60);

/// How a render survives, and which part of it is to be made.
#[derive(Args, Debug, Default)]
pub struct KeepArgs {
    /// Keep all that the render knows in this file, to go on from: `halfway resume FILE`. It is written on the way, at the end,
    /// and on Ctrl-C, SIGTERM and SIGUSR1; a file there is replaced when the new one is whole.
    #[arg(long, value_name = "FILE", help_heading = HEADING)]
    checkpoint: Option<PathBuf>,
    /// Time between two checkpoints (default: 60s).
    #[arg(long, value_name = "TIME", value_parser = parse_duration, requires = "checkpoint", help_heading = HEADING)]
    checkpoint_every: Option<Duration>,
    /// Go on from a checkpoint of the same render: the picture is that of a render that was never stopped, bit for bit. Limits
    /// and outputs may be others.
    #[arg(long, value_name = "FILE", help_heading = HEADING)]
    resume: Option<PathBuf>,
    #[arg(long, value_name = "A..B", value_parser = parse_samples, help_heading = HEADING,
          conflicts_with_all = ["spp", "time", "error", "strategies", "debug", "tev", "save_every", "reference", "trace_error"],
          help = format!("Render only the samples A up to B of the picture, B left out, into a portion: a .part file for \
                          `halfway merge`. Multiples of {SAMPLES_A_GROUP}; of 64 they make the smallest files"))]
    pub samples: Option<Range<u32>>,
    /// The command that renders it, where that is not the one that was given.
    #[arg(skip)]
    command: Option<Vec<String>>,
}

/// `64..128`.
fn parse_samples(text: &str) -> Result<Range<u32>, String> {
    let range = text.split_once("..").and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?));
    let whole = |sample: u32| sample.is_multiple_of(SAMPLES_A_GROUP);
    range.filter(|range: &Range<u32>| range.start < range.end && whole(range.start) && whole(range.end)).ok_or_else(|| {
        format!(
            "takes the first sample and the one after the last, such as 64..128: multiples of {SAMPLES_A_GROUP}, since \
             samples come in groups of as many"
        )
    })
}

impl KeepArgs {
    /// Goes on from a file, which is also where its checkpoints go, by a command that says so.
    pub fn going_on(self, from: &Path, command: Vec<String>) -> Self {
        let file = Some(from.to_owned());
        Self { checkpoint: file.clone(), resume: file, command: Some(command), ..self }
    }

    /// There are checkpoints.
    pub fn keeps(&self) -> bool {
        self.checkpoint.is_some()
    }

    /// The file that it goes on from.
    pub fn resumes(&self) -> Option<&Path> {
        self.resume.as_deref()
    }

    /// What traced the rays of the render that it goes on with.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn traced_by(&self) -> Result<Option<Traversal>, FilmError> {
        let Some(path) = &self.resume else { return Ok(None) };
        let header = SavedRender::read_header(path)?;
        Ok(header.devices.first().map(|made_by| maker(made_by).1))
    }

    /// Tries the files that are to be written.
    ///
    /// # Errors
    /// They cannot be.
    pub fn try_outputs(&self) -> Result<(), InputError> {
        self.checkpoint.iter().try_for_each(|file| try_output(file))
    }

    /// The words that render it, without the program's name.
    pub fn command(&self) -> Vec<String> {
        self.command.clone().unwrap_or_else(|| without(&text::words(), &["--resume"]))
    }

    /// What files of this render say.
    pub fn keeping(&self, scene: &Scene, options: &RenderOptions, origin: &Origin) -> Keeping {
        let camera = scene.cameras.get(options.camera);
        Keeping {
            picture: camera.map(|camera| picture_of(origin.scene_hash, camera, options)).unwrap_or_default(),
            origin: origin.clone(),
            command: with_method(self.command(), options.method),
            folder: std::env::current_dir().unwrap_or_default().to_string_lossy().into_owned(),
            end: self.samples.as_ref().map(|range| range.end),
        }
    }

    /// What there is to go on from; the options get its model.
    ///
    /// # Errors
    /// A file that cannot be read, or is of another render.
    pub fn take_up(
        &self,
        keeping: &Keeping,
        options: &mut RenderOptions,
    ) -> Result<Option<SavedRender>, CliError> {
        let Some(path) = &self.resume else { return Ok(None) };
        let saved = SavedRender::read(path)?;
        take_up(path, &saved, keeping, options)?;
        Ok(Some(saved))
    }

    /// Goes on from what was taken up, or begins with the portion.
    ///
    /// # Errors
    /// A lost device, a file that does not say where its render stood.
    pub fn begin(&self, renderer: &mut Renderer, saved: Option<SavedRender>) -> Result<(), RenderError> {
        match (&self.resume, saved, &self.samples) {
            (Some(path), Some(saved), _) => renderer.go_on_from(path, saved)?,
            (_, _, Some(range)) => renderer.begin_at(range.start),
            _ => {}
        }
        Ok(())
    }

    /// What keeps checkpoints, where they are asked for; says how large they get.
    pub fn keeper(&self, keeping: Keeping, options: &RenderOptions, quiet: bool) -> Option<Keeper> {
        let path = self.checkpoint.clone()?;
        remove_leftovers(&path);
        if !quiet {
            eprintln!(
                "checkpoint {}: about {:.0} MB, up to twice as much where it is noisy",
                path.display(),
                most_bytes(options.view.region().pixels().into(), options.halves) as f64 * 1e-6
            );
        }
        let every = self.checkpoint_every.unwrap_or(EVERY);
        Some(Keeper { path, every, keeping, last: Instant::now(), unsaved: false })
    }
}

/// Writes checkpoints.
pub struct Keeper {
    pub path: PathBuf,
    every: Duration,
    keeping: Keeping,
    last: Instant,
    /// The last one could not be written.
    unsaved: bool,
}

impl Keeper {
    pub fn is_due(&self) -> bool {
        self.last.elapsed() >= self.every
    }

    /// Writes one. What cannot be written is no reason to end: the last one stays, and there is another try.
    ///
    /// # Errors
    /// A lost device.
    pub fn write(&mut self, renderer: &mut Renderer) -> Result<Result<(), FilmError>, RenderError> {
        let start = Instant::now();
        let written = renderer.saved(&self.keeping, Vec::new())?.save(&self.path);
        log::info!("checkpoint: {:.2} s", start.elapsed().as_secs_f64());
        // Once, not every time.
        if let Some(error) = written.as_ref().err().filter(|_| !self.unsaved) {
            log::warn!("{error}; the render goes on");
        }
        self.unsaved = written.is_err();
        self.last = Instant::now();
        Ok(written)
    }
}

/// A command that names its integrator, where it left that to be chosen: another budget could choose otherwise.
fn with_method(command: Vec<String>, method: Method) -> Vec<String> {
    if command.iter().any(|word| word.len() > 2 && word.starts_with("-i")) {
        return command;
    }
    let flag = |word: &String| word == "-i" || word.starts_with("--integrator");
    let named = command.iter().position(flag).and_then(|at| match command[at].split_once('=') {
        Some((_, name)) => Some(name),
        None => command.get(at + 1).map(String::as_str),
    });
    if named.is_some_and(|name| name != "auto") {
        return command;
    }
    let mut command = without(&command, &["-i", "--integrator"]);
    command.extend(["-i".into(), method.name().into()]);
    if method.descriptor().takes(Setting::LightTracing) {
        let flag = if method.plan().to_camera { "--light-tracing" } else { "--no-light-tracing" };
        command.push(flag.into());
    }
    command
}

/// Words of a command without these flags and their values.
pub fn without(words: &[String], flags: &[&str]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let is_flag =
            |flag: &str| word.strip_prefix(flag).is_some_and(|rest| rest.is_empty() || rest.starts_with('='));
        match flags.iter().any(|flag| is_flag(flag)) {
            true if word.contains('=') => {}
            true => drop(words.next()),
            false => kept.push(word.clone()),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portions_are_whole_groups() {
        assert_eq!(parse_samples("64..128"), Ok(64..128));
        assert_eq!(parse_samples("0..8"), Ok(0..8));
        for text in ["", "64", "64..", "..64", "64..64", "128..64", "4..64", "0..63", "-8..8", "0..8..16"] {
            assert!(parse_samples(text).unwrap_err().contains("multiples of 8"), "{text}");
        }
    }

    #[test]
    fn a_command_that_is_kept_names_its_integrator() {
        let kept = |line: &str| {
            let words = line.split(' ').map(String::from).collect();
            with_method(words, (crate::integrator::method::SPCBPT.make)(&Default::default())).join(" ")
        };
        for line in ["render a.glb -i path", "render a.glb -ipath", "render a.glb --integrator=path"] {
            assert_eq!(kept(line), line);
        }
        for line in ["render a.glb", "render a.glb -i auto", "render --integrator=auto a.glb"] {
            assert_eq!(kept(line), "render a.glb -i spcbpt --no-light-tracing");
        }
    }

    #[test]
    fn flags_are_taken_out_of_a_command() {
        let words: Vec<String> =
            "render a.glb --spp 64 --resume=x.checkpoint -o b.exr".split(' ').map(String::from).collect();
        assert_eq!(without(&words, &["--spp", "--resume"]).join(" "), "render a.glb -o b.exr");
        assert_eq!(without(&words, &["--sp"]), words);
    }
}
