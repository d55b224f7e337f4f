//! From training paths to a model.

use halfway::subspace::{
    LightEnd, LightSample, Model, Optimiser, Settings, SubspaceError, TrainingSet, normaliser, prepare,
};

use crate::subspace_data::{Data, data};

fn settings(subspaces: u32) -> Settings {
    Settings { subspaces: Some(subspaces), ..Settings::default() }
}

/// The data with contributions and |f_y| in another unit: masses and light weights scale with f_y, so does f.
fn scaled(data: &Data, contribution: f32, light: f32) -> Data {
    let mut set = TrainingSet::new(64, 48);
    let mut nodes = data.set.nodes().to_vec();
    nodes.iter_mut().for_each(|node| node.mass *= light);
    let mut rest = &nodes[..];
    for (index, path) in data.set.paths().iter().enumerate() {
        let mut path = *path;
        path.contribution *= contribution;
        let (own, others) = rest.split_at(data.path_lengths[index]);
        rest = others;
        set.push_path(index as u32, path, own);
    }
    let weigh = |sample: &LightSample| LightSample { weight: sample.weight * light, ..*sample };
    Data {
        set,
        light_samples: data.light_samples.iter().map(weigh).collect(),
        lights: data.lights.clone(),
        path_lengths: data.path_lengths.clone(),
        ..*data
    }
}

#[test]
fn n22_gamma_has_no_unit() {
    let original = data(3000, 22);
    for optimiser in [Optimiser::Mm, Optimiser::Softmax, Optimiser::Mirror] {
        let settings = Settings { optimiser, ..settings(30) };
        let model = original.train(&settings);
        for (contribution, light) in [(60, 0), (-60, 0), (30, 30), (-30, -30)] {
            let other = scaled(&original, 2f32.powi(contribution), 2f32.powi(light)).train(&settings);
            assert!(other.gamma == model.gamma, "{optimiser:?}: 2^{contribution}, light 2^{light}");
            assert!(other.eye_tree == model.eye_tree && other.light_tree == model.light_tree);
        }
    }
}

fn check_shape(model: &Model, data: &Data) {
    let k = model.subspaces as usize;
    let counts = model.report.counts;
    let floor = model.settings.uniform_share / counts.active_columns as f64;
    let used: Vec<bool> = (0..k).map(|column| model.gamma[column] > 0.0).collect();
    assert_eq!(used.iter().filter(|used| **used).count() as u64, counts.active_columns);
    for row in model.gamma.chunks(k) {
        let sum: f64 = row.iter().map(|&p| f64::from(p)).sum();
        assert!((sum - 1.0).abs() < 1e-6, "a row sums to {sum}");
        for (p, used) in row.iter().zip(&used) {
            assert_eq!(*p > 0.0, *used);
            assert!(!used || f64::from(*p) >= floor * (1.0 - 1e-6), "{p} below {floor}");
        }
    }
    // Whatever occurs can be drawn.
    for end in
        data.set.nodes().iter().map(|node| &node.light).chain(data.light_samples.iter().map(|s| &s.end))
    {
        assert!(used[model.light_label(end) as usize]);
    }
    let reserved = (model.subspaces as u64 - counts.source_subspaces) as u32;
    for sample in &data.light_samples {
        let is_source = matches!(sample.end, LightEnd::Source { .. });
        assert_eq!(model.light_label(&sample.end) >= reserved, is_source || k == 1);
    }
}

