// Constants and small functions that say what they guarantee where WGSL's own do not.

const PI: f32 = 3.14159265358979;
const INV_PI: f32 = 0.318309886183791;
const TWO_PI: f32 = 6.28318530717959;
const INV_TWO_PI: f32 = 0.159154943091895;
const INV_FOUR_PI: f32 = 0.0795774715459477;
/// Largest finite number; stands for "no limit" where WGSL has no infinity to write down.
const MAX_FLOAT: f32 = 0x1.fffffep+127;

#if software
// Software drivers make three instructions of WGSL's min and max, for the sake of NaN.

fn smaller(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

fn larger(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

fn smaller4(a: vec4f, b: vec4f) -> vec4f {
    return select(b, a, a < b);
}

fn larger4(a: vec4f, b: vec4f) -> vec4f {
    return select(b, a, a > b);
}
#else
/// Of numbers, as the three below.
fn smaller(a: f32, b: f32) -> f32 {
    return min(a, b);
}

fn larger(a: f32, b: f32) -> f32 {
    return max(a, b);
}

fn smaller4(a: vec4f, b: vec4f) -> vec4f {
    return min(a, b);
}

fn larger4(a: vec4f, b: vec4f) -> vec4f {
    return max(a, b);
}
#endif

/// True unless x is an infinity or a NaN. A test of bits: comparisons may be folded under WGSL's rules.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn is_finite3(v: vec3f) -> bool {
    return all((bitcast<vec3u>(v) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}

/// v / |v| for every finite v whose largest component is at least 2^-126; the zero vector below that; v itself
/// where it is not finite, so that the fault stays visible. WGSL's `normalize` squares first, and so
/// overflows from 2^64 and vanishes below 2^-63.
fn safe_normalize(v: vec3f) -> vec3f {
    let bits = bitcast<vec3u>(v) & vec3u(0x7f800000u);
    let exponent = max(bits.x, max(bits.y, bits.z));
    if exponent == 0x7f800000u {
        return v;
    }
    if exponent == 0u {
        return vec3f(0.0);
    }
    // The power of two that brings the largest component into [1, 2), or into [2, 4) at the top of the range.
    let scale = bitcast<f32>(max(0x7f000000u - exponent, 0x00800000u));
    let scaled = v * scale;
    return scaled / sqrt(dot(scaled, scaled));
}

/// e1 x e2, where e3 = e2 - e1, from the two shorter edges: the product of a sliver's long ones would have few
/// digits, and rays would leave to the wrong side.
fn edge_product(e1: vec3f, e2: vec3f, e3: vec3f) -> vec3f {
    let size = vec3f(dot(e1, e1), dot(e2, e2), dot(e3, e3));
    if size.z >= max(size.x, size.y) {
        return cross(e1, e2);
    }
    return cross(select(e1, e2, size.x > size.y), e3);
}
