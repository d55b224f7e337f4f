#import bind/batch
#import bind/film
#import bind/queue
#import lib/math
#if splats
#import lib/splat
#endif

// Adds a batch to the film, sample by sample in the order of their indices: the sums do not depend on how the
// samples were cut into batches. A sample that is not finite is left out and counted.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= batch.pixel_count {
        return;
    }
    var pixel = film[batch.first_pixel + index];
#if splats
    // What light paths bring is the same for all samples that share them.
    let splat = take_splat(batch.first_pixel + index);
    pixel.non_finite += u32(splat.w);
#endif
    for (var i = 0u; i < batch.sample_count; i++) {
        let first_slot = (i * batch.pixel_count + index) * CONNECTIONS_IN_FLIGHT;
        var sample = radiance[first_slot].rgb;
        for (var slot = 1u; slot < CONNECTIONS_IN_FLIGHT; slot++) {
            sample += radiance[first_slot + slot].rgb;
        }
#if splats
        sample += splat.rgb;
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
            pixel.sum_sq += pixel.open * pixel.open / f32(in_group);
            pixel.count += in_group;
            pixel.open = vec3f(0.0);
            pixel.open_groups += 256u - in_group;
        }
    }
    film[batch.first_pixel + index] = pixel;
}
