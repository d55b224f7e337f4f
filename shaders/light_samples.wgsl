#import bind/accel
#import bind/batch
#import bind/light_cache
#import lib/light
#import lib/subspaces
#import lib/thinning

// The light cache as the host learns from it.

struct LightFeature {
    position: vec3f,
    /// |w|
    weight: f32,
    normal: vec3f,
    /// Index in `lights` plus one of a point on a light; 0 for a surface.
    light: u32,
    /// To the vertex before; on a light, the point: barycentrics, or the equal-area square.
    direction: vec3f,
    depth: u32,
    /// As in the cache; of the vertex that `light_backs` tells of.
    pdf_area: f32,
    pdf_back: f32,
    /// 1 for a point on a light that eye paths may hit.
    can_be_hit: u32,
    /// Of a vertex on a surface: lib/thinning.
    thinning: f32,
}

@group(3) @binding(15) var<storage, read_write> light_features: array<LightFeature>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let index = invocation(id);
    if index >= light_path_offsets[batch.light_path_count] {
        return;
    }
    let vertex = light_vertices[light_order[index]];
    let kind = kind_of(vertex);
    var feature: LightFeature;
    feature.weight = magnitude(vertex.weight);
    feature.direction = vertex.world_from;
    feature.depth = depth_of(vertex);
    feature.pdf_area = vertex.pdf_area;
#if learns
    if feature.depth > 1u {
        feature.pdf_back = light_backs[light_order[index]];
    }
#endif
    if kind <= LIGHT_TRIANGLE + 1u {
        let point = surface_point(index_of(vertex), vertex.b1, vertex.b2);
        feature.position = point.position;
        feature.normal = label_normal(point, vertex.world_from);
        feature.thinning = thinning_at(point.material);
    }
    feature.can_be_hit = select(0u, 1u, kind == LIGHT_TRIANGLE + 1u || kind == LIGHT_ENVIRONMENT + 1u);
    switch kind {
        case 0u: {}
        case LIGHT_TRIANGLE + 1u: {
#if instances
            feature.light = triangles[stored_triangle(index_of(vertex))].light;
#else
            feature.light = triangles[index_of(vertex)].light;
#endif
            feature.direction = vec3f(vertex.b1, vertex.b2, 0.0);
        }
#if environment
        case LIGHT_ENVIRONMENT + 1u: {
            feature.light = environment_map.light + 1u;
            feature.direction = vec3f(vertex.b1, vertex.b2, 0.0);
        }
#endif
        default: {
#if punctual_lights
            // Punctual lights stand behind the triangles and before the environment.
            var after = arrayLength(&punctual_lights);
#if environment
            after += 1u;
#endif
            feature.light = arrayLength(&lights) - after + index_of(vertex) + 1u;
#endif
            feature.direction = vec3f(0.0);
        }
    }
    light_features[index] = feature;
}
