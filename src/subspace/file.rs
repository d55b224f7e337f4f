//! Models on disk, little endian:
//!
//! ```text
//! magic 8 bytes | version u32 | scene hash u64 | length of the payload u64 | checksum u64 | payload
//! ```
//!
//! The checksum is over the payload and the header before it. Lists in the payload have their length in front.

use std::path::Path;

use glam::Vec3;

use super::connections::{Connections, FirstConnections, MAX_CONNECTIONS};
use super::gamma::{Loss, Tried};
use super::guide::{GUIDE_CELLS, LightGuide};
use super::model::{CentroidMove, Counts, Model, Seconds, TrainingReport};
use super::settings::{MOST_SUBSPACES, Optimiser, Settings};
use super::sources::SourceLabels;
use super::tree::{MAX_DEPTH, Tree};
use crate::device::layout::TreeNode;
use crate::film::write::write_atomic;
use crate::subspace::SubspaceError;

const MAGIC: &[u8; 8] = b"halfwayS";
/// Of the format and of what its numbers mean: raised when either changes.
const VERSION: u32 = 7;
/// Magic, version, scene hash, length; the checksum follows.
const HEADER: usize = 28;

impl Model {
    /// Writes the file, or leaves an existing one as it was.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), SubspaceError> {
        Ok(write_atomic(path, &self.to_bytes())?)
    }

    /// The bytes of its file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let payload = encode(self);
        let mut bytes = Vec::with_capacity(HEADER + 8 + payload.len());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.scene_hash.to_le_bytes());
        bytes.extend((payload.len() as u64).to_le_bytes());
        bytes.extend(checksum(&bytes, &payload).to_le_bytes());
        bytes.extend(payload);
        bytes
    }

    /// Reads a model of the scene with this hash.
    ///
    /// # Errors
    /// As [`read`](Self::read), or a model of another scene.
    pub fn load(path: &Path, scene_hash: u64) -> Result<Self, SubspaceError> {
        let model = Self::read(path)?;
        if model.scene_hash != scene_hash {
            let (found, expected) = (model.scene_hash, scene_hash);
            return Err(SubspaceError::WrongScene { path: path.to_owned(), found, expected });
        }
        Ok(model)
    }

    /// Reads a model of any scene.
    ///
    /// # Errors
    /// A file that cannot be read, is no model, is of another version, cut off or damaged.
    pub fn read(path: &Path) -> Result<Self, SubspaceError> {
        let bytes =
            std::fs::read(path).map_err(|cause| SubspaceError::Read { path: path.to_owned(), cause })?;
        Self::from_bytes(path, &bytes)
    }

    /// Reads the bytes of a file, which lie in the file at `path`.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, SubspaceError> {
        let at = || path.to_owned();
        let mut header = Reader(bytes);
        if header.take(8) != Some(MAGIC) {
            return Err(SubspaceError::NotAModel { path: at() });
        }
        let truncated =
            |expected: u64| SubspaceError::Truncated { path: at(), found: bytes.len() as u64, expected };
        let least = || truncated(HEADER as u64 + 8);
        let version = header.u32().ok_or_else(least)?;
        if version != VERSION {
            return Err(SubspaceError::Version { path: at(), found: version, expected: VERSION });
        }
        let (scene_hash, length) = (header.u64().ok_or_else(least)?, header.u64().ok_or_else(least)?);
        let sum = header.u64().ok_or_else(least)?;
        let payload = header.0;
        if (payload.len() as u64) < length {
            return Err(truncated(length.saturating_add(HEADER as u64 + 8)));
        }
        let damaged = |what: &'static str| SubspaceError::Damaged { path: at(), what };
        if payload.len() as u64 > length {
            return Err(damaged("more bytes than announced"));
        }
        if checksum(&bytes[..HEADER], payload) != sum {
            return Err(damaged("its checksum does not fit"));
        }
        let mut reader = Reader(payload);
        let model = decode(&mut reader, scene_hash).filter(|_| reader.0.is_empty());
        let model = model.ok_or_else(|| damaged("its lists do not fit together"))?;
        if is_sound(&model) { Ok(model) } else { Err(damaged("numbers out of range")) }
    }
}

