//! The UUIDs of Vulkan devices: the one name that two equal cards in a machine do not share. NVIDIA's other tools have the
//! same, as `GPU-...`.

use ash::vk;
use wgpu::hal::api::Vulkan;

/// A device's UUID, in lower-case hexadecimal digits with dashes; `None` where the driver does not tell it.
pub fn uuid(adapter: &wgpu::Adapter) -> Option<String> {
    // SAFETY: the handles are only asked for properties, while the adapter lives.
    #[allow(unsafe_code)]
    let bytes = unsafe {
        let adapter = adapter.as_hal::<Vulkan>()?;
        let instance = adapter.shared_instance();
        if instance.instance_api_version() < vk::API_VERSION_1_1 {
            return None;
        }
        let mut id = vk::PhysicalDeviceIDProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut id);
        instance
            .raw_instance()
            .get_physical_device_properties2(adapter.raw_physical_device(), &mut properties);
        id.device_uuid
    };
    let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32].map(|part| &digits[part]);
    Some(parts.join("-"))
}

/// Two UUIDs are the same, however they are written.
pub fn is_uuid(found: &str, wanted: &str) -> bool {
    let digits = |text: &str| text.to_lowercase().replace('-', "");
    digits(found) == digits(wanted.strip_prefix("GPU-").unwrap_or(wanted))
}
