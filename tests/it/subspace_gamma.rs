//! The loss over Gamma, its gradient, and the ways down.

use halfway::subspace::Optimiser;
use halfway::subspace::gamma::{Neighbours, Problem, ProblemBuilder, Term, optimise};

use crate::random::Stream;

/// Total variation between two distributions.
fn variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

const ALL: [Optimiser; 3] = [Optimiser::Mm, Optimiser::Softmax, Optimiser::Mirror];

/// Random paths over K x K; `row_scale` scales W of the paths of each row, `held_out` of them judge.
fn problem(k: u32, paths: usize, scale: f64, row_scale: impl Fn(u32) -> f64, held_out: f32) -> Problem {
    let mut stream = Stream::new(23);
    let mut builder = ProblemBuilder::new(k);
    for _ in 0..paths {
        // All connections of a path in one row, so that rows do not know of each other.
        let row = stream.word() % k;
        let count = 1 + stream.word() % 3;
        let connections: Vec<(u32, u32, f64)> = (0..count)
            .map(|_| (row, (row + stream.word() % k * (stream.word() % 2)) % k, stream.f64()))
            .collect();
        let start = 0.1 + stream.f64();
        let squared = start * start * scale * row_scale(row);
        let p0 = 0.3 * stream.f64();
        let held_out = stream.f32() < held_out;
        let start = start * row_scale(row);
        builder.push(Term { squared, start, p0, held_out }, connections.into_iter());
    }
    let even = vec![1.0 / f64::from(k); k as usize];
    builder.finish(0.1, 0.0, &vec![true; k as usize], &even)
}

#[test]
fn n23_gradient_is_the_difference_quotient() {
    let problem = problem(20, 1000, 1.0, |_| 1.0, 0.0);
    let q = problem.start();
    let (loss, gradient) = problem.gradient(q);
    assert!((problem.loss(q) - loss).abs() <= 1e-12 * loss);
    assert!(gradient.len() > 200);
    // Five points: L is some ten thousand times larger than most derivatives, so h cannot be small.
    let h = 5e-5;
    for (entry, g) in gradient.into_iter().enumerate() {
        let moved = |by: f64| {
            let mut q = q.to_vec();
            q[entry] += by;
            problem.loss(&q)
        };
        let quotient = (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h);
        assert!((quotient - g).abs() <= 1e-6 * g.abs(), "entry {entry}: {g} and {quotient}");
    }
}

#[test]
fn n23_the_loss_never_rises() {
    let problem = problem(20, 1000, 1.0, |_| 1.0, 0.0);
    for optimiser in [Optimiser::Mm, Optimiser::Mirror] {
        let found = optimise(&problem, optimiser, 100);
        let losses: Vec<f64> = found.losses.iter().map(|loss| loss.train).collect();
        for pair in losses.windows(2) {
            assert!(pair[1] <= pair[0] * (1.0 + 1e-14), "{optimiser:?}: {} to {}", pair[0], pair[1]);
        }
        assert!(losses.last() < losses.first(), "{optimiser:?} does nothing");
    }
    // Adam may rise between, but not over a hundred steps, and all three find one minimum.
    let ends = ALL.map(|optimiser| {
        let found = optimise(&problem, optimiser, 300);
        found.losses[found.best_step as usize].train
    });
    println!("minima by MM, softmax, mirror: {ends:?}");
    assert!(ends.iter().all(|end| (end / ends[0] - 1.0).abs() < 0.01), "{ends:?}");
}

/// L = A / (c + q) + B / (c + 1 - q) has its minimum where sqrt(A) (c + 1 - q) = sqrt(B) (c + q).
#[test]
fn n23_two_cells_in_closed_form() {
    for (a, b, c) in [(4.0f64, 1.0f64, 0.0), (1.0, 1.0, 0.2), (9.0, 4.0, 0.5), (100.0, 1.0, 0.05)] {
        let mut builder = ProblemBuilder::new(2);
        for (squared, column) in [(a, 0), (b, 1)] {
            let term = Term { squared, start: 1.0, p0: c, held_out: false };
            builder.push(term, [(0, column, 1.0)].into_iter());
        }
        let problem = builder.finish(0.0, 0.0, &[true, true], &[0.5, 0.5]);
        let expected = (a.sqrt() * (c + 1.0) - b.sqrt() * c) / (a.sqrt() + b.sqrt());
        for optimiser in ALL {
            let q = optimise(&problem, optimiser, 300).q[0];
            assert!((q / expected - 1.0).abs() < 0.01, "{optimiser:?} {a} {b} {c}: {q}, not {expected}");
        }
    }
}

