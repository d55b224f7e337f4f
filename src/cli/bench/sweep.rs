//! `--sweep`: one setting with several values.

use super::candidate::Candidate;
use crate::cli::args::InputError;

/// A setting that is tried with several values, all others as they are.
pub struct Sweep {
    pub name: String,
    /// The integrator as it is without the setting, then with each of its values.
    pub candidates: Vec<Candidate>,
}

/// `connections=1,2,4` (of spcbpt), `lvcbpt:light-paths=100,1000`, `spcbpt:rounds=2,connections=1,2` (with two rounds
/// of training throughout), `bdpt:light-tracing` (without and with it).
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
            "--sweep '{text}' names no values; write INTEGRATOR:SETTING=VALUE,VALUE,..., for example \
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

    #[test]
    fn sweeps_make_candidates() {
        for (text, name, labels) in [
            (
                "connections=1,4",
                "connections of spcbpt",
                &["spcbpt", "spcbpt:connections=1", "spcbpt:connections=4"][..],
            ),
            ("path:max-depth=3", "max-depth of path", &["path", "path:max-depth=3"]),
            ("bdpt:light-tracing", "light-tracing of bdpt", &["bdpt", "bdpt:light-tracing"]),
            (
                "spcbpt:rounds=2,light-tracing,connections=1,2",
                "connections of spcbpt:rounds=2,light-tracing",
                &[
                    "spcbpt:rounds=2,light-tracing",
                    "spcbpt:rounds=2,light-tracing,connections=1",
                    "spcbpt:rounds=2,light-tracing,connections=2",
                ],
            ),
        ] {
            let sweep = parse_sweep(text).expect(text);
            assert_eq!(sweep.name, name);
            assert_eq!(sweep.candidates.iter().map(|one| one.label.as_str()).collect::<Vec<_>>(), labels);
        }
        for (text, phrase) in [
            ("", "no values"),
            ("connections=", "no values"),
            ("path:connections=1", "--connections"),
            ("rounds=x", "x"),
        ] {
            let said = parse_sweep(text).err().expect(text).to_string();
            assert!(said.contains(phrase), "'{phrase}' not in: {said}");
        }
    }
}
