#import bind/surface
#import lib/shading
#import lib/math
#import lib/surface
#if instances
#import lib/instance
#endif
#if textures
#import lib/texture
#endif
#if !lambert_only
#import bind/ggx_albedo
#endif

// From a point of a triangle to everything that shading needs there.

/// A point on a surface.
struct SurfacePoint {
    position: vec3f,
    /// Length to step off the surface along `world_ng` before a ray starts: 2^-20 of the largest vertex coordinate,
    /// which is more than the rounding of `position` at every scale. Where surfaces are nearer to each other than that,
    /// 2^-20 of each axis' largest coordinate, as far as that axis is along `world_ng`.
    offset: f32,
    /// Unit geometric normal of the front side.
    world_ng: vec3f,
    material: u32,
    /// Barycentrics of the three stored vertices.
    b: vec3f,
    triangle: u32,
    area: f32,
}

fn surface_point(triangle: u32, b1: f32, b2: f32) -> SurfacePoint {
#if instances
    let stored = triangle_at(triangle);
#else
    let stored = triangles[triangle];
#endif
    let v0 = stored.v0;
    let v1 = stored.v1;
    let v2 = stored.v2;
    let flags = stored.material_flags;
    let b0 = 1.0 - b1 - b2;
    let reach = max(abs(v0), max(abs(v1), abs(v2)));
    // Edges scaled by a power of two before the product, which would underflow on small triangles.
    let e1 = v1 - v0;
    let e2 = v2 - v0;
    let size = max(abs(e1), abs(e2));
    let exponent = bitcast<u32>(max(size.x, max(size.y, size.z))) & 0x7f800000u;
    let scale = bitcast<f32>(0x7f000000u - exponent);
    let normal = edge_product(e1 * scale, e2 * scale, (v2 - v1) * scale);
    let length = sqrt(dot(normal, normal));
    let position = b0 * v0 + b1 * v1 + b2 * v2;
#if thin_gaps
    let offset = dot(abs(normal / length), reach) * 0x1p-20;
#else
    let offset = max(reach.x, max(reach.y, reach.z)) * 0x1p-20;
#endif
    return SurfacePoint(
        position,
        offset,
        normal / select(length, -length, (flags & TRIANGLE_FLIPPED) != 0u),
        flags & TRIANGLE_MATERIAL,
        vec3f(b0, b1, b2),
        triangle,
        0.5 * length / scale / scale,
    );
}

/// Where a ray towards `direction` starts.
fn ray_origin(point: SurfacePoint, direction: vec3f) -> vec3f {
    let step = select(-point.offset, point.offset, dot(direction, point.world_ng) > 0.0);
    return point.position + step * point.world_ng;
}

/// Where a ray ends that comes along `direction` from `distance` away. Across the ray it is known to some 2^-23 of that,
/// which may be more than the offset is.
fn ray_end(point: SurfacePoint, direction: vec3f, distance: f32) -> vec3f {
    let offset = max(point.offset, distance * 0x1p-22);
    return point.position + select(offset, -offset, dot(direction, point.world_ng) > 0.0) * point.world_ng;
}

#if textures
fn point_uv(point: SurfacePoint, slot_index: u32) -> vec2f {
#if uv1
    if (texture_slots[slot_index - 1u].flags & TEXTURE_UV1) != 0u {
        return attribute2(point.triangle, point.b, UV1_OFFSET);
    }
#endif
#if uv0
    return attribute2(point.triangle, point.b, UV0_OFFSET);
#else
    return vec2f(0.0);
#endif
}

/// The texture in a slot at the point; white where the slot is empty.
fn slot_value(point: SurfacePoint, slot_index: u32) -> vec4f {
    if slot_index == 0u {
        return vec4f(1.0);
    }
    return sample_texture(slot_index, point_uv(point, slot_index));
}
#else
fn slot_value(point: SurfacePoint, slot_index: u32) -> vec4f {
    return vec4f(1.0);
}
#endif

/// Base colour and opacity: factor, texture and vertex colour multiplied.
fn point_base_color(point: SurfacePoint) -> vec4f {
    let material = point.material;
    var color = vec4f(materials[material].base_color, materials[material].opacity);
    color *= slot_value(point, materials[material].base_color_texture);
#if vertex_colors
    color *= attribute4(point.triangle, point.b, COLOR_OFFSET);
#endif
    return color;
}

