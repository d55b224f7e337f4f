#import bind/accel
#import lib/math

// Triangles of meshes that are shown in many places, by their numbers: see src/accel/instances.rs.

fn is_instanced(triangle: u32) -> bool {
    return triangle >= instance_numbers.first;
}

/// The instance of a triangle that `is_instanced`.
fn instance_of(triangle: u32) -> u32 {
    return instance_blocks[(triangle - instance_numbers.first) >> instance_numbers.block_bits];
}

/// Index into `triangles`.
fn stored_triangle(triangle: u32) -> u32 {
    if !is_instanced(triangle) {
        return triangle;
    }
    return triangle - instances[instance_of(triangle)].shift;
}

/// A point of the mesh's space in unit space. The parts of the sum that are small come first.
fn instance_point(instance: Instance, v: vec3f) -> vec3f {
    return instance.origin + ((instance.x * v.x + instance.y * v.y + instance.z * v.z) + instance.origin_rest);
}

/// A unit normal of the mesh's space in unit space: by the cofactors, which are the inverse transpose times the determinant.
fn instance_normal(instance: Instance, n: vec3f) -> vec3f {
    let sum = cross(instance.y, instance.z) * n.x + cross(instance.z, instance.x) * n.y
        + cross(instance.x, instance.y) * n.z;
    return safe_normalize(sum) * instance.handedness;
}

/// A unit tangent of the mesh's space in unit space.
fn instance_tangent(instance: Instance, t: vec3f) -> vec3f {
    return safe_normalize(instance.x * t.x + instance.y * t.y + instance.z * t.z);
}

/// A triangle in unit space, as a copy of it would be.
fn triangle_at(triangle: u32) -> Triangle {
    var found = triangles[stored_triangle(triangle)];
    if is_instanced(triangle) {
        let instance = instances[instance_of(triangle)];
        found.v0 = instance_point(instance, found.v0);
        found.v1 = instance_point(instance, found.v1);
        found.v2 = instance_point(instance, found.v2);
        found.material_flags ^= select(0u, TRIANGLE_FLIPPED, instance.handedness < 0.0);
    }
    return found;
}
