#import lib/hit

// Absorption along a segment, decided by its ends alone.

/// Share of the light along a segment that a volume lets through. The segment is inside where one of its ends
/// sees it on the inner side of a volume's boundary.
fn transmittance(medium: u32, distance: f32) -> vec3f {
#if absorption
    if medium != 0u {
        return exp(-materials[medium - 1u].absorption * distance);
    }
#endif
    return vec3f(1.0);
}

/// The medium (material index plus one) of a segment that leaves the point towards `world_direction`.
fn medium_towards(point: SurfacePoint, world_direction: vec3f) -> u32 {
#if absorption
    let inside = dot(world_direction, point.world_ng) < 0.0;
    if inside && (materials[point.material].flags & MATERIAL_VOLUME) != 0u {
        return point.material + 1u;
    }
#endif
    return 0u;
}

/// The medium of a segment that starts in `medium` and ends at the point, where it came along -`world_out`.
fn medium_between(medium: u32, point: SurfacePoint, world_out: vec3f) -> u32 {
    if medium != 0u {
        return medium;
    }
    return medium_towards(point, world_out);
}
