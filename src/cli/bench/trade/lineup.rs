//! Which integrators are measured, and for which of the page's tables.

use super::TradeArgs;
use crate::cli::args::InputError;
use crate::cli::bench::candidate::{Candidate, parse_integrators};
use crate::cli::bench::sweep::{Sweep, parse_sweep};

/// All integrators that render, and for which table.
pub struct Lineup {
    /// Each once: those of --integrators, then those of sweeps.
    pub all: Vec<Candidate>,
    /// How many of them are of --integrators.
    pub listed: usize,
    pub sweeps: Vec<Sweep>,
}

impl Lineup {
    /// # Errors
    /// An integrator or a sweep that cannot be read, an integrator that is named twice.
    pub fn new(args: &TradeArgs) -> Result<Self, InputError> {
        let mut all: Vec<Candidate> = Vec::new();
        let sweeps = args.sweep.iter().map(|sweep| parse_sweep(sweep)).collect::<Result<Vec<_>, _>>()?;
        let mut listed = Vec::new();
        for one in parse_integrators(&args.integrators)? {
            let denoised = if args.denoise && !one.denoise { Some(one.denoised()?) } else { None };
            listed.push(one);
            listed.extend(denoised);
        }
        let is_new = |all: &[Candidate], one: &Candidate| all.iter().all(|other| other.label != one.label);
        for one in &listed {
            if !is_new(&all, one) {
                return Err(InputError::Usage(format!("--integrators names '{}' twice", one.label)));
            }
            all.push(one.clone());
        }
        for one in sweeps.iter().flat_map(|sweep| &sweep.candidates) {
            if is_new(&all, one) {
                all.push(one.clone());
            }
        }
        Ok(Self { all, listed: listed.len(), sweeps })
    }
}
