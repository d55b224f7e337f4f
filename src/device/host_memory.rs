//! What the machine has of memory, as Linux tells it; nothing elsewhere.

/// Bytes that the machine has left, or that its container may have at all; `None` where that cannot be told.
pub fn free_memory() -> Option<u64> {
    let machine = kilobytes("/proc/meminfo", "MemAvailable:");
    let container = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let container = container.and_then(|text| text.trim().parse().ok());
    [machine, container].into_iter().flatten().min()
}

/// The most bytes of memory that this process has had at once; of a software device's buffers, too.
pub fn peak_memory() -> Option<u64> {
    kilobytes("/proc/self/status", "VmHWM:")
}

/// The bytes of memory that this process has now.
pub fn used_memory() -> Option<u64> {
    kilobytes("/proc/self/status", "VmRSS:")
}

/// A line `NAME: COUNT kB` of a file, in bytes.
fn kilobytes(path: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}
