//! Compiling before the first dispatch. Software drivers compile where they dispatch first, one kernel after the other on one
//! core, for up to half a minute each. Here they do so when kernels are first bound: all that wait, the dearest first, some of
//! them on further devices of the same driver, whose work the driver finds in its cache on disk.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::context::Context;
use super::pipelines::{Compiling, Pipeline, Waiting};
use crate::device::DeviceError;

/// Bytes of each buffer that a kernel is bound to while it is compiled.
const BUFFER: u64 = 1 << 16;
/// Others help where the first kernel takes longer: where it is in the driver's cache it takes milliseconds.
const PATIENCE: Duration = Duration::from_millis(200);
/// More devices than this have too little to do each.
const MOST_HELPERS: usize = 7;

/// Which kernels have been begun, and whether the first is done.
struct Work<'a> {
    waiting: &'a [Waiting],
    next: AtomicUsize,
    done: Mutex<usize>,
    first: Mutex<bool>,
    first_is_done: Condvar,
}

impl Context {
    /// Makes a software driver compile all that was created and not bound so far.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn finish_compiling(&self) -> Result<(), DeviceError> {
        let mut waiting = self.pipelines.take_waiting();
        // The text tells what is dear. Bytes, then names, so that the order is always the same.
        waiting.sort_by(|a, b| (b.key.0.len(), &a.name).cmp(&(a.key.0.len(), &b.name)));
        let work = Work {
            waiting: &waiting,
            next: AtomicUsize::new(0),
            done: Mutex::new(0),
            first: Mutex::new(false),
            first_is_done: Condvar::new(),
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let helpers = match keeps_compiled(&self.info.driver) {
            true => (cores - 1).min(MOST_HELPERS).min(waiting.len().saturating_sub(1)),
            false => 0,
        };
        let mut own = Ok(BTreeSet::new());
        std::thread::scope(|scope| {
            for _ in 0..helpers {
                // What does not compile there is compiled here, and says why.
                scope.spawn(|| work.wait_for_first() || work.help(self).is_err());
            }
            own = work.compile_all(self);
            work.end_waiting();
        });
        let own = own?;
        // What others compiled lies in the driver's cache.
        let others = waiting.iter().enumerate().filter(|(index, _)| !own.contains(index));
        others.into_iter().try_for_each(|(_, one)| dispatch_nothing(self, &one.name, &one.pipeline))
    }

    fn tell(&self, work: &Work, kernel: &str, seconds: f64) {
        let mut done = work.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += 1;
        log::debug!("compiled {kernel}: {seconds:.2} s");
        if let Some(told) = &self.told_of_compiling {
            told(Compiling { kernel, done: *done, of: work.waiting.len(), seconds });
        }
    }
}

impl Work<'_> {
    fn take(&self) -> Option<usize> {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        (index < self.waiting.len()).then_some(index)
    }

    /// Compiles on the device that will run them; which ones.
    fn compile_all(&self, context: &Context) -> Result<BTreeSet<usize>, DeviceError> {
        let mut own = BTreeSet::new();
        while let Some(index) = self.take() {
            let start = Instant::now();
            let one = &self.waiting[index];
            let compiled = dispatch_nothing(context, &one.name, &one.pipeline);
            self.end_waiting();
            compiled?;
            context.tell(self, &one.name, start.elapsed().as_secs_f64());
            own.insert(index);
        }
        Ok(own)
    }

    /// The same on another device.
    fn help(&self, context: &Context) -> Result<(), DeviceError> {
        let helper = context.sibling()?;
        while let Some(index) = self.take() {
            let start = Instant::now();
            let one = &self.waiting[index];
            let compute = helper.create_pipeline(&one.name, &one.key.0, &one.constants)?;
            dispatch_nothing(&helper, &one.name, &Pipeline { compute, ..one.pipeline.clone() })?;
            context.tell(self, &one.name, start.elapsed().as_secs_f64());
        }
        Ok(())
    }

    /// True where nothing is left to do.
    fn wait_for_first(&self) -> bool {
        let first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.first_is_done.wait_timeout_while(first, PATIENCE, |first| !*first);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }

    fn end_waiting(&self) {
        *self.first.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.first_is_done.notify_all();
    }
}

/// Dispatches no workgroup of a kernel, with buffers that are nothing: the driver compiles it.
fn dispatch_nothing(context: &Context, name: &str, pipeline: &Pipeline) -> Result<(), DeviceError> {
    let mut encoder = context.device.create_command_encoder(&Default::default());
    let buffer = || {
        context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: BUFFER,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: false,
        })
    };
    let bound = pipeline.bind(&context.device, name, |_| Ok(buffer()))?;
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline.compute);
        for (index, group) in &bound {
            pass.set_bind_group(*index, group, &[]);
        }
        pass.dispatch_workgroups(0, 1, 1);
    }
    context.queue.submit([encoder.finish()]);
    context.wait()
}

/// Mesa's software driver keeps what it compiles where other devices find it.
fn keeps_compiled(driver: &str) -> bool {
    if driver != "llvmpipe" {
        return false;
    }
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let is_off = |name| variable(name).is_some_and(|value| matches!(&value[..], "1" | "true" | "yes" | "y"));
    if is_off("MESA_SHADER_CACHE_DISABLE") || is_off("MESA_GLSL_CACHE_DISABLE") {
        return false;
    }
    let home = || variable("HOME").map(|home| PathBuf::from(home).join(".cache"));
    let folder = variable("MESA_SHADER_CACHE_DIR")
        .or_else(|| variable("MESA_GLSL_CACHE_DIR"))
        .or_else(|| variable("XDG_CACHE_HOME"))
        .map(PathBuf::from)
        .or_else(home);
    // It writes nothing where it may not.
    folder.is_some_and(|folder| {
        let trial = folder.join(format!("halfway-{}", std::process::id()));
        let is_writable = std::fs::create_dir_all(&folder).is_ok() && std::fs::write(&trial, b"").is_ok();
        is_writable && std::fs::remove_file(&trial).is_ok()
    })
}
