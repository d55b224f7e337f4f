// What rays of light paths carry where weights take light as it arrives at records: lib/weights_at_records.

/// Of each ray of the queue the slot in the cache of the vertex that it leaves, which is no delta vertex.
@group(1) @binding(21) var<storage, read_write> light_ends_in: array<u32>;
@group(1) @binding(22) var<storage, read_write> light_ends_out: array<u32>;
/// For the vertices that light paths in the queue have just reached: density of a connection to the vertex before.
@group(1) @binding(23) var<storage, read_write> light_edges: array<f32>;

/// The slot of the vertex that was put into the cache last.
var<private> cached_slot: u32;
