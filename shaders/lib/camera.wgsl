#import bind/batch

// The camera from both sides: rays through the film, and where on the film a point of the scene is seen.

/// Unit direction of the camera's axis.
fn camera_forward() -> vec3f {
    if all(camera.direction_dx == vec3f(0.0)) {
        return camera.direction;
    }
    let normal = normalize(cross(camera.direction_dx, camera.direction_dy));
    return select(normal, -normal, dot(normal, camera.direction) < 0.0);
}

/// Density, per solid angle, of a unit direction that the camera makes for a uniform point of one pixel; for an
/// orthographic camera the density of a ray per area across it.
fn camera_pdf(direction: vec3f) -> f32 {
    let pixels = f32(batch.width) * f32(batch.height);
    if all(camera.direction_dx == vec3f(0.0)) {
        return pixels / (length(camera.origin_dx) * length(camera.origin_dy));
    }
    // The film lies on the plane at distance `camera.direction . forward` in front of the eye.
    let forward = camera_forward();
    let plane = dot(camera.direction, forward);
    let cos_theta = dot(direction, forward);
    let film_area = length(camera.direction_dx) * length(camera.direction_dy);
    return pixels * plane * plane / (film_area * cos_theta * cos_theta * cos_theta);
}

/// A point as the camera sees it.
struct CameraView {
    /// Index of the pixel in the rendered part; NO_PIXEL outside.
    pixel: u32,
    /// Unit direction from the point to the camera, and how far it is.
    direction: vec3f,
    distance: f32,
    /// Turns a cosine at the point into its density per area from the camera, for one pixel.
    pdf_area: f32,
}

/// Pixel of a point of the film in [0, 1)^2.
fn film_pixel(film_point: vec2f) -> u32 {
    if !all(film_point >= vec2f(0.0)) {
        return NO_PIXEL;
    }
    let place = film_point * vec2f(f32(batch.width), f32(batch.height));
    if any(place >= vec2f(f32(batch.width), f32(batch.height))) {
        return NO_PIXEL;
    }
    let pixel = vec2u(place);
    let from_first = vec2u(pixel.x - batch.crop_x, pixel.y - batch.crop_y);
    let inside = from_first / batch.crop_stride;
    let is_between = any(from_first != batch.crop_stride * inside);
    let is_before = any(pixel < vec2u(batch.crop_x, batch.crop_y));
    if is_before || is_between || any(inside >= vec2u(batch.crop_width, batch.crop_height)) {
        return NO_PIXEL;
    }
    return inside.y * batch.crop_width + inside.x;
}

/// Where a direction from the camera meets the film of a perspective camera.
fn direction_pixel(direction: vec3f) -> u32 {
    let forward = camera_forward();
    let along = dot(direction, forward);
    if along <= 0.0 {
        return NO_PIXEL;
    }
    let place = direction * (dot(camera.direction, forward) / along) - camera.direction;
    return film_pixel(vec2f(
        dot(place, camera.direction_dx) / dot(camera.direction_dx, camera.direction_dx),
        dot(place, camera.direction_dy) / dot(camera.direction_dy, camera.direction_dy),
    ));
}

fn camera_view(position: vec3f) -> CameraView {
    let from_origin = position - camera.origin;
    if all(camera.direction_dx == vec3f(0.0)) {
        let distance = dot(from_origin, camera.direction);
        let pixel = film_pixel(vec2f(
            dot(from_origin, camera.origin_dx) / dot(camera.origin_dx, camera.origin_dx),
            dot(from_origin, camera.origin_dy) / dot(camera.origin_dy, camera.origin_dy),
        ));
        let seen = select(NO_PIXEL, pixel, distance > 0.0);
        return CameraView(seen, -camera.direction, distance, camera_pdf(camera.direction));
    }
    let distance = length(from_origin);
    let direction = from_origin / distance;
    let pixel = direction_pixel(direction);
    return CameraView(pixel, -direction, distance, camera_pdf(direction) / (distance * distance));
}
