//! Choosing a device and opening it.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Duration;

use wgpu::{Backends, DeviceType, Features, InstanceDescriptor, PollType};

use super::host_memory::free_memory;
use super::pipelines::{Compiling, Pipelines};
use super::traversal::{Traversal, is_gpu, no_ray_queries};
use super::uuid::{is_uuid, uuid};
use crate::device::DeviceError;

/// Which adapter to take.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DeviceChoice {
    /// `WGPU_ADAPTER_NAME` if set, else the first discrete GPU, integrated GPU, any other, software.
    #[default]
    Auto,
    /// As `halfway devices` numbers them.
    Index(usize),
    /// A part of the adapter's name, in any case.
    Name(String),
    /// As `halfway devices` lists it.
    Uuid(String),
    /// A software device.
    Cpu,
}

impl std::str::FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(uuid) = text.strip_prefix("uuid:") {
            return Ok(Self::Uuid(uuid.to_string()));
        }
        Ok(match (text, text.parse()) {
            ("auto", _) => Self::Auto,
            ("cpu", _) => Self::Cpu,
            (_, Ok(index)) => Self::Index(index),
            _ => Self::Name(text.to_string()),
        })
    }
}

/// An open device; a clone is the same one.
#[derive(Clone)]
pub struct Context {
    pub instance: wgpu::Instance,
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub info: wgpu::AdapterInfo,
    /// True when kernels can be timed.
    pub timestamps: bool,
    /// Bytes that its buffers may take together, as far as that is known: of a software device what the machine had left
    /// when it was opened.
    pub memory: Option<u64>,
    /// Bytes of a storage buffer, which is bound whole.
    pub binding: u64,
    /// The most bytes of one page of a scene's buffers: the same, but where tests lower it.
    pub page_bytes: u64,
    /// How rays are to be traced; it has [`ray_queries`](Self::ray_queries) unless that is by kernels.
    pub traversal: Traversal,
    pub(super) pipelines: Pipelines,
    interrupt: Option<Interrupt>,
    pub(super) told_of_compiling: Option<Told>,
}

/// Hears of each kernel that was compiled.
type Told = Arc<dyn Fn(Compiling) + Send + Sync>;

/// What ends work that is under way.
#[derive(Clone)]
struct Interrupt {
    is_wanted: Arc<dyn Fn() -> bool + Send + Sync>,
    grace: Duration,
}

fn instance() -> wgpu::Instance {
    let mut descriptor = InstanceDescriptor::new_without_display_handle();
    descriptor.backends = Backends::VULKAN;
    // A dispatch more for each whose size the device decides: kernels of ours write these sizes, and keep to the limits. And
    // kernels that know their lines, which take long to write: WGPU_DEBUG=1 brings them back, for debuggers of devices.
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL | wgpu::InstanceFlags::DEBUG);
    descriptor.flags = descriptor.flags.with_env();
    wgpu::Instance::new(descriptor)
}

/// Every adapter of this machine, best first: what [`DeviceChoice::Index`] counts.
pub fn adapters() -> Vec<wgpu::Adapter> {
    adapters_of(&instance())
}

fn adapters_of(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    });
    adapters
}

/// The adapter that is chosen, which is not opened.
///
/// # Errors
/// No adapter, or none that fits `choice`.
pub fn adapter(choice: &DeviceChoice) -> Result<wgpu::Adapter, DeviceError> {
    adapter_of(&instance(), choice)
}

