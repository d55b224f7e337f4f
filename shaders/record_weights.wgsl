#if ray_query
enable wgpu_ray_query;
#endif
#import bind/accel
#import bind/batch
#import bind/queue
#import lib/hit
#import lib/math
#import lib/record_light
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
    let record = records[index];
    let place = pair % vertices;
    let light_vertex = light_vertices[light_order[place]];
    let kind = kind_of(light_vertex);
    let point = surface_point(record.triangle, record.b1, record.b2);
    let link = link_to(point, light_vertex, kind);
    var light = record_light(record, point, light_vertex, kind, link);
    if is_drawable(light) {
        light *= seen_share(point, link, kind);
    } else {
        light = 0.0;
    }
#if at_records
    light = counted(light);
#endif
    record_weights[index * vertices + place] = light;
}
