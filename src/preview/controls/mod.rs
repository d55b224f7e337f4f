//! How the pointer, the wheel and keys move a camera: a turntable about the world's +y, in `f64` and in measures of the
//! scene, so that scenes of any size and place are alike.

#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use crate::scene::{Bounds, Camera, Pose, Projection, Scene, Viewpoint, ViewpointError, moved_name};

/// Nearest to straight up or down that turning goes: the picture never flips.
const PITCH_LIMIT: f64 = FRAC_PI_2 - 1e-3;
/// What orbiting by the picture's height turns by.
const ORBIT_ANGLE: f64 = PI;
/// What `look` by the picture's height turns by where there is no field of view.
const LOOK_ANGLE: f64 = 1.0;
/// What a step of the wheel leaves of the distance.
const STEP: f64 = 0.9;
/// Of flying, in radii of the scene per second; and the factor of fast flight.
const SPEED: f64 = 0.5;
const FAST: f64 = 4.0;
/// Distances and heights that the wheel reaches, in radii of the scene.
const REACH: [f64; 2] = [1e-9, 1e9];

/// A camera that the user moves. Movements of the pointer are in heights of the picture, x to the right and y down.
/// What would leave no camera, such as a movement that is not finite, is left out.
#[derive(Clone, Debug)]
pub struct Navigator {
    /// The scene's own camera, which the viewpoint moves.
    own: Camera,
    /// What makes `start` of it.
    viewpoint: Viewpoint,
    start: Camera,
    start_view: View,
    view: View,
    moved: bool,
    bounds: Bounds,
}

impl Navigator {
    /// Begins with the camera that is asked for.
    ///
    /// # Errors
    /// There is no such camera.
    pub fn new(scene: &Scene, viewpoint: &Viewpoint) -> Result<Self, ViewpointError> {
        let bounds = scene.bounds();
        let own = viewpoint.own(scene)?;
        let start = viewpoint.apply(&own)?;
        let camera = viewpoint.camera.clone().or_else(|| Viewpoint::naming(scene, 0).camera);
        let distance = match viewpoint.pose(&own)? {
            Some(pose) => pose.from.distance(pose.at),
            // Until `set_pivot_distance` is given what the middle of the picture shows.
            None => {
                (bounds.centre() - start.position).dot(start.forward.as_dvec3()).max(0.25 * bounds.radius())
            }
        };
        let view = View::of(&start, distance);
        let viewpoint = Viewpoint { camera, ..viewpoint.clone() };
        Ok(Self { own, viewpoint, start, start_view: view, view, moved: false, bounds })
    }

    /// Turns about the pivot, as if the scene were on a turntable that the pointer drags.
    pub fn orbit(&mut self, dx: f64, dy: f64) {
        if dx != 0.0 || dy != 0.0 {
            let turned = self.view.turned(ORBIT_ANGLE * dx, ORBIT_ANGLE * dy);
            self.go(turned.around(self.view.pivot(), self.view.distance));
        }
    }

    /// Moves along the picture, so that what is as far as the pivot follows the pointer.
    pub fn pan(&mut self, dx: f64, dy: f64) {
        let [right, up, _] = self.view.axes();
        let height = self.view.projection.height_at(self.view.distance);
        self.go(self.view.shifted((up * dy - right * dx) * height));
    }

    /// Comes a tenth closer to the pivot with each step, or moves away where they are negative; scales what an
    /// orthographic camera sees.
    pub fn dolly(&mut self, steps: f64) {
        if steps == 0.0 {
            return;
        }
        let [low, high] = REACH.map(|reach| reach * self.bounds.radius());
        let scaled = |length: f64| (length * STEP.powf(steps)).clamp(low.min(length), high.max(length));
        let view = self.view;
        self.go(match view.projection {
            Projection::Perspective { .. } => view.around(view.pivot(), scaled(view.distance)),
            Projection::Orthographic { ymag, .. } => self.tall(scaled(2.0 * f64::from(ymag))),
        });
    }

    /// Turns the camera on the spot: a perspective one by the angle that the pointer passes over in the picture's middle.
    pub fn look(&mut self, dx: f64, dy: f64) {
        if dx != 0.0 || dy != 0.0 {
            let angle = match self.view.projection {
                Projection::Perspective { yfov } => f64::from(yfov),
                Projection::Orthographic { .. } => LOOK_ANGLE,
            };
            self.go(self.view.turned(angle * dx, angle * dy));
        }
    }

    /// Flies for some seconds, the pivot with it: right and forward as in the picture, up as in the world; 1 is full
    /// speed.
    pub fn fly(&mut self, right: f64, up: f64, forward: f64, seconds: f64, fast: bool) {
        let [to_right, _, ahead] = self.view.axes();
        let way = SPEED * if fast { FAST } else { 1.0 } * seconds * self.bounds.radius();
        self.go(self.view.shifted((to_right * right + DVec3::Y * up + ahead * forward) * way));
    }

    /// Keeps the direction and backs off until a picture of that aspect, width over height, has all of the scene.
    pub fn frame_all(&mut self, aspect: f64) {
        let (centre, radius) = (self.bounds.centre(), self.bounds.radius());
        let narrow = aspect.min(1.0);
        self.go(match self.view.projection {
            Projection::Perspective { yfov } => {
                let half = ((0.5 * f64::from(yfov)).tan() * narrow).atan();
                self.view.around(centre, radius / half.sin())
            }
            Projection::Orthographic { .. } => self.tall(2.0 * radius / narrow).around(centre, 2.0 * radius),
        });
    }

