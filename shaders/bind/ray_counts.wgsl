/// Of each ray: nodes and triangles that it looked at.
@group(1) @binding(24) var<storage, read_write> ray_counts: array<vec2u>;
