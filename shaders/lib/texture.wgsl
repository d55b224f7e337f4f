#import bind/surface

// Texture lookup: glTF's wrap modes, nearest or bilinear, filtering in linear light.

fn wrap(coordinate: i32, size: i32, mode: u32) -> i32 {
    switch mode {
        case 0u: { // repeat
            let rest = coordinate % size;
            return select(rest, rest + size, rest < 0);
        }
        case 1u: { // mirror
            let period = 2 * size;
            let rest = coordinate % period;
            let positive = select(rest, rest + period, rest < 0);
            return select(positive, period - 1 - positive, positive >= size);
        }
        default: { // clamp
            return clamp(coordinate, 0, size - 1);
        }
    }
}

/// IEC 61966-2-1.
fn srgb_to_linear(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

fn texel(slot: TextureSlot, x: i32, y: i32) -> vec4f {
    let column = wrap(x, i32(slot.width), slot.flags & 3u);
    let row = wrap(y, i32(slot.height), (slot.flags >> 2u) & 3u);
    let value = unpack4x8unorm(texels[slot.offset + u32(row) * slot.width + u32(column)]);
    if (slot.flags & TEXTURE_SRGB) != 0u {
        return vec4f(srgb_to_linear(value.rgb), value.a);
    }
    return value;
}

/// A coordinate brought into one period, so that it fits an integer; both wrapping modes repeat after 2.
fn reduce(x: f32, mode: u32) -> f32 {
    return select(clamp(x, -1.0, 2.0), x - 2.0 * floor(0.5 * x), mode != 2u);
}

/// The texture of slot index `slot_index` (plus one, as materials store it) at `uv`.
fn sample_texture(slot_index: u32, uv: vec2f) -> vec4f {
    let slot = texture_slots[slot_index - 1u];
    let size = vec2f(f32(slot.width), f32(slot.height));
    let moved = vec2f(dot(slot.row_u, vec3f(uv, 1.0)), dot(slot.row_v, vec3f(uv, 1.0)));
    let inside = vec2f(reduce(moved.x, slot.flags & 3u), reduce(moved.y, (slot.flags >> 2u) & 3u));
    let is_nearest = (slot.flags & TEXTURE_NEAREST) != 0u;
    let position = inside * size - select(0.5, 0.0, is_nearest);
    let corner = floor(position);
    let weight = select(position - corner, vec2f(0.0), is_nearest);
    let at = vec2i(corner);
    // A loop, since a look-up is much code and drivers inline every call. One whose length is a constant is unrolled.
    let taps = select(4, 1, is_nearest);
    var sum = vec4f(0.0);
    for (var tap = 0; tap < taps; tap++) {
        let offset = vec2i(tap & 1, tap >> 1u);
        let share = select(vec2f(1.0) - weight, weight, offset == vec2i(1));
        sum += texel(slot, at.x + offset.x, at.y + offset.y) * (share.x * share.y);
    }
    return sum;
}