#[test]
fn n22_no_unit_of_the_loss() {
    let original = problem(20, 2000, 1.0, |_| 1.0, 0.1);
    let faint = |row: u32| if row == 3 { 1e-12 } else { 1.0 };
    let with_faint_row = problem(20, 2000, 1.0, faint, 0.0);
    let without = problem(20, 2000, 1.0, |_| 1.0, 0.0);
    for optimiser in ALL {
        let q = optimise(&original, optimiser, 20).q;
        for exponent in [60, -60, 200] {
            let scaled = problem(20, 2000, 2f64.powi(exponent), |_| 1.0, 0.1);
            assert!(optimise(&scaled, optimiser, 20).q == q, "{optimiser:?} at 2^{exponent}");
        }
        let (bright, faint) =
            (optimise(&without, optimiser, 20).q, optimise(&with_faint_row, optimiser, 20).q);
        let row = without.row(3);
        let (bright, faint) = (&bright[row.clone()], &faint[row.clone()]);
        let moved = variation(bright, &without.start()[row]);
        println!(
            "{optimiser:?}: a row moves by {moved}, a faint one differs by {}",
            variation(bright, faint)
        );
        assert!(moved > 0.02 && variation(bright, faint) < 0.01, "{optimiser:?}");
    }
}

/// Few paths and many entries: what helps the paths seen harms the others. MM, which goes down fastest, shows it first.
#[test]
fn held_out_paths_stop_the_optimisation() {
    let over_fitting = problem(60, 1500, 1.0, |_| 1.0, 0.2);
    let found = optimise(&over_fitting, Optimiser::Mm, 50);
    println!("{:?}", found.losses);
    assert!(found.losses.len() < 10, "{} steps", found.losses.len() - 1);
    assert!(found.best_step <= 3, "step {} was kept", found.best_step);
    let held_out = |step: usize| found.losses[step].held_out.unwrap();
    let best = held_out(found.best_step as usize);
    assert!((0..found.losses.len()).all(|step| best <= held_out(step)));
    assert_eq!(over_fitting.held_out_loss(&found.q), Some(best), "another step was kept");
    assert!(found.losses.last().unwrap().train < found.losses[found.best_step as usize].train);
}

/// Of each of `k`, itself and those beside it.
fn beside(k: u32) -> Vec<Vec<u32>> {
    (0..k)
        .map(|i| [i].into_iter().chain(i.checked_sub(1)).chain((i + 1 < k).then_some(i + 1)).collect())
        .collect()
}

/// By its definition: a share goes evenly to what is active, a share of the rest by power, and what is left is learnt; the
/// loss and its derivative are those of that.
#[test]
fn shares_that_do_not_depend_on_learning() {
    let (active, power) = ([true, false, true, true], [0.7, 0.0, 0.3, 0.0]);
    let mut builder = ProblemBuilder::new(4);
    for (row, column, squared) in [(0, 0, 3.0), (0, 2, 1.0), (2, 3, 2.0)] {
        let term = Term { squared, start: 1.0, p0: 0.0, held_out: false };
        builder.push(term, [(row, column, 1.0)].into_iter());
    }
    let problem = builder.finish(0.15, 0.4, &active, &power);
    let q = problem.start().to_vec();
    let share = |row: usize, column: usize| {
        let even = if active[column] { 0.15 / 3.0 } else { 0.0 };
        even + 0.85 * (0.4 * power[column] + 0.6 * q[4 * row + column])
    };
    for (entry, found) in problem.expand(&q).iter().enumerate() {
        let expected = share(entry / 4, entry % 4);
        assert!((f64::from(*found) - expected).abs() < 1e-7, "{entry}: {found}, not {expected}");
    }
    let (loss, gradient) = problem.gradient(&q);
    let expected = 3.0 / share(0, 0) + 1.0 / share(0, 2) + 2.0 / share(2, 3);
    assert!((loss / expected - 1.0).abs() < 1e-12, "{loss}, not {expected}");
    let expected = -0.85 * 0.6 * 3.0 / share(0, 0).powi(2);
    assert!((gradient[0] / expected - 1.0).abs() < 1e-12, "{}, not {expected}", gradient[0]);
}

