#import bind/batch
#import bind/film
#import bind/queue
#import lib/math

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
        let sample = radiance[i * batch.pixel_count + index].rgb;
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
