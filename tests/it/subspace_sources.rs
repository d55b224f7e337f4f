//! Labels of points on lights.

use glam::Vec3;
use halfway::device::scene::{LightSourceInfo, SourceKind};
use halfway::subspace::SourceLabels;
use halfway::subspace::sources::label_sources;

use crate::subspace_data::lights;

fn triangle(position: Vec3, normal: Vec3, area: f32, power: f64) -> LightSourceInfo {
    LightSourceInfo { kind: SourceKind::Triangle { position, normal, area }, power }
}

/// Every id from the first to the end belongs to some light, groups do not overlap, and the budget holds.
fn covers(lights: &[LightSourceInfo], budget: u32, end: u32) -> Vec<SourceLabels> {
    let (labels, used) = label_sources(lights, budget, end);
    assert_eq!(labels.len(), lights.len());
    assert!((1..=budget.max(1)).contains(&used), "{used} of {budget}");
    let mut owner = vec![None; end as usize];
    for of in &labels {
        assert!(of.divisions > 0);
        for id in of.first..of.first + of.divisions * of.divisions {
            let owner = owner[id as usize].get_or_insert(*of);
            assert_eq!(owner, of, "{id} is in two groups");
        }
    }
    let first = (end - used) as usize;
    assert!(owner[..first].iter().all(Option::is_none), "below the reserved ids");
    assert!(owner[first..].iter().all(Option::is_some), "a hole");
    labels
}

#[test]
fn source_labels_cover_the_reserved_ids() {
    for budget in [1, 2, 3, 4, 5, 10, 30, 100, 200] {
        covers(&lights(), budget, 1000);
        covers(&lights(), budget, budget);
        covers(&lights()[..1], budget, 500);
        covers(&lights()[3..], budget, 500);
    }
    assert_eq!(label_sources(&[], 10, 100), (Vec::new(), 0));
}

#[test]
fn large_and_strong_lights_get_more_cells() {
    let labels = covers(&lights(), 100, 1000);
    println!("{labels:?}");
    assert!(labels[0].divisions > 2 && labels[3].divisions > labels[2].divisions);
    assert!(labels[2].divisions == 1 && labels[4].divisions == 1, "small ones and points are not cut");
    assert!(labels[0].divisions.abs_diff(labels[1].divisions) <= 1, "equal lights are cut alike");
}

/// Two lamps of many triangles each, far apart: few labels part the lamps first, then their sides.
#[test]
fn many_lights_are_grouped_by_place_and_side() {
    let lamps: Vec<LightSourceInfo> = (0..4000)
        .map(|i| {
            let x = if i % 2 == 0 { -1.0 } else { 1.0 } + 1e-3 * (i % 50) as f32;
            let normal = if i % 4 < 2 { Vec3::Y } else { Vec3::NEG_Y };
            triangle(Vec3::new(x, 0.0, 0.0), normal, 1e-6, 1.0)
        })
        .collect();
    for (budget, groups) in [(2, 2), (4, 4)] {
        let labels = covers(&lamps, budget, 100);
        for (i, of) in labels.iter().enumerate() {
            assert_eq!(*of, labels[i % groups], "triangle {i} of {groups} groups");
        }
    }
    covers(&lamps, 100, 1000);
}

#[test]
fn lights_without_power_have_labels() {
    let lights = vec![triangle(Vec3::ZERO, Vec3::Y, 0.0, 0.0); 50];
    covers(&lights, 10, 100);
    covers(&[LightSourceInfo { kind: lights[0].kind, power: f64::NAN }], 10, 100);
}

#[test]
fn points_at_the_ends_have_labels() {
    let of = SourceLabels { first: 10, divisions: 3 };
    assert_eq!([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|at| of.label(at)), [10, 16, 12, 18]);
    assert_eq!(of.label([f32::NAN, -1.0]), 10);
}