/// By its definition: each column's probability goes to its neighbours by their power, then rows take their
/// neighbours' mean. Row 2 and column 3 have no paths.
#[test]
fn smoothing_is_the_mean_of_neighbours() {
    let k = 5;
    let power = [0.1, 0.4, 0.2, 0.0, 0.3];
    let active = power.map(|power| power > 0.0);
    let mut columns = beside(k);
    columns.iter_mut().for_each(|near| near.retain(|&near| active[near as usize]));
    let neighbours = Neighbours { rows: beside(k), columns: columns.clone() };
    let mut stream = Stream::new(51);
    let mut builder = ProblemBuilder::new(k);
    for _ in 0..40 {
        let (row, column) =
            ([0, 1, 3, 4][stream.word() as usize % 4], [0, 1, 2, 4][stream.word() as usize % 4]);
        let term = Term { squared: 1.0, start: 0.1 + stream.f64(), p0: 0.2, held_out: false };
        builder.push(term, [(row, column, 1.0)].into_iter());
    }
    let mut problem = builder.finish(0.1, 0.2, &active, &power);
    assert_eq!(problem.learnt(), [true, true, false, true, true]);
    let start = problem.start().to_vec();
    let at = |row: usize, column: usize| start[k as usize * row + column];
    let to = |from: usize, column: usize| match columns[from].contains(&(column as u32)) {
        true => power[column] / columns[from].iter().map(|&near| power[near as usize]).sum::<f64>(),
        false => 0.0,
    };
    let spread = |row: usize, column: usize| (0..5).map(|from| at(row, from) * to(from, column)).sum::<f64>();
    for share in [1.0, 0.3, 0.0] {
        problem.smooth_over(&neighbours, &power, Some(share));
        let found = optimise(&problem, Optimiser::Mm, 0);
        assert_eq!(found.losses[0].smoothing, share);
        for row in 0..5 {
            let rows = match row {
                2 => vec![],
                _ => vec![row.max(1) - 1, row, (row + 1).min(4)],
            };
            let rows: std::collections::BTreeSet<usize> = rows.into_iter().filter(|&row| row != 2).collect();
            for column in 0..5 {
                let mean = rows.iter().map(|&row| spread(row, column)).sum::<f64>() / rows.len() as f64;
                let mean = if row == 2 { at(row, column) } else { mean };
                let expected = (1.0 - share) * at(row, column) + share * mean;
                let q = found.q[5 * row + column];
                assert!((q - expected).abs() < 1e-14, "share {share}, {row}, {column}: {q}, not {expected}");
            }
        }
        let gamma = problem.expand(&found.q);
        for row in gamma.chunks(5) {
            assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            assert_eq!(row[3], 0.0);
        }
    }
}

/// Without paths that judge there is no choice, and neighbours do not count.
#[test]
fn held_out_paths_choose_the_smoothing() {
    let even = vec![1.0 / 60.0; 60];
    let neighbours = Neighbours { rows: beside(60), columns: beside(60) };
    for held_out in [0.0, 0.2] {
        let sharp = problem(60, 1500, 1.0, |_| 1.0, held_out);
        let mut smooth = sharp.clone();
        smooth.smooth_over(&neighbours, &even, None);
        let (sharp, found) = (optimise(&sharp, Optimiser::Mm, 20), optimise(&smooth, Optimiser::Mm, 20));
        println!("{:?}, kept {}, of {:?}", found.losses, found.best_step, found.tried);
        if held_out == 0.0 {
            assert!(found == sharp);
            continue;
        }
        let kept = found.losses[found.best_step as usize];
        let best = found.tried.iter().min_by(|a, b| a.held_out.total_cmp(&b.held_out)).unwrap();
        assert!(found.tried.len() > 2 && found.tried[0].smoothing == 0.0);
        assert!(kept.smoothing > 0.0 && kept.smoothing == best.smoothing);
        assert_eq!(kept.held_out, Some(best.held_out));
        assert!(kept.held_out < sharp.losses[sharp.best_step as usize].held_out);
        for row in 0..60 {
            let sum: f64 = found.q[smooth.row(row)].iter().sum();
            assert!((sum - 1.0).abs() < 1e-12, "row {row}: {sum}");
        }
    }
}
