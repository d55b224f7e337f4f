//! How long training takes. Run by hand, in release: `cargo test --release --test it subspace_speed -- --ignored`.

use halfway::subspace::{Optimiser, Settings};

use crate::subspace_data::data;

#[test]
#[ignore = "measures seconds, which no test may depend on: run it by hand, on an idle machine"]
fn subspace_speed() {
    let data = data(1_000_000, 1);
    for (subspaces, optimiser, max_steps) in [
        (Some(1000), Optimiser::Mm, 3),
        (Some(1000), Optimiser::Mm, 20),
        (Some(1000), Optimiser::Softmax, 20),
        (Some(1000), Optimiser::Mirror, 20),
        (None, Optimiser::Mm, 20),
    ] {
        let model = data.train(&Settings { subspaces, optimiser, max_steps, ..Settings::default() });
        let start = std::time::Instant::now();
        model.tables().unwrap();
        println!(
            "K = {}, {optimiser:?}: {:?}, tables {:?}, {} steps, {:?}, last {:?}",
            model.subspaces,
            model.report.seconds,
            start.elapsed(),
            model.report.losses.len() - 1,
            model.report.counts,
            model.report.losses.last()
        );
    }
}
