#import bind/batch
#import bind/film
#import bind/page
#import bind/queue
#import lib/math
#if splats
#import lib/splat
#endif

// Adds a batch to the film, sample by sample in the order of their indices: the sums do not depend on how the
// samples were cut into batches. A sample that is not finite is left out and counted.

/// Below it squares come near to the smallest f32; a picture may be so much dimmer than its scene's strongest light.
const DIM: f32 = 0x1p-50;

/// Adds x^2 / samples to a sum of squares. As long as all x are dim the sum is kept as -2^120 times its value, and every x
/// from 2^-123 to 2^64 counts; no bit differs from a plain sum that neither over- nor underflows.
fn add_square(sum_sq: f32, x: f32, samples: f32) -> f32 {
    if sum_sq > 0.0 || abs(x) >= DIM {
        // What underflows here is nothing beside x^2.
        return select(sum_sq, sum_sq * -0x1p-120, sum_sq < 0.0) + x * x / samples;
    }
    let scaled = x * 0x1p+60;
    return sum_sq - scaled * scaled / samples;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= batch.pixel_count {
        return;
    }
    let place = in_page(batch.first_pixel + index);
    var pixel = film[place];
#if splats
    // What light paths bring is the same for all samples that share them, of this batch and of others.
    let splat = splat_of(place);
    let splat_light = splat.rgb / batch.splat_scale;
    pixel.non_finite += u32(splat.w);
#endif
    for (var i = 0u; i < batch.sample_count; i++) {
        let first_slot = (i * batch.pixel_count + index) * CONNECTIONS_IN_FLIGHT;
        var sample = radiance[first_slot].rgb;
        for (var slot = 1u; slot < CONNECTIONS_IN_FLIGHT; slot++) {
            sample += radiance[first_slot + slot].rgb;
        }
#if splats
        sample += splat_light;
#endif
        if is_finite3(sample) {
            pixel.open += sample;
            pixel.open_groups++;
        } else {
            pixel.non_finite++;
        }
        let in_group = pixel.open_groups & 0xffu;
        if (batch.first_sample + i + 1u) % SAMPLES_A_GROUP == 0u && in_group > 0u {
            pixel.sum += pixel.open;
            for (var channel = 0u; channel < 3u; channel++) {
                pixel.sum_sq[channel] =
                    add_square(pixel.sum_sq[channel], pixel.open[channel], f32(in_group));
            }
            pixel.count += in_group;
            pixel.open = vec3f(0.0);
            pixel.open_groups += 256u - in_group;
        }
    }
    film[place] = pixel;
}