/// FNV-1a (Fowler, Noll, Vo), on words of eight bytes, the last filled with zeros.
fn checksum(header: &[u8], payload: &[u8]) -> u64 {
    let mix = |hash: u64, word: u64| {
        let mixed = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        // Upper bits reach the lower ones, which a product alone never does.
        mixed ^ (mixed >> 32)
    };
    header.chunks(8).chain(payload.chunks(8)).fold(0xcbf2_9ce4_8422_2325, |hash, chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        mix(hash, u64::from_le_bytes(word))
    })
}

/// What rendering relies on.
fn is_sound(model: &Model) -> bool {
    let k = model.subspaces as usize;
    let rows = model.gamma.chunks(k).all(|row| {
        let sum: f64 = row.iter().map(|&p| f64::from(p)).sum();
        row.iter().all(|p| *p >= 0.0) && (sum - 1.0).abs() < 1e-5
    });
    let labels = model.sources.iter().all(|of| {
        let cells = u64::from(of.divisions) * u64::from(of.divisions);
        cells > 0 && u64::from(of.first) + cells <= k as u64
    });
    let first = model.first_connections.iter().flat_map(|first| [first.count, first.made]);
    let counted =
        model.connections.counts.into_iter().chain(first).all(|n| (1..=MAX_CONNECTIONS).contains(&n));
    let weighed = model.connections.shares.iter().all(|share| *share > 0.0 && share.is_finite());
    // What has no chance would lose its light.
    let positive = |all: &[f32]| all.iter().all(|p| *p > 0.0 && *p <= 1.0);
    let guided = model.guide.iter().all(|guide| {
        let lit = guide.picks.iter().all(|p| (0.0..=1.0).contains(p)) && guide.picks.iter().any(|p| *p > 0.0);
        positive(&guide.cells) && lit
    });
    counted && weighed && guided && rows && labels && model.q.iter().all(|q| *q > 0.0 && q.is_finite())
}

fn encode(model: &Model) -> Vec<u8> {
    let mut out = Writer(Vec::new());
    let s = &model.settings;
    out.u32(s.subspaces.unwrap_or(0));
    out.f64s(&[s.source_share, f64::from(s.direction_weight), s.tree_stop]);
    out.f64s(&[s.uniform_share, s.power_share, s.held_out]);
    // No share is negative.
    out.f64(s.smoothing.unwrap_or(-1.0));
    out.u32s(&[s.lloyd_steps, s.tree_depth, s.tree_samples, s.light_guide.into()]);
    out.u32s(&[s.optimiser as u32, s.max_steps]);
    out.u32s(&model.connections.counts);
    out.u32s(&model.connections.shares.map(f32::to_bits));
    out.u32s(&[model.connections.thinning, model.connections.adapts].map(u32::from));
    out.u64(model.seed);
    out.u32(model.subspaces);
    for tree in [&model.eye_tree, &model.light_tree] {
        out.u32(tree.nodes().len() as u32);
        for node in tree.nodes() {
            out.u32s(&node.split.map(f32::to_bits));
            out.u32(node.child_kind);
        }
    }
    for side in &model.centroids {
        out.u32(side.len() as u32);
        for position in side.iter().flat_map(|centroid| [centroid.drawn, centroid.moved]) {
            out.u32s(&position.to_array().map(f32::to_bits));
        }
    }
    out.u32(model.sources.len() as u32);
    model.sources.iter().for_each(|of| out.u32s(&[of.first, of.divisions]));
    model.gamma.iter().chain(&model.q).for_each(|x| out.u32(x.to_bits()));
    out.u32(u32::from(model.guide.is_some()));
    if let Some(guide) = &model.guide {
        guide.cells.iter().chain(&guide.picks).for_each(|x| out.u32(x.to_bits()));
    }
    // None has no connections.
    out.u32(model.first_connections.map_or(0, |first| first.count));
    if let Some(first) = &model.first_connections {
        out.u32(first.made);
        out.f64s(&[first.variance, first.cost]);
    }

    let report = &model.report;
    count_fields(&mut report.counts.clone()).into_iter().for_each(|count| out.u64(*count));
    out.f64s(&report.row_entropy);
    out.f64s(&[report.q_spread, report.guide_gain]);
    second_fields(&mut report.seconds.clone()).into_iter().for_each(|time| out.f64(*time));
    out.u32s(&[report.best_step, report.losses.len() as u32]);
    for loss in &report.losses {
        out.u32(u32::from(loss.held_out.is_some()));
        out.f64s(&[loss.train, loss.held_out.unwrap_or(0.0), loss.smoothing]);
    }
    out.u32(report.tried.len() as u32);
    report.tried.iter().for_each(|tried| out.f64s(&[tried.smoothing, tried.held_out]));
    out.0
}