#[test]
fn n24_gamma_is_a_matrix_of_distributions() {
    for (paths, subspaces) in [(4000, 1), (4000, 2), (4000, 10), (4000, 40), (4000, 300), (20, 300), (3, 50)]
    {
        let data = data(paths, 24);
        let model = data.train(&settings(subspaces));
        check_shape(&model, &data);
        // Rows that no path connects from are those of power alone.
        let used = |p: f32| p > 0.0;
        let total: f64 =
            model.q.iter().zip(&model.gamma).filter(|(_, p)| used(**p)).map(|(&q, _)| f64::from(q)).sum();
        let counts = model.report.counts;
        let even = 0.1 / counts.active_columns as f64;
        let by_power = |row: &[f32]| {
            row.iter().zip(&model.q).all(|(&p, &q)| {
                let expected = if used(p) { 0.9 * f64::from(q) / total + even } else { 0.0 };
                (f64::from(p) - expected).abs() <= 1e-6 * expected
            })
        };
        let unseen = model.gamma.chunks(subspaces as usize).filter(|row| by_power(row)).count() as u64;
        println!("{paths} paths, K = {subspaces}: {unseen} rows by power, {counts:?}");
        assert!(subspaces == 1 || unseen == u64::from(subspaces) - counts.learnt_rows);
        assert!(paths > 20 || unseen > 40);
    }
}

#[test]
fn n25_q_is_positive_and_finite() {
    let mut data = data(2000, 25);
    // Light that is never seen: all samples on one light.
    data.light_samples.retain(|sample| matches!(sample.end, LightEnd::Source { light: 0, .. }));
    let model = data.train(&settings(100));
    let counts = model.report.counts;
    assert!(counts.floored_columns > 50 && counts.floored_columns < counts.active_columns);
    let used: Vec<f64> = (0..100).filter(|&c| model.gamma[c] > 0.0).map(|c| f64::from(model.q[c])).collect();
    let estimate: f64 =
        data.light_samples.iter().map(|s| f64::from(s.weight)).sum::<f64>() / data.light_paths as f64;
    let floor = normaliser::FLOOR * estimate / used.len() as f64;
    let least = used.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((least / floor - 1.0).abs() < 1e-6, "{least}, not {floor}");
    assert!(model.q.iter().all(|q| *q > 0.0 && q.is_finite() && (1.0 / q).is_finite()));
    check_shape(&model, &data);
}

#[test]
fn tables_draw_what_they_report() {
    let model = data(3000, 14).train(&settings(60));
    let tables = model.tables().unwrap();
    for row in 0..60 {
        let entries = &tables.entries[60 * row..][..60];
        let reported = &tables.pdf[60 * row..][..60];
        let mut below = 0;
        for (column, (entry, &reported)) in entries.iter().zip(reported).enumerate() {
            let drawn = f64::from(entry.bound - below) / 2f64.powi(32);
            below = entry.bound;
            // The last bound would be 2^32.
            assert!((drawn - f64::from(reported)).abs() < 3e-10 + 1e-7 * drawn, "row {row}, column {column}");
            assert!((drawn - f64::from(model.gamma[60 * row + column])).abs() < 1e-7);
        }
    }
}

#[test]
fn threads_do_not_count() {
    let data = data(30_000, 3);
    for optimiser in [Optimiser::Mm, Optimiser::Softmax, Optimiser::Mirror] {
        let settings = Settings { optimiser, max_steps: 4, ..settings(60) };
        let [one, two, five] = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut model = pool.install(|| data.train(&settings));
            model.report.seconds = Default::default();
            model
        });
        assert!(one == two && one == five, "{optimiser:?}");
    }
}

#[test]
fn faulty_paths_are_left_out_and_counted() {
    let clean = data(2000, 9);
    let mut faulty = data(2000, 9);
    let (path, node) = (clean.set.paths()[0], clean.set.nodes()[0]);
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let mut push = |path, node| faulty.set.push_path(faulty.set.paths().len() as u32, path, &[node]);
        push(halfway::subspace::TrainingPath { contribution: bad, ..path }, node);
        push(halfway::subspace::TrainingPath { p0: bad, ..path }, node);
        push(path, halfway::subspace::TrainingNode { mass: bad, ..node });
        if !bad.is_finite() {
            let mut node = node;
            node.eye.position.y = bad;
            push(path, node);
        }
        faulty.light_samples.push(LightSample { weight: bad, ..clean.light_samples[0] });
    }
    let (clean, faulty) = (clean.train(&settings(20)), faulty.train(&settings(20)));
    assert_eq!(faulty.report.counts.faulty_paths, 11);
    assert_eq!(faulty.report.counts.faulty_light_samples, 3);
    assert!(clean.gamma == faulty.gamma && clean.q == faulty.q);
}

