//! Every kernel that a scene can ask for is valid WGSL (S-03): the kernels of every method, for sets of features in which
//! each pair of them occurs on and off, as far as a scene can have them so. No device is needed.

use std::collections::{BTreeSet, HashSet};

use halfway::device::scene::MOST_OTHER_BUFFERS;
use halfway::device::shader::stitch;
use halfway::device::{Feature, Features, PagedBuffer, Pages};
use halfway::integrator::kernels::{forms, kernels};
use halfway::integrator::method::Given;
use halfway::integrator::{METHODS, Plan, RecordWeights};
use halfway::scene::SceneFeatures;
use halfway::scene::builtin::{NAMES, builtin};
use rayon::prelude::*;

use crate::random::Stream;
use crate::specialised::everything;

/// Every method, with light tracing and without, by either form of weights that know of records.
fn plans() -> Vec<Plan> {
    let with = |light_tracing, weights| {
        let given = Given { light_tracing, record_weights: Some(weights), ..Given::default() };
        METHODS.map(|method| (method.make)(&given).plan())
    };
    let forms = [RecordWeights::Nabata, RecordWeights::Simple];
    forms.into_iter().flat_map(|form| [false, true].map(|traces| with(traces, form))).flatten().collect()
}

/// Sets of features that are tried for each pair's values.
const FILLS: usize = 8;

/// What kernels may have of the device and of how the scene is stored on it.
const DEVICES: [&[Feature]; 4] = [
    &[],
    &[Feature::RayQuery],
    &[Feature::Software, Feature::DeepTree, Feature::Coincident, Feature::ThinGaps, Feature::Instances],
    &[Feature::RayQuery, Feature::Coincident, Feature::ThinGaps, Feature::Instances],
];

/// The set of features nearest to `bits` that a scene may have: bit i is the i-th feature of scenes. Two bits above them
/// are the device's number.
fn reachable(bits: u32) -> u32 {
    let mut features = SceneFeatures::default();
    for (i, feature) in Feature::of_scenes().enumerate() {
        *feature.switch(&mut features).expect("a feature of scenes") = bits >> i & 1 == 1;
    }
    let device = bits >> Feature::of_scenes().count() << Feature::of_scenes().count();
    device | bits_of(features.consistent())
}

fn bits_of(mut features: SceneFeatures) -> u32 {
    Feature::of_scenes()
        .enumerate()
        .map(|(i, feature)| u32::from(*feature.switch(&mut features).expect("a feature of scenes")) << i)
        .sum()
}

/// The pairs of two bits' values that a set has, a bit each.
fn pairs(bits: u32, count: usize) -> Vec<u64> {
    let mut pairs = vec![0u64; (count * count * 4).div_ceil(64)];
    for i in 0..count {
        for j in 0..i {
            let pair = (i * count + j) * 4 + (bits >> i & 1) as usize * 2 + (bits >> j & 1) as usize;
            pairs[pair / 64] |= 1 << (pair % 64);
        }
    }
    pairs
}

/// Sets of features that scenes may have, each on a device: none, all, and more until every pair of values that is possible
/// occurs, of features or of a feature and the device, each time the set that adds most of some for each pair.
fn scenes() -> Vec<u32> {
    let count = Feature::of_scenes().count() + 2;
    let all = (1u32 << count) - 1;
    let mut stream = Stream::new(1);
    let mut candidates: BTreeSet<u32> = BTreeSet::new();
    for (i, j) in (0..count).flat_map(|i| (0..i).map(move |j| (i, j))) {
        for values in (0..4).flat_map(|values| [values; FILLS]) {
            let others = stream.word() & all & !(1 << i | 1 << j);
            candidates.insert(reachable(others | (values & 1) << i | values >> 1 << j));
        }
    }
    let candidates: Vec<(u32, Vec<u64>)> =
        candidates.into_iter().map(|bits| (bits, pairs(bits, count))).collect();
    let none = || vec![0u64; candidates[0].1.len()];
    let either = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(b).map(|(a, b)| a | b).collect();
    // Millions of sets, of which scenes may have few; those they may have on every device.
    let of_scenes = Feature::of_scenes().count();
    let reached: HashSet<u32> = (0..1u32 << of_scenes).into_par_iter().map(reachable).collect();
    let on_devices = |scene: u32| (0..DEVICES.len() as u32).map(move |device| scene | device << of_scenes);
    let mut missing =
        reached.into_par_iter().flat_map_iter(on_devices).map(|bits| pairs(bits, count)).reduce(none, either);
    let cover = |missing: &mut [u64], bits: u32| {
        missing.iter_mut().zip(pairs(bits, count)).for_each(|(a, b)| *a &= !b);
    };
    let mut scenes = BTreeSet::from([0, all].map(reachable));
    scenes.iter().for_each(|&bits| cover(&mut missing, bits));
    // Sets by chance are tried, but no pair that any set has is left out.
    while missing.iter().any(|&pairs| pairs != 0) {
        let adds = |pairs: &[u64]| missing.iter().zip(pairs).map(|(a, b)| (a & b).count_ones()).sum::<u32>();
        let (best, _) = candidates.iter().max_by_key(|(_, pairs)| adds(pairs)).expect("a candidate");
        assert!(scenes.insert(*best), "no candidate has the pairs that are left: {missing:?}");
        cover(&mut missing, *best);
    }
    scenes.into_iter().collect()
}

