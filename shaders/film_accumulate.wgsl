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
    for (var i = 0u; i < batch.sample_count; i++) {
        let first_cell = (i * batch.pixel_count + index) * CELLS;
        var sample = radiance[first_cell].rgb;
        for (var cell = 1u; cell < CELLS; cell++) {
            sample += radiance[first_cell + cell].rgb;
        }
#if splats
        let splat = take_splat(batch.first_pixel + index);
        sample += splat.rgb;
        pixel.non_finite += u32(splat.w);
#endif
        if is_finite3(sample) {
            pixel.sum += sample;
            pixel.sum_sq += sample * sample;
            pixel.count++;
        } else {
            pixel.non_finite++;
        }
    }
    film[batch.first_pixel + index] = pixel;
}
