#import bind/batch
#import bind/queue
#import lib/splat

// Adds the connections to the camera that nothing blocks to the pixels of one page, where the picture has several; each
// page has its turn.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= counts.shadow_in {
        return;
    }
    let ray = shadow_rays[index];
    if in_page(ray.slot) < page.pixel_count {
        add_splat(ray.slot, ray.contribution * batch.splat_scale);
    }
}