    /// Back to the camera that it began with.
    pub fn reset(&mut self) {
        (self.view, self.moved) = (self.start_view, false);
    }

    /// Puts the pivot at the depth of what is in the picture's middle, such as [`Scene::distance_along`] finds it. The
    /// camera stays.
    pub fn set_pivot_distance(&mut self, distance: f64) {
        if distance > 0.0 && distance.is_finite() {
            self.view.distance = distance.max(REACH[0] * self.bounds.radius());
        }
    }

    /// The point that orbiting turns about and the wheel comes closer to.
    pub fn pivot(&self) -> DVec3 {
        self.view.pivot()
    }

    /// Where the camera stands; with the pivot, a line to look along.
    pub fn from(&self) -> DVec3 {
        self.view.from
    }

    /// From the camera to the pivot, scene units.
    pub fn pivot_distance(&self) -> f64 {
        self.view.distance
    }

    /// It is not the camera that it began with.
    pub fn moved(&self) -> bool {
        self.moved
    }

    /// The camera; bit for bit the one that it began with before it has moved, and after that the one of the flags.
    pub fn camera(&self) -> Camera {
        let camera = || self.view.pose().camera(&moved_name(&self.own));
        self.moved.then(camera).flatten().unwrap_or_else(|| self.start.clone())
    }

    /// What makes the camera of the scene.
    pub fn viewpoint(&self) -> Viewpoint {
        if self.moved { self.viewpoint.moved(&self.view.pose()) } else { self.viewpoint.clone() }
    }

    /// The same as text for a command line.
    pub fn flags(&self) -> String {
        self.viewpoint().to_string()
    }

    /// The view with another height of its orthographic projection, where there can be such.
    fn tall(&self, height: f64) -> View {
        // Of the own camera, as the command line does it: roundings do not add up.
        let projection = self.own.projection.with_height(height).unwrap_or(self.view.projection);
        View { projection, ..self.view }
    }

    fn go(&mut self, view: View) {
        if view != self.view && view.distance.is_finite() && view.pose().camera("").is_some() {
            (self.view, self.moved) = (view, true);
        }
    }
}

/// Where a camera stands and how it is turned. Angles do not drift as axes do, turned again and again.
#[derive(Clone, Copy, Debug, PartialEq)]
struct View {
    from: DVec3,
    /// About +y, 0 looks along -z; radians, as the other angles.
    yaw: f64,
    /// Above the horizon.
    pitch: f64,
    /// About the direction of looking; 0 is upright.
    roll: f64,
    /// To the pivot.
    distance: f64,
    projection: Projection,
}

impl View {
    fn of(camera: &Camera, distance: f64) -> Self {
        let [right, up, forward] = [camera.right, camera.up, camera.forward].map(|axis| axis.as_dvec3());
        // No more than `f32` makes of nothing: upright. Then `right` has the yaw, even straight up or down.
        let (yaw, roll) = if right.y.abs() < 1e-6 && up.y > -1e-6 {
            ((-right.z).atan2(right.x), 0.0)
        } else {
            let yaw = (-forward.x).atan2(-forward.z);
            let upright = Self::level(yaw)[0];
            (yaw, up.dot(upright).atan2(up.dot(upright.cross(forward))))
        };
        let pitch = forward.y.atan2(forward.x.hypot(forward.z));
        Self { from: camera.position, yaw, pitch, roll, distance, projection: camera.projection }
    }

    /// Right and forward on the horizon.
    fn level(yaw: f64) -> [DVec3; 2] {
        let (sin, cos) = yaw.sin_cos();
        [DVec3::new(cos, 0.0, -sin), DVec3::new(-sin, 0.0, -cos)]
    }

    /// Right, up and forward.
    fn axes(&self) -> [DVec3; 3] {
        let [right, heading] = Self::level(self.yaw);
        let (sin, cos) = self.pitch.sin_cos();
        let (forward, up) = (heading * cos + DVec3::Y * sin, DVec3::Y * cos - heading * sin);
        let (sin, cos) = self.roll.sin_cos();
        [right * cos - up * sin, up * cos + right * sin, forward]
    }

    fn pivot(&self) -> DVec3 {
        self.from + self.axes()[2] * self.distance
    }

    fn pose(&self) -> Pose {
        let [_, up, forward] = self.axes();
        // +y where that is the same: shorter flags.
        let up = if self.roll == 0.0 && self.pitch.abs() <= PITCH_LIMIT { DVec3::Y } else { up };
        // Far from the origin, two points that are close together leave little of the direction between them.
        let distance = self.distance.max(1e-8 * self.from.abs().max_element());
        Pose { from: self.from, at: self.from + forward * distance, up, projection: self.projection }
    }

    /// Turned on the spot by angles along the picture, to the right and down.
    fn turned(self, right: f64, down: f64) -> Self {
        let (sin, cos) = self.roll.sin_cos();
        let (right, down) = (right * cos - down * sin, right * sin + down * cos);
        let pitch = (self.pitch - down).clamp(-PITCH_LIMIT, PITCH_LIMIT);
        Self { yaw: (self.yaw - right) % TAU, pitch, ..self }
    }

    /// Moved to where the pivot is that point, at that distance.
    fn around(self, pivot: DVec3, distance: f64) -> Self {
        Self { from: pivot - self.axes()[2] * distance, distance, ..self }
    }

    fn shifted(self, by: DVec3) -> Self {
        Self { from: self.from + by, ..self }
    }
}
