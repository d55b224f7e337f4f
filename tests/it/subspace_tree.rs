//! The classification trees: host and shader walk alike, and mostly to the nearest centroid.

use glam::Vec3;
use halfway::device::layout::{TREE_DIRECTION, TREE_KIND, TREE_NORMAL, TREE_POSITION, TreeNode};
use halfway::subspace::centroid::{Centroids, systematic};
use halfway::subspace::tree::{Growth, MAX_DEPTH};
use halfway::subspace::{Feature, Settings, Tree};

use crate::gpu;
use crate::random::Stream;
use crate::subspace_data::{data, feature, unit};

/// A tree over random features, and the centroids it stands for.
fn tree(samples: usize, centroids: usize, direction_weight: f32) -> (Tree, Centroids) {
    let mut stream = Stream::new(100);
    let features: Vec<Feature> = (0..samples).map(|_| feature(&mut stream)).collect();
    let centroids = Centroids::new(features[..centroids].to_vec(), 0.15, direction_weight);
    let labels: Vec<u32> = features.iter().map(|feature| centroids.nearest(feature)).collect();
    let samples: Vec<(Feature, f64)> =
        features.into_iter().map(|feature| (feature, 0.1 + stream.f64())).collect();
    let growth = Growth { depth: 15, stop: 0.99, direction: direction_weight > 0.0 };
    (Tree::grow(&samples, &labels, growth), centroids)
}

/// The nearest centroid by its definition, in f64.
fn brute_force(centroids: &[Feature], x: &Feature, direction_weight: f64) -> (u32, f64) {
    let distance = |c: &Feature| {
        let apart = (x.position - c.position).as_dvec3().length_squared();
        let normal = 1.0 - x.normal.as_dvec3().dot(c.normal.as_dvec3());
        let direction = 1.0 - x.direction.as_dvec3().dot(c.direction.as_dvec3());
        apart + 0.15 * normal + direction_weight * 0.15 * direction
    };
    let all = centroids.iter().enumerate().map(|(i, c)| (i as u32, distance(c)));
    all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

/// Those of a centroid, by sorting all by the definition of the distance.
#[test]
fn neighbours_are_the_nearest() {
    let mut stream = Stream::new(102);
    let mut features: Vec<Feature> = (0..200).map(|_| feature(&mut stream)).collect();
    // Two in one place: each comes first in its own list.
    features[17] = features[4];
    for direction_weight in [0.0, 0.5] {
        let centroids = Centroids::new(features.clone(), 0.15, direction_weight);
        let all = centroids.neighbours(6);
        assert_eq!(all.len(), 200);
        for (index, near) in all.iter().enumerate() {
            assert_eq!((near[0], near.len()), (index as u32, 6));
            let mut others = features.clone();
            // Takes the nearest away, one by one.
            for &next in &near[1..] {
                others[near[0] as usize].position = Vec3::splat(1e3);
                let (_, least) = brute_force(&others, &features[index], f64::from(direction_weight));
                let (_, found) =
                    brute_force(&[others[next as usize]], &features[index], f64::from(direction_weight));
                assert!(found <= least + 1e-6, "{index}: {next} at {found}, not {least}");
                others[next as usize].position = Vec3::splat(1e3);
            }
        }
        assert_eq!(centroids.neighbours(1000)[3].len(), 200);
    }
    assert!(Centroids::new(Vec::new(), 0.15, 0.0).neighbours(6).is_empty());
}

/// Features anywhere, and with coordinates that lie exactly on split planes.
fn probes(count: usize, trees: [&Tree; 2]) -> Vec<Feature> {
    let mut stream = Stream::new(101);
    let nodes: Vec<TreeNode> = trees.iter().flat_map(|tree| tree.nodes()).copied().collect();
    (0..count)
        .map(|i| {
            let mut probe = feature(&mut stream);
            if i % 2 == 0 {
                probe.normal = unit(&mut stream);
            }
            if i % 3 == 0 {
                let node = nodes[stream.word() as usize % nodes.len()];
                let axis = stream.word() as usize % 3;
                match node.child_kind & TREE_KIND {
                    TREE_POSITION => probe.position[axis] = node.split[axis],
                    TREE_NORMAL => probe.normal[axis] = node.split[axis],
                    _ => probe.direction[axis] = node.split[axis],
                }
            }
            probe
        })
        .collect()
}

const KERNEL: &str = "
#import bind/subspaces
@group(0) @binding(0) var<storage, read> features: array<array<f32, 9>>;
@group(0) @binding(1) var<storage, read_write> labels: array<vec4u>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * 65535u * 64u;
    if index >= arrayLength(&features) { return; }
    let f = features[index];
    let position = vec3f(f[0], f[1], f[2]);
    let normal = vec3f(f[3], f[4], f[5]);
    let direction = vec3f(f[6], f[7], f[8]);
    let eye = tree_label(TREE_EYE, position, normal, direction);
    let light = tree_label(TREE_LIGHT, position, normal, direction);
    labels[index] = vec4u(eye, light, source_label(index % 5u, position.xy), 0u);
}";

