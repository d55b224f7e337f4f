//! Compiling before the first dispatch. Software drivers compile where they dispatch first, one kernel after the other on one
//! core, for up to half a minute each. Here they do so when kernels are first bound: all that wait, the dearest first, some of
//! them on further devices of the same driver, whose work the driver finds in its cache on disk.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::context::Context;
use super::pipelines::{Bindable, Compiling, Pipeline, Waiting};
use super::structure;
use crate::device::DeviceError;

/// Bytes of each buffer that a kernel is bound to while it is compiled.
const BUFFER: u64 = 1 << 16;
/// Others help where the first kernel takes longer: where it is in the driver's cache it takes milliseconds.
const PATIENCE: Duration = Duration::from_millis(200);
/// More devices than this have too little to do each.
const MOST_HELPERS: usize = 7;

/// Kernels that wait: which have been begun, and which are compiled.
struct Work<'a> {
    waiting: &'a [Waiting],
    next: AtomicUsize,
    compiled: Mutex<BTreeSet<usize>>,
    progress: Condvar,
}

impl Context {
    /// Makes a software driver compile all that was created and not bound so far.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn finish_compiling(&self) -> Result<(), DeviceError> {
        let mut waiting = self.pipelines.take_waiting();
        if waiting.is_empty() {
            return Ok(());
        }
        // The text tells what is dear. Bytes, then names, so that the order is always the same.
        waiting.sort_by(|a, b| (b.key.0.len(), &a.name).cmp(&(a.key.0.len(), &b.name)));
        let work = Work {
            waiting: &waiting,
            next: AtomicUsize::new(0),
            compiled: Mutex::default(),
            progress: Condvar::new(),
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let helpers = (cores - 1).min(MOST_HELPERS).min(waiting.len() - 1);
        let work = &work;
        let own = std::thread::scope(|scope| {
            if helpers > 0 {
                scope.spawn(move || {
                    if work.is_slow() && keeps_compiled(&self.info.driver) {
                        // What does not compile there is compiled here, and says why.
                        (0..helpers).for_each(|_| drop(scope.spawn(move || work.help(self))));
                    }
                });
            }
            let own = work.compile(|one| dispatch_nothing(self, &one.name, &one.pipeline), self);
            if own.is_err() {
                // Nothing is left for others either.
                work.next.store(waiting.len(), Ordering::Relaxed);
            }
            own
        })?;
        // What others compiled lies in the driver's cache; what they could not is left.
        for (index, one) in waiting.iter().enumerate().filter(|(index, _)| !own.contains(index)) {
            let start = Instant::now();
            dispatch_nothing(self, &one.name, &one.pipeline)?;
            work.tell(index, start.elapsed(), self);
        }
        Ok(())
    }
}

impl Work<'_> {
    /// Compiles one kernel after the other as long as any is left; which ones.
    fn compile(
        &self,
        compile: impl Fn(&Waiting) -> Result<(), DeviceError>,
        context: &Context,
    ) -> Result<BTreeSet<usize>, DeviceError> {
        let mut own = BTreeSet::new();
        loop {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(one) = self.waiting.get(index) else { return Ok(own) };
            let start = Instant::now();
            compile(one)?;
            self.tell(index, start.elapsed(), context);
            own.insert(index);
        }
    }

    /// The same on another device.
    fn help(&self, context: &Context) -> Result<BTreeSet<usize>, DeviceError> {
        let helper = context.sibling()?;
        let compile = |one: &Waiting| {
            let compute = helper.create_pipeline(&one.name, &one.key.0, &one.constants)?;
            dispatch_nothing(&helper, &one.name, &Pipeline { compute, ..one.pipeline.clone() })
        };
        self.compile(compile, context)
    }

    /// Whether no kernel is compiled within [`PATIENCE`].
    fn is_slow(&self) -> bool {
        let compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.progress.wait_timeout_while(compiled, PATIENCE, |compiled| compiled.is_empty());
        waited.unwrap_or_else(PoisonError::into_inner).0.is_empty()
    }

    /// A kernel is compiled, for the first time.
    fn tell(&self, index: usize, taken: Duration, context: &Context) {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        if !compiled.insert(index) {
            return;
        }
        self.progress.notify_all();
        let (kernel, seconds) = (&*self.waiting[index].name, taken.as_secs_f64());
        log::debug!("compiled {kernel}: {seconds:.2} s");
        if let Some(told) = &context.told_of_compiling {
            told(Compiling { kernel, done: compiled.len(), of: self.waiting.len(), seconds });
        }
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
    let mut nothing = |slot: &str| match pipeline.structure.as_deref() == Some(slot) {
        true => Ok(Bindable::AccelerationStructure(structure::record(context, &[], &mut encoder))),
        false => Ok(Bindable::Buffer(buffer())),
    };
    let bound = pipeline.bind(&context.device, name, &mut nothing)?;
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
