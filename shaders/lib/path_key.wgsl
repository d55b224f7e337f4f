#import bind/batch
#import lib/kronecker
#import lib/rng

// From a path of the batch to its pixel and its random numbers. Light paths have a seed of their own; they belong
// to a pixel's sample, or (`shared_light_paths`) to all of an iteration.
// A dimension belongs to one purpose:
// the camera takes 0; the surface at depth d takes BOUNCE_DIMENSIONS numbers from 1 + d * BOUNCE_DIMENSIONS.

const DIMENSION_CAMERA: u32 = 0u;
const BOUNCE_DIMENSIONS: u32 = 4u;
const DIMENSION_BSDF: u32 = 1u;
const DIMENSION_LIGHT: u32 = 2u;
const DIMENSION_LIGHT_POINT: u32 = 3u;
const DIMENSION_ALPHA: u32 = 4u;
/// Added to a dimension: what all paths of a group share of it.
const GROUP_DIMENSION: u32 = 0x80000000u;

fn bounce_dimension(depth: u32, purpose: u32) -> u32 {
    return depth * BOUNCE_DIMENSIONS + purpose;
}

/// Column and row, in the whole picture, of a path's pixel.
fn path_pixel(path: u32) -> vec2u {
    let pixel = batch.first_pixel + path % batch.pixel_count;
    let place = vec2u(pixel % batch.crop_width, pixel / batch.crop_width);
    return vec2u(batch.crop_x, batch.crop_y) + batch.crop_stride * place;
}

/// A sample's numbers depend on its place in the whole picture, not on the part that is rendered.
fn path_key(path: u32) -> RandomKey {
#if shared_light_paths
    return RandomKey(batch.first_light_path + path, batch.first_sample, batch.light_seed);
#else
    let pixel = path_pixel(path);
    let sample = batch.first_sample + path / batch.pixel_count;
#if light_paths
    return RandomKey(pixel.y * batch.width + pixel.x, sample, batch.light_seed);
#else
    return RandomKey(pixel.y * batch.width + pixel.x, sample, batch.seed);
#endif
#endif
}

#if !independent
/// Steps of `path_words` for one dimension; 0 where the number is drawn for every path by itself.
fn path_steps(dimension: u32) -> vec4u {
#if shared_light_paths
    // The light and the point on it, then the direction.
    switch dimension {
        case DIMENSION_LIGHT: {
            return vec4u(KRONECKER_6[0], 0u, KRONECKER_6[1], KRONECKER_6[2]);
        }
        case DIMENSION_LIGHT_POINT: {
            return vec4u(KRONECKER_6[3], 0u, 0u, 0u);
        }
        case DIMENSION_BSDF: {
            return vec4u(KRONECKER_6[4], KRONECKER_6[5], 0u, 0u);
        }
        default: {
            return vec4u(0u);
        }
    }
#else
#if light_paths
    return vec4u(0u);
#else
    // The point of the pixel, the first two directions, the first roulette, and the first vertex's subspaces, or its light
    // and the point on it.
    switch dimension {
        case DIMENSION_CAMERA: {
            return vec4u(LATTICE_8[0], LATTICE_8[1], 0u, 0u);
        }
        case DIMENSION_BSDF: {
            return vec4u(LATTICE_8[2], LATTICE_8[3], 0u, LATTICE_8[4]);
        }
        case DIMENSION_LIGHT: {
            return vec4u(LATTICE_8[7], 0u, LATTICE_8[8], LATTICE_8[9]);
        }
        case DIMENSION_BSDF + BOUNCE_DIMENSIONS: {
            return vec4u(LATTICE_8[5], LATTICE_8[6], 0u, 0u);
        }
        default: {
            return vec4u(0u);
        }
    }
#endif
#endif
}
#endif

/// A path's numbers of one dimension as words: the samples of a pixel's group, and the light paths of an iteration, fill
/// the first dimensions evenly. Each number alone is uniform, and groups are independent.
fn path_words(path: u32, dimension: u32) -> vec4u {
    var key = path_key(path);
    let words = random4(key, dimension);
#if independent
    return words;
#else
    let steps = path_steps(dimension);
    if all(steps == vec4u(0u)) {
        return words;
    }
    // From here on the key of the group.
#if shared_light_paths
    let index = key.pixel;
    key.pixel = 0u;
#else
    let index = key.sample % SAMPLES_A_GROUP;
    key.sample /= SAMPLES_A_GROUP;
#endif
    let shift = random4(key, dimension + GROUP_DIMENSION);
    return select(words, shift + index * steps, steps != vec4u(0u));
#endif
}

/// The same as numbers in [0, 1).
fn path_uniform4(path: u32, dimension: u32) -> vec4f {
    return uniforms_from_words(path_words(path, dimension));
}