/// A set's features, with those of its device.
fn features(bits: u32) -> Features {
    let scene: Features = Feature::of_scenes()
        .enumerate()
        .filter(|(i, _)| bits >> i & 1 == 1)
        .map(|(_, feature)| feature)
        .collect();
    scene.with(DEVICES[(bits >> Feature::of_scenes().count()) as usize])
}

/// Every text once: many sets of features make the same one.
fn assert_valid(scenes: impl IntoIterator<Item = Features>) {
    let plans = plans();
    let mut wanted: HashSet<(&str, Features)> = HashSet::new();
    for scene in scenes {
        for plan in &plans {
            wanted.extend(forms(plan, scene).into_iter().flat_map(|form| kernels(plan, form)));
        }
    }
    let mut seen = HashSet::new();
    let mut texts = Vec::new();
    let wanted: Vec<(&str, Features)> = wanted.into_iter().collect();
    // A part at a time: most texts are alike, and all of them would take gigabytes.
    for part in wanted.chunks(1024) {
        let stitched = part.par_iter().map(|&(kernel, features)| {
            let stitched = stitch(kernel, features).unwrap_or_else(|error| panic!("{kernel}: {error}"));
            (kernel, features, stitched)
        });
        let stitched: Vec<_> = stitched.collect();
        texts.extend(stitched.into_iter().filter(|(_, _, stitched)| seen.insert(stitched.code.clone())));
    }
    let faults: Vec<String> = texts
        .par_iter()
        .filter_map(|(kernel, features, stitched)| {
            let fault = match stitched.validate() {
                Err(error) => error.to_string(),
                Ok((module, info)) => {
                    let uses = info.get_entry_point(0);
                    let storage = |space| matches!(space, naga::AddressSpace::Storage { .. });
                    let bound = module
                        .global_variables
                        .iter()
                        .filter(|(handle, variable)| storage(variable.space) && !uses[*handle].is_empty());
                    let (bound, extra) = (bound.count() as u32, features.pages().extra());
                    if bound <= MOST_OTHER_BUFFERS + extra {
                        return None;
                    }
                    format!("{bound} buffers, {extra} of them pages")
                }
            };
            Some(format!("{kernel} with {features:?}: {fault}"))
        })
        .collect();
    println!("{} texts of {} kernels", texts.len(), wanted.len());
    assert!(faults.is_empty(), "{} of {} texts, such as {}", faults.len(), texts.len(), faults[0]);
}

#[test]
fn s03_kernels_are_valid_for_every_pair_of_features() {
    let scenes = scenes();
    println!("{} sets of features", scenes.len());
    assert_valid(scenes.into_iter().map(features));
}

/// What scenes really have is among what is reachable.
#[test]
fn s03_kernels_are_valid_for_every_built_in_scene() {
    let scenes = NAMES.map(|name| SceneFeatures::of(&builtin(name).expect("a built-in scene")));
    for (name, scene) in NAMES.iter().zip(&scenes) {
        assert_eq!(reachable(bits_of(*scene)), bits_of(*scene), "{name}");
    }
    let by_turns = |(scene, device): (&SceneFeatures, _)| Features::from(*scene).with(device);
    assert_valid(scenes.iter().zip(DEVICES.into_iter().cycle()).map(by_turns));
}

/// With all buffers in pages: one scene will do, since readings are put in place line by line.
#[test]
fn s03_kernels_are_valid_in_pages() {
    let mut pages = Pages::default();
    PagedBuffer::ALL.iter().for_each(|&buffer| pages.set(buffer, 2));
    let scene = SceneFeatures { lambert_only: true, ..everything() };
    let scene = Features::from(scene.consistent()).with_pages(pages);
    assert_valid(DEVICES.map(|device| scene.with(device)));
}