fn adapter_of(instance: &wgpu::Instance, choice: &DeviceChoice) -> Result<wgpu::Adapter, DeviceError> {
    let adapters = adapters_of(instance);
    let wanted = match choice {
        DeviceChoice::Auto => match std::env::var("WGPU_ADAPTER_NAME") {
            Ok(name) if !name.is_empty() => DeviceChoice::Name(name),
            _ => DeviceChoice::Index(0),
        },
        other => other.clone(),
    };
    if adapters.is_empty() {
        return Err(DeviceError::NoAdapter);
    }
    let found = adapters.iter().enumerate().find(|(index, adapter)| {
        let info = adapter.get_info();
        match &wanted {
            DeviceChoice::Auto => true,
            DeviceChoice::Index(wanted) => index == wanted,
            DeviceChoice::Name(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
            DeviceChoice::Uuid(wanted) => uuid(adapter).is_some_and(|found| is_uuid(&found, wanted)),
            DeviceChoice::Cpu => info.device_type == DeviceType::Cpu,
        }
    });
    let Some((index, _)) = found else {
        let mut list = String::new();
        for (index, adapter) in adapters.iter().enumerate() {
            let _ = write!(list, "\n  {index}: {}", adapter.get_info().name);
            if let Some(uuid) = uuid(adapter) {
                let _ = write!(list, ", uuid:{uuid}");
            }
        }
        return Err(DeviceError::NotFound { wanted: format!("{wanted:?}"), list });
    };
    Ok(adapters[index].clone())
}

/// Bytes of a storage buffer, which is bound whole.
pub fn binding_of(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

impl Context {
    /// Opens a device without the start-up check.
    ///
    /// # Errors
    /// As [`adapter`]; [`DeviceError::NoRayQueries`].
    pub(super) fn unchecked(choice: &DeviceChoice, traversal: Traversal) -> Result<Self, DeviceError> {
        let instance = instance();
        let adapter = adapter_of(&instance, choice)?;
        let info = adapter.get_info();
        let traversal = match (traversal, no_ray_queries(&adapter)) {
            (Traversal::Compute, _) => Traversal::Compute,
            (Traversal::Hardware, Some(reason)) => {
                return Err(DeviceError::NoRayQueries { device: info.name, reason });
            }
            (Traversal::Auto, _) if !is_gpu(info.device_type) => {
                log::info!("kernels trace rays on {}: a software device is faster by them", info.name);
                Traversal::Compute
            }
            (Traversal::Auto, Some(reason)) => {
                log::info!("kernels trace rays on {}: {reason}", info.name);
                Traversal::Compute
            }
            (wanted, None) => wanted,
        };
        Self::open(instance, &adapter, traversal)
    }

    /// Opens an adapter with all of its limits.
    fn open(
        instance: wgpu::Instance,
        adapter: &wgpu::Adapter,
        traversal: Traversal,
    ) -> Result<Self, DeviceError> {
        let info = adapter.get_info();
        let mut features = adapter.features() & Features::TIMESTAMP_QUERY;
        let mut experimental_features = wgpu::ExperimentalFeatures::disabled();
        if traversal != Traversal::Compute {
            features |= Features::EXPERIMENTAL_RAY_QUERY;
            // SAFETY: what wgpu asks for is to know that its ray queries may still have faults: they are used where they
            // are asked for, or have found the same as our kernels; kernels that are guarded by naga's own checks ask
            // for finite rays only, and read what they find after the query has ended.
            #[allow(unsafe_code)]
            {
                experimental_features = unsafe { wgpu::ExperimentalFeatures::enabled() };
            }
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("halfway"),
            required_features: features,
            required_limits: adapter.limits(),
            experimental_features,
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| DeviceError::Open { name: info.name.clone(), message: error.to_string() })?;
        let timestamps = features.contains(Features::TIMESTAMP_QUERY);
        let memory = if info.device_type == DeviceType::Cpu { free_memory() } else { None };
        let binding = binding_of(&device.limits());
        Ok(Self {
            instance,
            adapter: adapter.clone(),
            device,
            queue,
            info,
            timestamps,
            memory,
            binding,
            page_bytes: binding,
            traversal,
            pipelines: Pipelines::default(),
            interrupt: None,
            told_of_compiling: None,
        })
    }

    /// Another device of the same adapter.
    ///
    /// # Errors
    /// The driver has no more.
    pub(super) fn sibling(&self) -> Result<Self, DeviceError> {
        Self::open(self.instance.clone(), &self.adapter, self.traversal)
    }

    /// The same device; from now on `tell` hears of each kernel that a software driver has compiled, from any thread.
    pub fn telling_of_compiling(&self, tell: impl Fn(Compiling) + Send + Sync + 'static) -> Self {
        Self { told_of_compiling: Some(Arc::new(tell)), ..self.clone() }
    }

    /// The same device for work that can be ended: a round that goes on for longer than `grace` after `is_wanted`, or after
    /// the end of its time, is left unfinished. It is asked between submissions.
    pub fn interrupted_by(
        &self,
        is_wanted: impl Fn() -> bool + Send + Sync + 'static,
        grace: Duration,
    ) -> Self {
        Self { interrupt: Some(Interrupt { is_wanted: Arc::new(is_wanted), grace }), ..self.clone() }
    }

    /// The same device, as one whose storage buffers have no more than so many bytes: what is larger lies in pages there.
    pub fn with_small_bindings(&self, bytes: u64) -> Self {
        let binding = self.binding.min(bytes);
        Self { binding, page_bytes: binding, ..self.clone() }
    }

    /// The same device with a scene's buffers in pages of at most so many bytes, which may be very few.
    pub fn with_page_bytes(&self, page_bytes: u64) -> Self {
        Self { page_bytes, ..self.clone() }
    }

    /// Time that a round has to finish once it is to end, where it can be left unfinished.
    pub fn grace(&self) -> Option<Duration> {
        self.interrupt.as_ref().map(|interrupt| interrupt.grace)
    }

    /// What is under way is to end soon.
    pub fn interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|interrupt| (interrupt.is_wanted)())
    }

    /// It was opened with ray queries.
    pub fn ray_queries(&self) -> bool {
        self.device.features().contains(Features::EXPERIMENTAL_RAY_QUERY)
    }

    /// True for a software device.
    pub fn is_cpu(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Invocations that go through a kernel together, at most.
    pub fn subgroup_lanes(&self) -> u32 {
        self.info.subgroup_max_size.max(1)
    }

    /// Name and driver, as reports print them.
    pub fn describe(&self) -> String {
        format!("{} [{} {}]", self.info.name, self.info.driver, self.info.driver_info)
    }

    /// Waits until the device has done all submitted work.
    ///
    /// # Errors
    /// A lost device.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.device
            .poll(PollType::wait_indefinitely())
            .map_err(|error| DeviceError::Lost { message: error.to_string() })?;
        Ok(())
    }

    /// A pipeline of a shader's only entry point.
    ///
    /// # Errors
    /// What the driver said.
    pub(super) fn create_pipeline(
        &self,
        name: &str,
        code: &str,
        constants: &[(String, f64)],
    ) -> Result<wgpu::ComputePipeline, DeviceError> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = self.create_shader_module(name, code);
        let constants: Vec<(&str, f64)> =
            constants.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        let compute = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(DeviceError::Pipeline { kernel: name.into(), message: error.to_string() }),
            None => Ok(compute),
        }
    }

    /// A module without the loop counters that naga would add to every loop: ours end by construction, and the
    /// counters cost time in the traversal. Bounds stay checked.
    fn create_shader_module(&self, label: &str, code: &str) -> wgpu::ShaderModule {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(code.into()),
        };
        let mut checks = wgpu::ShaderRuntimeChecks::checked();
        checks.force_loop_bounding = false;
        // SAFETY: only shaders of this repository come here, and every loop in them runs over a bounded count or
        // shrinks a finite stack.
        #[allow(unsafe_code)]
        unsafe {
            self.device.create_shader_module_trusted(descriptor, checks)
        }
    }
}