/// Held-out paths judge; nothing is learnt from where they lead.
#[test]
fn held_out_paths_teach_nothing() {
    let original = data(3000, 11);
    // The smoothing is for them to choose.
    let settings = Settings { max_steps: 0, smoothing: Some(0.2), ..settings(30) };
    let weighed = prepare::weigh(&original.set, original.lights.len(), &settings, 0).unwrap();
    let held_out = weighed.paths.iter().filter(|path| path.held_out).count();
    assert!((250..350).contains(&held_out), "{held_out} of 3000");
    let mut other = data(3000, 11);
    other.set = TrainingSet::new(64, 48);
    let mut rest = original.set.nodes();
    for (index, path) in original.set.paths().iter().enumerate() {
        let (own, others) = rest.split_at(original.path_lengths[index]);
        rest = others;
        let mut own = own.to_vec();
        if weighed.paths[index].held_out {
            own.iter_mut().for_each(|node| (node.eye, node.mass) = (original.set.nodes()[0].eye, 0.5));
        }
        other.set.push_path(index as u32, *path, &own);
    }
    let (original, other) = (original.train(&settings), other.train(&settings));
    assert!(original.eye_tree == other.eye_tree && original.light_tree == other.light_tree);
    assert!(original.gamma == other.gamma);
    assert_ne!(original.report.losses[0].held_out, other.report.losses[0].held_out);
}

#[test]
fn without_paths_there_is_power() {
    let mut data = data(400, 5);
    data.set = TrainingSet::new(64, 48);
    let model = data.train(&Settings::default());
    assert_eq!(model.subspaces, 2);
    check_shape(&model, &data);

    let try_train = |data: &Data, settings: Settings| data.try_train(&settings).unwrap_err();
    data.light_samples.push(LightSample { end: LightEnd::Source { light: 5, at: [0.0; 2] }, weight: 1.0 });
    let error = try_train(&data, Settings::default());
    assert!(matches!(error, SubspaceError::UnknownLight { light: 5, count: 5 }));
    data.light_samples.clear();
    assert!(matches!(try_train(&data, Settings::default()), SubspaceError::NoLight { samples: 0, .. }));
    for uniform_share in [0.0, -1.0, 1e-7, 1.5, f64::NAN] {
        let error = try_train(&data, Settings { uniform_share, ..Settings::default() });
        assert!(matches!(error, SubspaceError::Setting { name: "uniform_share", .. }));
    }
    for power_share in [-0.1, 1.1, f64::NAN] {
        let error = try_train(&data, Settings { power_share, ..Settings::default() });
        assert!(matches!(error, SubspaceError::Setting { name: "power_share", .. }));
    }
    for smoothing in [-0.1, 1.1, f64::NAN] {
        let error = try_train(&data, Settings { smoothing: Some(smoothing), ..Settings::default() });
        assert!(matches!(error, SubspaceError::Setting { name: "smoothing", .. }));
    }
    let error = try_train(&data, Settings { subspaces: Some(0), ..Settings::default() });
    assert!(matches!(error, SubspaceError::Setting { name: "subspaces", .. }));
}

#[test]
fn subspaces_follow_the_training_set() {
    let settings = Settings::default();
    assert_eq!(
        [0, 1000, 100_000, 2_200_000, 1 << 30].map(|nodes| settings.subspaces_for(nodes)),
        [2, 14, 141, 300, 300]
    );
}

/// The loss on paths that taught nothing.
fn fresh_loss(fresh: &Data, model: &Model, gamma: &dyn Fn(usize, usize) -> f64) -> f64 {
    let mut sum = 0.0;
    for (index, path) in fresh.set.paths().iter().enumerate() {
        let mut density = f64::from(path.p0);
        for node in &fresh.set.nodes()[fresh.set.nodes_of(index)] {
            let (row, column) = (model.eye_label(&node.eye), model.light_label(&node.light));
            let q = f64::from(model.q[column as usize]);
            density += 3.0 * f64::from(node.mass) / q * gamma(row as usize, column as usize);
        }
        sum += f64::from(path.contribution).powi(2) / density;
    }
    sum
}