/// `None` where the bytes end early or a number has no meaning.
fn decode(from: &mut Reader, scene_hash: u64) -> Option<Model> {
    let (settings, connections, seed) = decode_settings(from)?;
    let subspaces = from.u32().filter(|k| (1..=MOST_SUBSPACES).contains(k))?;
    let mut tree = || {
        let node = |from: &mut Reader| {
            let split = [from.f32()?, from.f32()?, from.f32()?];
            Some(TreeNode { split, child_kind: from.u32()? })
        };
        let count = from.u32()? as usize;
        Tree::from_nodes(from.list(count, 16, node)?, MAX_DEPTH, subspaces)
    };
    let (eye_tree, light_tree) = (tree()?, tree()?);
    let mut side = || {
        let position = |from: &mut Reader| Some(Vec3::new(from.f32()?, from.f32()?, from.f32()?));
        let count = from.u32()? as usize;
        from.list(count, 24, |from| Some(CentroidMove { drawn: position(from)?, moved: position(from)? }))
    };
    let centroids = [side()?, side()?];
    let count = from.u32()? as usize;
    let sources =
        from.list(count, 8, |from| Some(SourceLabels { first: from.u32()?, divisions: from.u32()? }))?;
    let k = subspaces as usize;
    let gamma = from.list(k * k, 4, Reader::f32)?;
    let q = from.list(k, 4, Reader::f32)?;
    let guide = match from.u32()? {
        0 => None,
        _ => Some(LightGuide {
            cells: from.list(k * GUIDE_CELLS, 4, Reader::f32)?,
            picks: from.list(sources.len(), 4, Reader::f32)?,
        }),
    };
    let first_connections = match from.u32()? {
        0 => None,
        count => {
            Some(FirstConnections { count, made: from.u32()?, variance: from.f64()?, cost: from.f64()? })
        }
    };

    let mut report = TrainingReport::default();
    for count in count_fields(&mut report.counts) {
        *count = from.u64()?;
    }
    report.row_entropy = [from.f64()?, from.f64()?, from.f64()?];
    (report.q_spread, report.guide_gain) = (from.f64()?, from.f64()?);
    for time in second_fields(&mut report.seconds) {
        *time = from.f64()?;
    }
    report.best_step = from.u32()?;
    let count = from.u32()? as usize;
    report.losses = from.list(count, 28, |from| {
        let judged = from.u32()? != 0;
        let (train, held_out, smoothing) = (from.f64()?, from.f64()?, from.f64()?);
        Some(Loss { train, held_out: judged.then_some(held_out), smoothing })
    })?;
    let count = from.u32()? as usize;
    report.tried =
        from.list(count, 16, |from| Some(Tried { smoothing: from.f64()?, held_out: from.f64()? }))?;
    Some(Model {
        scene_hash,
        connections,
        seed,
        settings,
        subspaces,
        eye_tree,
        light_tree,
        centroids,
        sources,
        gamma,
        q,
        guide,
        first_connections,
        report,
    })
}

