//! Portions of one render, added up.
//!
//! Sums are exact and blocks are summed in the order of their groups, so that the merged picture is that of one render of
//! all samples, bit for bit, in whatever portions it came and in whatever steps it was merged.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;

use super::checkpoint::{Header, Samples, SavedRender};
use super::{Attribute, FilmError};

/// All samples of the portions.
pub struct Merged {
    pub saved: SavedRender,
    /// Samples that are not there, and had to be.
    pub missing: Vec<Range<u32>>,
    /// Where a render stood, for each portion.
    pub runs: Vec<serde_json::Value>,
}

/// What attributes of portions come to together.
const SUMS: [&str; 4] = ["spp", "seconds", "preprocessingSeconds", "nonFiniteSamples"];
const LINES: [&str; 2] = ["warnings", "caveats"];

/// Adds portions up, one at a time, in the order of their samples. `samples`: those that are wanted, where that is known:
/// else all from the first portion's on, whichever that is. `allow_missing`: what is not there is not asked for.
///
/// # Errors
/// Portions of different pictures, that overlap, or that leave gaps; files that cannot be read. Each is named.
pub fn merge(
    paths: &[PathBuf],
    samples: Option<Range<u32>>,
    allow_missing: bool,
) -> Result<Merged, FilmError> {
    let mut portions = Vec::new();
    for path in paths {
        portions.push((path.clone(), SavedRender::read_header(path)?));
    }
    portions.sort_by_key(|(_, header)| header.samples.first);
    let refuse = |path: &Path, reason: String| Err(FilmError::Merge { path: path.to_owned(), reason });
    let Some(((first_path, first), others)) = portions.split_first() else {
        return Err(FilmError::Merge {
            path: PathBuf::new(),
            reason: "no portions; name one at least".into(),
        });
    };
    for (path, header) in others {
        let different = different(first, header);
        if !different.is_empty() {
            let reason = format!(
                "it is of another picture than {}: {}; leave it out",
                first_path.display(),
                different.join("; ")
            );
            return refuse(path, reason);
        }
    }
    let mut missing = Vec::new();
    for (path, header) in &portions {
        let Samples { next, end: Some(end), .. } = header.samples else { continue };
        if next < end && !allow_missing {
            let reason = format!(
                "it has samples {} up to {next} only, not to {end}: it was stopped; finish it (halfway resume {}), or merge \
                 what there is with --allow-missing",
                header.samples.first,
                path.display()
            );
            return refuse(path, reason);
        }
    }
    for pair in portions.windows(2) {
        let [(before, Header { samples: a, .. }), (path, Header { samples: b, .. })] = pair else { continue };
        if a.next > b.first {
            let reason = format!(
                "its samples {}..{} overlap {}..{} of {}; leave one of them out",
                b.first,
                b.next,
                a.first,
                a.next,
                before.display()
            );
            return refuse(path, reason);
        }
        missing.push(a.next..b.first);
    }
    let last = portions.last().map_or(0, |(_, header)| header.samples.next);
    if let Some(wanted) = &samples {
        missing.insert(0, wanted.start..first.samples.first);
        missing.push(last..wanted.end);
        if first.samples.first < wanted.start || last > wanted.end {
            let (found, reason) = (first.samples.first..last, "leave out what is not of it");
            return refuse(
                first_path,
                format!("the portions have samples {found:?}, not {wanted:?}; {reason}"),
            );
        }
    }
    missing.retain(|range| !range.is_empty());
    if !missing.is_empty() && !allow_missing {
        let ranges: Vec<String> =
            missing.iter().map(|range| format!("{}..{}", range.start, range.end)).collect();
        let reason = format!(
            "samples {} are in none of the portions; render them (--samples), or merge what there is with --allow-missing",
            ranges.join(" and ")
        );
        return refuse(first_path, reason);
    }
    add_up(portions, missing)
}

/// Names of what two pictures do not have in common.
fn different(a: &Header, b: &Header) -> Vec<String> {
    let mut found = a.differences(&b.picture);
    if found.is_empty() && (a.size, a.radiance_exponent) != (b.size, b.radiance_exponent) {
        found.push("number of pixels or their unit".into());
    }
    found
}

fn add_up(portions: Vec<(PathBuf, Header)>, missing: Vec<Range<u32>>) -> Result<Merged, FilmError> {
    let mut merged: Option<SavedRender> = None;
    let (mut runs, mut parts) = (Vec::new(), Vec::new());
    let paths: Vec<PathBuf> = portions.into_iter().map(|(path, _)| path).collect();
    // The next one is read while one is added, and no more than that.
    let (sender, read) = mpsc::sync_channel(0);
    thread::scope(|scope| {
        scope.spawn(move || {
            for path in paths {
                let saved = SavedRender::read(&path);
                if sender.send((path, saved)).is_err() {
                    break;
                }
            }
        });
        for (path, saved) in read {
            let saved = saved?;
            if !saved.film.sums.is_even() {
                let reason = "it learnt while it rendered, so that its samples have weights of their own; use portions that \
                              have a --model";
                return Err(FilmError::Merge { path, reason: reason.into() });
            }
            runs.push(saved.header.run.clone());
            let Samples { first, next, .. } = saved.header.samples;
            parts.push(format!("{first}..{next}"));
            match &mut merged {
                // Halves of a portion are none of the whole.
                None => merged = Some(SavedRender { half: None, ..saved }),
                Some(merged) => {
                    // Nothing comes any more that is before this.
                    merged.film.fold(first);
                    add_header(&mut merged.header, saved.header);
                    merged.film.add(saved.film);
                    if merged.layers.is_empty() {
                        merged.layers = saved.layers;
                    }
                }
            }
        }
        Ok(())
    })?;
    let Some(mut saved) = merged else {
        return Err(FilmError::Merge {
            path: PathBuf::new(),
            reason: "no portions; name one at least".into(),
        });
    };
    saved.film.fold(saved.header.samples.next);
    saved.header.run = serde_json::Value::Array(runs.clone());
    saved.header.metadata.retain(|(name, _)| name != "portions");
    saved.header.metadata.push(("portions".into(), Attribute::Text(parts.join(", "))));
    Ok(Merged { saved, missing, runs })
}

/// Adds what a portion says to what the portions before it say.
fn add_header(all: &mut Header, header: Header) {
    all.samples.next = header.samples.next;
    all.samples.end = Some(header.samples.next);
    for device in header.devices {
        if !all.devices.contains(&device) {
            all.devices.push(device);
        }
    }
    for (name, value) in header.metadata {
        let known = all.metadata.iter_mut().find(|(other, _)| *other == name).map(|(_, value)| value);
        match (known, value) {
            (Some(Attribute::Number(sum)), Attribute::Number(number)) if SUMS.contains(&name.as_str()) => {
                *sum += number
            }
            (Some(Attribute::Text(all)), Attribute::Text(lines)) if LINES.contains(&name.as_str()) => {
                for line in lines.lines() {
                    if !all.lines().any(|known| known == line) {
                        all.push('\n');
                        all.push_str(line);
                    }
                }
            }
            (Some(_), _) => {}
            (None, value) => all.metadata.push((name, value)),
        }
    }
    let devices = Attribute::Text(all.devices.join("; "));
    if let Some((_, value)) = all.metadata.iter_mut().find(|(name, _)| name == "device") {
        *value = devices;
    }
}