#[test]
fn c10_shader_and_host_label_alike() {
    let (eye, _) = tree(20_000, 300, 0.0);
    let (light, _) = tree(20_000, 100, 1.0);
    let kinds = |tree: &Tree| {
        [TREE_NORMAL, TREE_DIRECTION]
            .map(|kind| tree.nodes().iter().any(|node| node.child_kind & TREE_KIND == kind))
    };
    assert_eq!((kinds(&eye), kinds(&light)), ([true, false], [true, true]));
    let sources = data(10, 1).train(&Settings { subspaces: Some(300), ..Settings::default() }).sources;
    let probes = probes(1_000_000, [&eye, &light]);
    let numbers: Vec<[f32; 9]> = probes
        .iter()
        .map(|p| {
            let [a, b, c] = [p.position, p.normal, p.direction].map(|v: Vec3| v.to_array());
            [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
        })
        .collect();
    let inputs = [
        ("features", bytemuck::cast_slice(&numbers)),
        ("eye_tree", bytemuck::cast_slice(eye.nodes())),
        ("light_tree", bytemuck::cast_slice(light.nodes())),
        ("source_labels", bytemuck::cast_slice(&sources)),
    ];
    let output = gpu::run(KERNEL, &[], &inputs, &[("labels", probes.len() * 16)], probes.len() as u32);
    let labels: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&output[0]);
    for (index, (probe, found)) in probes.iter().zip(labels).enumerate() {
        let source = sources[index % 5].label([probe.position.x, probe.position.y]);
        let expected = [eye.label(probe), light.label(probe), source];
        assert_eq!(found[..3], expected, "{probe:?}");
    }
}

#[test]
fn c10_trees_stand_for_the_nearest_centroid() {
    for (direction_weight, count) in [(0.0, 100), (1.0, 100)] {
        let (tree, centroids) = tree(20_000, count, direction_weight);
        let mut stream = Stream::new(102);
        let (mut agree, probes) = (0, 5000);
        for _ in 0..probes {
            let probe = feature(&mut stream);
            let (nearest, distance) = brute_force(centroids.features(), &probe, f64::from(direction_weight));
            let searched = centroids.nearest(&probe);
            // Rounding may exchange equally near ones.
            if searched != nearest {
                let only = [centroids.features()[searched as usize]];
                let other = brute_force(&only, &probe, f64::from(direction_weight)).1;
                assert!(other - distance < 1e-6, "{searched} instead of {nearest}");
            }
            agree += usize::from(tree.label(&probe) == nearest);
        }
        let share = agree as f64 / f64::from(probes);
        println!("k_d = {direction_weight}: {} nodes, {share} as the nearest centroid", tree.nodes().len());
        assert!(share > 0.5);
    }
}

#[test]
fn trees_have_a_shape() {
    let (tree, _) = tree(20_000, 100, 0.0);
    assert!(Tree::from_nodes(tree.nodes().to_vec(), 15, 100).is_some());
    assert!(Tree::from_nodes(tree.nodes().to_vec(), 15, 99).is_none(), "a label too many");
    assert!(Tree::from_nodes(tree.nodes().to_vec(), 2, 100).is_none(), "too deep");
    let inner = |child: u32| TreeNode { split: [0.0; 3], child_kind: TREE_POSITION | child };
    assert!(Tree::from_nodes(vec![], MAX_DEPTH, 1).is_none());
    assert!(Tree::from_nodes(vec![inner(0); 8], MAX_DEPTH, 1).is_none(), "a cycle");
    assert!(Tree::from_nodes(vec![inner(1); 8], MAX_DEPTH, 1).is_none(), "a child too few");
    assert_eq!(Tree::single(4).label(&Feature::default()), 4);
    let at_one_place = vec![(Feature::default(), 1.0); 10];
    let labels: Vec<u32> = (0..10).collect();
    let growth = Growth { depth: 15, stop: 0.99, direction: true };
    assert!(Tree::grow(&at_one_place, &labels, growth).label(&Feature::default()) == 0, "ends, at the first");
}

#[test]
fn centroids_are_drawn_by_contribution() {
    let weights: Vec<f64> = (0..10_000).map(|i| if i < 5000 { 1.0 } else { 3.0 }).collect();
    let drawn = systematic(weights.iter().copied(), 400, 5);
    assert_eq!(drawn.len(), 400);
    assert!(drawn.windows(2).all(|pair| pair[0] < pair[1]), "each at most once");
    assert_eq!(drawn.iter().filter(|&&i| i < 5000).count(), 100);
    let scaled = weights.iter().map(|weight| weight * 2f64.powi(-60));
    assert_eq!(systematic(scaled, 400, 5), drawn);
    assert_ne!(systematic(weights.iter().copied(), 400, 6), drawn, "the seed counts");
    assert_eq!(
        systematic([0.0, 1e9, 1.0, 0.0].into_iter(), 3, 5),
        [1],
        "one weight above the step counts once"
    );
    assert!(systematic([0.0, 0.0].into_iter(), 3, 5).is_empty());
}