/// The settings, what it was trained for, and the seed.
fn decode_settings(from: &mut Reader) -> Option<(Settings, Connections, u64)> {
    let subspaces = Some(from.u32()?).filter(|k| *k > 0);
    let source_share = from.f64()?;
    let direction_weight = from.f64()? as f32;
    let tree_stop = from.f64()?;
    let (uniform_share, power_share, held_out) = (from.f64()?, from.f64()?, from.f64()?);
    let smoothing = Some(from.f64()?).filter(|share| *share >= 0.0);
    let (lloyd_steps, tree_depth, tree_samples) = (from.u32()?, from.u32()?, from.u32()?);
    let light_guide = from.u32()? != 0;
    let optimiser = from.u32()?;
    let optimiser = [Optimiser::Mm, Optimiser::Softmax, Optimiser::Mirror]
        .into_iter()
        .find(|known| *known as u32 == optimiser)?;
    let max_steps = from.u32()?;
    let counts = [from.u32()?, from.u32()?, from.u32()?];
    let shares = [from.f32()?, from.f32()?, from.f32()?, from.f32()?];
    let connections = Connections { counts, shares, thinning: from.u32()? != 0, adapts: from.u32()? != 0 };
    let seed = from.u64()?;
    let settings = Settings {
        subspaces,
        source_share,
        direction_weight,
        lloyd_steps,
        tree_depth,
        tree_stop,
        tree_samples,
        uniform_share,
        power_share,
        smoothing,
        light_guide,
        optimiser,
        max_steps,
        held_out,
    };
    Some((settings, connections, seed))
}

/// The counts in the order of the file.
fn count_fields(c: &mut Counts) -> [&mut u64; 14] {
    [
        &mut c.paths,
        &mut c.nodes,
        &mut c.held_out_paths,
        &mut c.faulty_paths,
        &mut c.faulty_light_samples,
        &mut c.unreachable_paths,
        &mut c.clamped_paths,
        &mut c.light_samples,
        &mut c.learnt_rows,
        &mut c.active_columns,
        &mut c.floored_columns,
        &mut c.source_subspaces,
        &mut c.eye_tree_nodes,
        &mut c.light_tree_nodes,
    ]
}

/// The times in the order of the file.
fn second_fields(s: &mut Seconds) -> [&mut f64; 7] {
    [&mut s.weights, &mut s.trees, &mut s.labels, &mut s.q, &mut s.gamma, &mut s.guide, &mut s.total]
}

struct Writer(Vec<u8>);

impl Writer {
    fn u32(&mut self, x: u32) {
        self.0.extend(x.to_le_bytes());
    }

    fn u64(&mut self, x: u64) {
        self.0.extend(x.to_le_bytes());
    }

    fn f64(&mut self, x: f64) {
        self.u64(x.to_bits());
    }

    fn u32s(&mut self, all: &[u32]) {
        all.iter().for_each(|x| self.u32(*x));
    }

    fn f64s(&mut self, all: &[f64]) {
        all.iter().for_each(|x| self.f64(*x));
    }
}

/// The bytes that are left.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, left) = self.0.split_at_checked(count)?;
        self.0 = left;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    fn f32(&mut self) -> Option<f32> {
        Some(f32::from_bits(self.u32()?))
    }

    fn f64(&mut self) -> Option<f64> {
        Some(f64::from_bits(self.u64()?))
    }

    /// `count` entries of so many bytes; memory is asked for only if the bytes are there.
    fn list<T>(
        &mut self,
        count: usize,
        bytes: usize,
        mut entry: impl FnMut(&mut Self) -> Option<T>,
    ) -> Option<Vec<T>> {
        if count.checked_mul(bytes)? > self.0.len() {
            return None;
        }
        (0..count).map(|_| entry(self)).collect()
    }
}
