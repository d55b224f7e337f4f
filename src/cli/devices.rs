//! `halfway devices`

use crate::cli::Exit;
use crate::device::context::adapters;
use crate::device::traversal::no_ray_queries;
use crate::device::uuid::uuid;
use crate::out;

/// Prints every adapter with the number that `--device` takes.
pub fn run() -> Exit {
    let adapters = adapters();
    if adapters.is_empty() {
        eprintln!("no Vulkan device; install a GPU driver, or a software one (Debian: tools/setup does it)");
        return Exit::NoDevice;
    }
    for (index, adapter) in adapters.iter().enumerate() {
        let info = adapter.get_info();
        let binding = adapter.limits().max_storage_buffer_binding_size >> 20;
        let uuid = uuid(adapter).map_or(String::new(), |uuid| format!(" uuid:{uuid}"));
        let queries = if no_ray_queries(adapter).is_none() { "; ray queries" } else { "" };
        out!(
            "{index}: {} ({:?}; {} {}; {binding} MiB in one buffer{queries}){uuid}",
            info.name,
            info.device_type,
            info.driver,
            info.driver_info
        );
    }
    Exit::Done
}
