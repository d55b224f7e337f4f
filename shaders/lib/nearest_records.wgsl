#import bind/batch
#import bind/records
#import lib/math

// The three records nearest to a point. `records` is a left-balanced tree without pointers: the children of i are 2i + 1
// and 2i + 2, and levels divide x, y and z in turn (`math::kd_tree` makes it). Wald, A Stack-Free Traversal Algorithm
// for Left-Balanced k-d Trees, 2022.

/// From near to far; NO_RECORD where there are fewer.
fn nearest_records(position: vec3f) -> vec3u {
    var nearest = vec3u(NO_RECORD);
    var distances_sq = vec3f(MAX_FLOAT);
    // Places count from one, so that the root's parent is 0.
    var place = 1u;
    var before = 0u;
    while place != 0u {
        let parent = place / 2u;
        if place > batch.records {
            before = place;
            place = parent;
            continue;
        }
        let from_parent = before < place;
        let at = records[place - 1u].position;
        if from_parent {
            let span = at - position;
            let distance_sq = dot(span, span);
            if distance_sq < distances_sq.x {
                nearest = vec3u(place - 1u, nearest.xy);
                distances_sq = vec3f(distance_sq, distances_sq.xy);
            } else if distance_sq < distances_sq.y {
                nearest = vec3u(nearest.x, place - 1u, nearest.y);
                distances_sq = vec3f(distances_sq.x, distance_sq, distances_sq.y);
            } else if distance_sq < distances_sq.z {
                nearest.z = place - 1u;
                distances_sq.z = distance_sq;
            }
        }
        let axis = firstLeadingBit(place) % 3u;
        let offset = position[axis] - at[axis];
        let near_child = 2u * place + select(0u, 1u, offset > 0.0);
        var next = parent;
        if from_parent {
            next = near_child;
        } else if before == near_child && offset * offset <= distances_sq.z {
            next = near_child ^ 1u;
        }
        before = place;
        place = next;
    }
    return nearest;
}
