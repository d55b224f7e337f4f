//! What there is to choose about learning.

use std::time::Duration;

use serde::Serialize;

use crate::subspace;

/// A camera path that is learnt from, in those that are shown: it has more light paths, its vertices are written down,
/// and the host works on them.
const COST_OF_A_PATH: f64 = 2.0;
/// Rounds at most, unless asked for or the render is known to be long enough for more.
pub const DEFAULT_ROUNDS: u32 = 5;
/// Rounds that may be asked for: each has twice the iterations of the one before.
pub const MOST_ROUNDS: u32 = 16;
/// Rounds at most in a long render; later ones would have no more connections to learn from.
pub const LONG_RENDER_ROUNDS: u32 = 7;

/// What to learn from, how, and for how long.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Training {
    /// So many full paths, found by path tracing before anything else, as published; `None`: paths that connections by
    /// subspaces find, guided by the rounds before.
    pub paths: Option<u32>,
    pub settings: subspace::Settings,
    /// Of learning from its own connections: models made one after the other, at most; `None`: as many as pay.
    pub rounds: Option<u32>,
    /// Where the last two rounds lowered the loss by a smaller share on average, there is no other; 0: that is no reason.
    pub least_gain: f64,
    /// Camera paths and time of the render to come, learning included, where they are known: there is no other round
    /// either where it would take a larger share of the render than it is likely to lower the picture's variance by.
    pub render_paths: Option<u64>,
    pub render_time: Option<Duration>,
    /// Before the first sample, or while the picture is rendered; `None`: as the device and the budget suggest.
    pub when: Option<When>,
}

/// When learning takes place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize)]
pub enum When {
    /// Before the first sample: the same seed makes the same picture.
    First,
    /// On a thread of its own, while it renders using what it knows so far; earlier samples then weigh less, and which
    /// sample uses which round is up to the clock.
    Meanwhile,
}

impl std::fmt::Display for When {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.pad(match self {
            Self::First => "first",
            Self::Meanwhile => "meanwhile",
        })
    }
}

impl Training {
    /// So many rounds, however little they gain.
    pub fn with_rounds(self, rounds: u32) -> Self {
        Self { rounds: Some(rounds), least_gain: 0.0, ..self }
    }

    /// Rounds at most, and where more of them pay.
    pub(super) fn most_rounds(&self) -> (u32, u32) {
        let knows_the_render = self.render_paths.is_some() || self.render_time.is_some();
        let long = if knows_the_render { LONG_RENDER_ROUNDS } else { DEFAULT_ROUNDS };
        self.rounds.map_or((DEFAULT_ROUNDS, long), |rounds| (rounds, rounds))
    }

    /// Share of the render that `paths` more camera paths would take, at so much time per path.
    pub(super) fn share_of_render(&self, paths: u64, time_per_path: Duration) -> f64 {
        let by_paths = self.render_paths.map(|all| COST_OF_A_PATH * paths as f64 / all as f64);
        let by_time =
            self.render_time.map(|all| time_per_path.as_secs_f64() * paths as f64 / all.as_secs_f64());
        by_paths.unwrap_or(0.0).max(by_time.unwrap_or(0.0))
    }
}

impl Default for Training {
    fn default() -> Self {
        Self {
            paths: None,
            settings: subspace::Settings::default(),
            rounds: None,
            least_gain: 0.03,
            render_paths: None,
            render_time: None,
            when: None,
        }
    }
}
