//! Who finds where rays meet surfaces: kernels of this repository, or the driver's ray queries, which GPUs may have in
//! hardware.

use clap::ValueEnum;
use serde::Serialize;
use wgpu::{Adapter, DeviceType, Features};

/// How rays are traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Traversal {
    /// By the device's ray queries on a GPU that has them, where they find the same and are faster in a short trial of
    /// the scene; else by kernels.
    #[default]
    Auto,
    /// By kernels: the same on every device.
    Compute,
    /// By the device's ray queries.
    Hardware,
}

/// The first Mesa whose RADV compiles guarded ray queries without a crash (gfx-rs/wgpu#8530).
const RADV_SINCE: [u32; 3] = [25, 3, 4];

/// Why this adapter has no ray queries; `None` where it has.
pub fn no_ray_queries(adapter: &Adapter) -> Option<String> {
    let info = adapter.get_info();
    if !adapter.features().contains(Features::EXPERIMENTAL_RAY_QUERY) {
        return Some("it has no ray queries (VK_KHR_ray_query and VK_KHR_acceleration_structure)".into());
    }
    let version = mesa_version(&info.driver_info).filter(|_| info.driver == "radv")?;
    let since = RADV_SINCE.map(|number| number.to_string()).join(".");
    (version < RADV_SINCE).then(|| {
        format!("its driver, {}, may crash on ray queries; Mesa {since} mends that", info.driver_info)
    })
}

/// The numbers of `Mesa 25.0.7-2~bpo12+1`.
fn mesa_version(driver_info: &str) -> Option<[u32; 3]> {
    let numbers = driver_info.strip_prefix("Mesa ")?;
    let mut numbers = numbers.split(|c: char| !c.is_ascii_digit()).map(|number| number.parse().unwrap_or(0));
    Some(std::array::from_fn(|_| numbers.next().unwrap_or(0)))
}

/// Has processors of its own: what software devices do with ray queries, kernels do faster.
pub(super) fn is_gpu(device_type: DeviceType) -> bool {
    matches!(device_type, DeviceType::DiscreteGpu | DeviceType::IntegratedGpu | DeviceType::VirtualGpu)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_mesa() {
        assert_eq!(mesa_version("Mesa 25.0.7-2~bpo12+1"), Some([25, 0, 7]));
        assert_eq!(mesa_version("Mesa 25.3.4-arch1.2"), Some([25, 3, 4]));
        assert_eq!(mesa_version("Mesa 26.1"), Some([26, 1, 0]));
        assert_eq!(mesa_version("570.86.10"), None);
        assert!([25, 3, 3] < RADV_SINCE && [26, 0, 0] > RADV_SINCE);
    }
}