/// The same with the Gamma that the model has.
fn own_loss(fresh: &Data, model: &Model) -> f64 {
    let k = model.subspaces as usize;
    fresh_loss(fresh, model, &|row, column| f64::from(model.gamma[k * row + column]))
}

/// Where paths are few, what neighbours have learnt is worth more than they are; where there are many, what
/// chance makes of the choice does little harm.
#[test]
fn smoothing_helps_where_paths_are_few() {
    let fresh = data(30_000, 79);
    for (paths, subspaces, most) in [(300, 30, 0.65), (1000, 60, 0.55), (3000, 60, 0.75), (60_000, 20, 1.02)]
    {
        let [mut sharp, mut smooth] = [0.0; 2];
        // Of several, since few paths teach a lot or little by chance.
        for seed in [31, 32, 33] {
            let data = data(paths, seed);
            // By itself: shares by power help as well.
            let train =
                |smoothing| data.train(&Settings { smoothing, power_share: 0.0, ..settings(subspaces) });
            let (with, without) = (train(None), train(Some(0.0)));
            check_shape(&with, &data);
            assert!(without.report.losses.iter().all(|loss| loss.smoothing == 0.0));
            assert_eq!((with.report.tried.len(), without.report.tried.len()), (4, 1));
            let (with_loss, without_loss) = (own_loss(&fresh, &with), own_loss(&fresh, &without));
            let kept = |model: &Model| model.report.losses[model.report.best_step as usize];
            println!(
                "{paths} paths, K = {subspaces}: {with_loss} smoothed, {without_loss} not, {:?} and {:?}",
                kept(&with),
                kept(&without)
            );
            smooth += with_loss;
            sharp += without_loss;
        }
        println!("{paths} paths, K = {subspaces}: {} of the loss", smooth / sharp);
        assert!(smooth < most * sharp, "{paths} paths, K = {subspaces}: {smooth} and {sharp}");
    }
}

/// Where paths are few, much of the light has not been met. Where there are many, the share that goes by power costs little.
#[test]
fn power_helps_where_paths_are_few() {
    let fresh = data(30_000, 79);
    for (paths, subspaces, most) in [(300, 30, 0.9), (1000, 60, 0.9), (60_000, 20, 1.05)] {
        let [mut by_power, mut alone] = [0.0; 2];
        for seed in [31, 32, 33] {
            let data = data(paths, seed);
            let settings = Settings { smoothing: Some(0.0), ..settings(subspaces) };
            let loss =
                |power_share| own_loss(&fresh, &data.train(&Settings { power_share, ..settings.clone() }));
            by_power += loss(settings.power_share);
            alone += loss(0.0);
        }
        println!("{paths} paths, K = {subspaces}: {} of the loss", by_power / alone);
        assert!(by_power < most * alone, "{paths} paths, K = {subspaces}: {by_power} and {alone}");
    }
}

/// What light does here: it comes from the opposite side. Gamma finds that out, and fits paths it has not seen.
#[test]
fn gamma_learns_where_light_comes_from() {
    let model = data(60_000, 77).train(&settings(40));
    let losses = &model.report.losses;
    println!("{losses:?}\nkept {}, {:?} bits", model.report.best_step, model.report.row_entropy);
    let uniform = 40f64.log2();
    assert!(model.report.row_entropy[1] < uniform - 0.5);
    let fresh = data(20_000, 78);
    let bound = |gamma: &dyn Fn(usize, usize) -> f64| fresh_loss(&fresh, &model, gamma);
    let total: f64 = model.q.iter().map(|&q| f64::from(q)).sum();
    let learnt = bound(&|row, column| f64::from(model.gamma[40 * row + column]));
    let power = bound(&|_, column| f64::from(model.q[column]) / total);
    println!("loss on fresh paths: learnt {learnt}, by power {power}");
    assert!(learnt < 0.9 * power, "{learnt} and {power}");
}
