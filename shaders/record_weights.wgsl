#if ray_query
enable wgpu_ray_query;
#endif
#import bind/accel
#import bind/batch
#import bind/queue
#import lib/hit
#import lib/math
#import lib/record_sight
#if at_records
#import lib/record_shares
#endif

// The light that each vertex of the light cache brings to each record: an invocation and a ray for each pair.

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let vertices = light_path_offsets[batch.light_path_count];
    let pair = invocation(id);
    let index = batch.first_record + pair / vertices;
    if index >= batch.records {
        return;
    }
    let place = pair % vertices;
    let light = seen_light(records[index], light_vertices[light_order[place]]);
#if at_records
    record_weights[index * vertices + place] = counted(light);
#else
    record_weights[index * vertices + place] = light;
#endif
}
