/// For the making of the alias tables, running sums over the places of a subspace: the units that slots lack, and those
/// that they have to spare.
@group(3) @binding(13) var<storage, read_write> bucket_sums: array<vec2u>;