/// Share of the surface that is there: its opacity, all or nothing where that is a mask.
fn point_presence(point: SurfacePoint) -> f32 {
#if alpha
#if instances
    if (triangles[stored_triangle(point.triangle)].material_flags & TRIANGLE_ALPHA) != 0u {
#else
    if (triangles[point.triangle].material_flags & TRIANGLE_ALPHA) != 0u {
#endif
        let opacity = point_base_color(point).a;
        if (materials[point.material].flags & MATERIAL_MASK) != 0u {
            return select(0.0, 1.0, opacity >= materials[point.material].alpha_cutoff);
        }
        return saturate(opacity);
    }
#endif
    return 1.0;
}

/// `point_presence` at barycentrics of a triangle.
fn presence_at(triangle: u32, b1: f32, b2: f32) -> f32 {
    var point: SurfacePoint;
    point.triangle = triangle;
    point.b = vec3f(1.0 - b1 - b2, b1, b2);
#if instances
    point.material = triangles[stored_triangle(triangle)].material_flags & TRIANGLE_MATERIAL;
#else
    point.material = triangles[triangle].material_flags & TRIANGLE_MATERIAL;
#endif
    return point_presence(point);
}

/// Radiance that leaves the point along `world_direction`.
fn point_emission(point: SurfacePoint, world_direction: vec3f) -> vec3f {
    let flags = materials[point.material].flags;
    let front = dot(world_direction, point.world_ng) > 0.0;
    if !front && (flags & MATERIAL_DOUBLE_SIDED) == 0u {
        return vec3f(0.0);
    }
    var emission = materials[point.material].emission;
#if emission_texture
    emission *= slot_value(point, materials[point.material].emission_texture).rgb;
#endif
#if unlit
    // The host has put the light's scale where the emission of an unlit material would stand.
    if (flags & MATERIAL_UNLIT) != 0u {
        emission *= point_base_color(point).rgb;
    }
#endif
    return emission;
}

/// The BSDF's parameters at the point.
fn point_surface(point: SurfacePoint) -> Surface {
    let base_color = point_base_color(point).rgb;
#if lambert_only
    return surface_lambert(base_color);
#else
    let material = materials[point.material];
#if surface_textures
    var factors = SurfaceFactors(
        base_color,
        material.metallic,
        material.specular_color,
        material.specular,
        material.roughness,
        material.transmission,
        material.ior,
        material.flags & (MATERIAL_DELTA | MATERIAL_VOLUME),
    );
#if metallic_roughness_texture
    let metallic_roughness = slot_value(point, material.metallic_roughness_texture);
    factors.metallic *= metallic_roughness.b;
    factors.roughness *= metallic_roughness.g;
#endif
#if specular_texture
    factors.specular_color *= slot_value(point, material.specular_color_texture).rgb;
    factors.specular *= slot_value(point, material.specular_texture).a;
#endif
#if transmission_texture
    factors.transmission *= slot_value(point, material.transmission_texture).r;
#endif
    return surface_from_factors(factors);
#else
    var surface: Surface;
    surface.base_color = base_color;
    surface.flags = material.flags & (MATERIAL_DELTA | MATERIAL_VOLUME);
    surface.f0 = material.f0;
    surface.f90 = material.f90;
    surface.metallic = material.metallic;
    surface.alpha = material.alpha;
#if transmission
    surface.transmission = material.transmission;
    surface.eta = material.eta;
#endif
    surface.inv_base_average = material.inv_base_average;
    surface.albedo_row = material.albedo_row;
    return surface;
#endif
#endif
}

#if instances
#if attributes
/// The vertices of a triangle of an instance: what three numbers of each are, and where they begin.
fn vertex3(vertex: u32) -> vec3f {
    let pair = vec2f(vertex_attributes[vertex], vertex_attributes[vertex + 1u]);
    return vec3f(pair, vertex_attributes[vertex + 2u]);
}
#endif

#if normals
fn interpolated_normal(point: SurfacePoint) -> vec3f {
    if !is_instanced(point.triangle) {
        return safe_normalize(attribute3(point.triangle, point.b, NORMAL_OFFSET));
    }
    let instance = instances[instance_of(point.triangle)];
    let vertices = attribute_vertices(point.triangle) + NORMAL_OFFSET;
    let first = instance_normal(instance, vertex3(vertices.x));
    let second = instance_normal(instance, vertex3(vertices.y));
    let third = instance_normal(instance, vertex3(vertices.z));
    return safe_normalize(first + point.b.y * (second - first) + point.b.z * (third - first));
}
#endif

#if normal_map
fn interpolated_tangent(point: SurfacePoint) -> vec4f {
    if !is_instanced(point.triangle) {
        return attribute4(point.triangle, point.b, TANGENT_OFFSET);
    }
    let instance = instances[instance_of(point.triangle)];
    let vertices = attribute_vertices(point.triangle) + TANGENT_OFFSET;
    let first = instance_tangent(instance, vertex3(vertices.x));
    let second = instance_tangent(instance, vertex3(vertices.y));
    let third = instance_tangent(instance, vertex3(vertices.z));
    let sign = attribute1(vertices, point.b, 3u) * instance.handedness;
    return vec4f(first + point.b.y * (second - first) + point.b.z * (third - first), sign);
}
#endif

#endif
/// The shading normal: interpolated, bent by the normal map.
fn point_normal(point: SurfacePoint) -> vec3f {
    var normal = point.world_ng;
#if normals
#if instances
    let interpolated = interpolated_normal(point);
#else
    let interpolated = safe_normalize(attribute3(point.triangle, point.b, NORMAL_OFFSET));
#endif
    normal = select(normal, interpolated, any(interpolated != vec3f(0.0)));
#endif
#if normal_map
    let slot = materials[point.material].normal_texture;
    if slot != 0u {
#if instances
        let tangent = interpolated_tangent(point);
#else
        let tangent = attribute4(point.triangle, point.b, TANGENT_OFFSET);
#endif
        let bitangent = cross(normal, tangent.xyz) * select(1.0, -1.0, tangent.w < 0.0);
        let map = sample_texture(slot, point_uv(point, slot)).xyz * 2.0 - 1.0;
        let scale = materials[point.material].normal_scale;
        let bent = safe_normalize(map.x * scale * tangent.xyz + map.y * scale * bitangent + map.z * normal);
        normal = select(normal, bent, any(bent != vec3f(0.0)));
    }
#endif
#if bent_normals
    // What points into the surface is mirrored to its outer side.
    normal -= (2.0 * min(dot(normal, point.world_ng), 0.0)) * point.world_ng;
#endif
    return normal;
}

fn point_frame(point: SurfacePoint) -> ShadingFrame {
    return shading_frame(point_normal(point), point.world_ng);
}
