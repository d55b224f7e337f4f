//! Rounds that take too long are left unfinished, and pictures hold whole samples only.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use halfway::integrator::{Bdpt, Connections, LvcBpt, Method, View};
use halfway::render::{Budget, RenderError, RenderOptions, Renderer, Stop, TimeLimit};
use halfway::scene::builtin::closed;

use crate::gpu;
use crate::shots::{options, render};

const SAMPLES: u32 = 2;

/// More pixels than `bdpt` has paths in flight on a software device, and fewer: a sample takes several batches, or one.
const LARGE: [u32; 2] = [330, 200];
const SMALL: [u32; 2] = [40, 30];

/// However late a round is cut, the picture is that of the samples that were finished, bit for bit, and goes on from there
/// as if nothing had happened.
#[test]
fn a_cut_leaves_whole_samples() {
    let scene = closed::plates();
    let lvcbpt = LvcBpt { light_paths: Some(500), connections: Connections::even(1), light_tracing: true };
    let bdpt = Bdpt { light_tracing: true };
    for (method, size) in
        [(Method::Path, SMALL), (Method::Bdpt(bdpt), LARGE), (Method::LvcBpt(lvcbpt), SMALL)]
    {
        let options = RenderOptions {
            view: View { max_depth: Some(2), ..options(size, SAMPLES).view },
            method,
            camera: 1,
            ..options(size, SAMPLES)
        };
        // Counts down with every question; cuts at 0.
        let left = Arc::new(AtomicU32::new(u32::MAX));
        let asked = Arc::clone(&left);
        let is_wanted = move || {
            asked.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_err()
        };
        let context = gpu::context().interrupted_by(is_wanted, Duration::ZERO);
        let mut renderer = Renderer::new(&context, &scene, options.clone()).unwrap();
        let mut pictures = Vec::new();
        for samples in 1..=SAMPLES {
            let mut options = options.clone();
            options.budget.samples = Some(samples);
            pictures.push(render(&scene, options).picture.rgb);
        }
        // How often it asks in all: from machine to machine, and from run to run, a little more or less.
        left.store(u32::MAX, Ordering::Relaxed);
        renderer.run(|_| false).unwrap();
        let questions = u32::MAX - left.load(Ordering::Relaxed);
        let mut after = [0; SAMPLES as usize + 1];
        for eighth in 0..8 {
            let questions = questions * eighth / 8;
            left.store(questions, Ordering::Relaxed);
            renderer.restart(options.view.seed, None).unwrap();
            let stop = renderer.run(|_| false);
            left.store(u32::MAX, Ordering::Relaxed);
            let finished = renderer.samples();
            after[finished as usize] += 1;
            match stop {
                Ok(Stop::Samples) => {}
                Err(error) => assert!(matches!(error, RenderError::InterruptedAtOnce), "{error}"),
                Ok(stop) => {
                    assert_eq!(stop, Stop::Interrupted);
                    assert_eq!(renderer.picture().unwrap().rgb, pictures[finished as usize - 1]);
                }
            }
            // What was cut is forgotten: counts of queues, splats, parts of the film.
            renderer.run(|_| false).unwrap();
            assert_eq!(renderer.picture().unwrap().rgb, pictures[SAMPLES as usize - 1]);
        }
        println!("{} at {size:?}: cut after {after:?} samples", method.name());
        assert!(after[0] > 0, "it was not cut before the first sample");
        assert!(size == SMALL || after[1] > 0, "it was not cut after the first sample");
    }
}

/// A sample that takes many times as long as its dispatches: light paths of hundreds of surfaces, and rounds of connections
/// to all of them at each of hundreds of eye vertices.
#[test]
fn no_sample_is_too_long_to_cut() {
    let context = gpu::context().interrupted_by(|| false, Duration::ZERO);
    let options = RenderOptions {
        method: Method::Bdpt(Bdpt { light_tracing: false }),
        budget: Budget { time: Some(TimeLimit::Rendering(Duration::from_millis(100))), ..Budget::default() },
        ..options([4, 4], 1)
    };
    let mut renderer = Renderer::new(&context, &closed::furnace_box(1.0, 1.0), options).unwrap();
    let error = renderer.run(|_| false).unwrap_err();
    assert!(matches!(error, RenderError::NoSampleInTime), "{error}");
    // Some 10^5 dispatches for a sample; those of a tenth of a second are fewer.
    let rays = renderer.report().unwrap().rays;
    assert!(rays.closest_hit < 8000, "{rays:?}");
}
