#import bind/batch
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

fn bounce_dimension(depth: u32, purpose: u32) -> u32 {
    return depth * BOUNCE_DIMENSIONS + purpose;
}

/// Column and row, in the whole picture, of a path's pixel.
fn path_pixel(path: u32) -> vec2u {
    let pixel = batch.first_pixel + path % batch.pixel_count;
    return vec2u(batch.crop_x + pixel % batch.crop_width, batch.crop_y + pixel / batch.crop_width);
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
