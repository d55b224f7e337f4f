//! Which of a scene's cameras a picture is seen by, and how that camera is moved: in the words of the command line, for
//! all who choose a camera.

use std::fmt;

use glam::DVec3;

use super::{Camera, Pose, Projection, Scene, ViewpointError};

/// A camera, and how it is moved. Displays as flags on a command line, quoted for a shell; parsed again they make the
/// same camera bit for bit. The default is the scene's first camera as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Which of the scene's cameras, by name or number.
    pub camera: Option<String>,
    /// World position to stand at instead, scene units; with `look_at`.
    pub look_from: Option<DVec3>,
    /// The point in the middle of the picture then, scene units.
    pub look_at: Option<DVec3>,
    /// The direction that is up in the picture then, of any length; `None`: +y.
    pub look_up: Option<DVec3>,
    /// Vertical field of view of a perspective camera, degrees; `None`: its own.
    pub fov: Option<f64>,
    /// Scene units from the bottom to the top of what an orthographic camera sees; `None`: its own.
    pub ortho_height: Option<f64>,
}

impl Viewpoint {
    /// Chooses a camera of the scene as it is: by name where that finds it, else by number. The default for the camera
    /// that stands in where the scene has none.
    pub fn naming(scene: &Scene, index: usize) -> Self {
        let cameras = scene.own_cameras();
        let stands_in = || *cameras == [Camera::framing(&scene.bounds())];
        let name = cameras.get(index).map(|camera| camera.name.as_str());
        let camera = match name {
            _ if cameras.is_empty() || stands_in() => None,
            // A dash would begin another argument.
            Some(name)
                if !name.starts_with('-')
                    && !name.contains(char::is_control)
                    && find(cameras, name) == Some(index) =>
            {
                Some(name.to_string())
            }
            _ => Some(index.to_string()),
        };
        Self { camera, ..Self::default() }
    }

    /// The scene's own camera that is asked for, before it is moved; one that frames the scene where it has none.
    ///
    /// # Errors
    /// No such camera.
    pub fn own(&self, scene: &Scene) -> Result<Camera, ViewpointError> {
        match (scene.own_cameras(), &self.camera) {
            ([], None) => Ok(Camera::framing(&scene.bounds())),
            (cameras, _) => Ok(cameras[self.own_index(scene)?].clone()),
        }
    }

    /// The same camera of the scene, moved to a pose.
    pub fn moved(&self, pose: &Pose) -> Self {
        let (fov, ortho_height) = match pose.projection {
            Projection::Perspective { yfov } => {
                let same = |degrees| Projection::perspective(degrees) == Some(pose.projection);
                (Some(shortest(f64::from(yfov).to_degrees(), same)), None)
            }
            Projection::Orthographic { ymag, .. } => {
                let same = |height: f64| (0.5 * height) as f32 == ymag;
                (None, Some(shortest(2.0 * f64::from(ymag), same)))
            }
        };
        Self {
            camera: self.camera.clone(),
            look_from: Some(pose.from),
            look_at: Some(pose.at),
            look_up: (pose.up != DVec3::Y).then_some(pose.up),
            fov,
            ortho_height,
        }
    }

    /// The pose that is asked for in place of that of `own`, with the projection of [`Viewpoint::projection`].
    ///
    /// # Errors
    /// As for the projection.
    pub fn pose(&self, own: &Camera) -> Result<Option<Pose>, ViewpointError> {
        let (Some(from), Some(at)) = (self.look_from, self.look_at) else { return Ok(None) };
        let up = self.look_up.unwrap_or(DVec3::Y);
        Ok(Some(Pose { from, at, up, projection: self.projection(own)? }))
    }

    /// The projection of `own`, changed as asked for.
    ///
    /// # Errors
    /// A setting of the other kind of projection, or out of its range.
    pub fn projection(&self, own: &Camera) -> Result<Projection, ViewpointError> {
        let camera = || own.name.clone();
        match (own.projection, self.fov, self.ortho_height) {
            (Projection::Orthographic { .. }, Some(_), _) => {
                Err(ViewpointError::NotPerspective { camera: camera() })
            }
            (Projection::Perspective { .. }, _, Some(_)) => {
                Err(ViewpointError::NotOrthographic { camera: camera() })
            }
            (_, Some(degrees), _) => {
                Projection::perspective(degrees).ok_or(ViewpointError::FieldOfView { degrees })
            }
            (projection, _, Some(height)) => {
                projection.with_height(height).ok_or(ViewpointError::Height { height })
            }
            (projection, None, None) => Ok(projection),
        }
    }

    /// The camera that this makes of one of the scene's.
    ///
    /// # Errors
    /// A setting of the other kind of projection or out of its range, points that leave no direction to look in.
    pub fn apply(&self, own: &Camera) -> Result<Camera, ViewpointError> {
        let name = moved_name(own);
        let Some(pose) = self.pose(own)? else {
            let projection = self.projection(own)?;
            let name = if projection == own.projection { own.name.clone() } else { name };
            return Ok(Camera { name, projection, ..own.clone() });
        };
        pose.camera(&name).ok_or_else(|| match pose.from == pose.at {
            true => ViewpointError::SamePoint,
            false => {
                let [up, from, at] = [pose.up, pose.from, pose.at].map(point);
                ViewpointError::NoUpright { up, from, at }
            }
        })
    }

    /// The index of the camera that is asked for. One that is moved is placed in the scene, beside its own; a scene that
    /// has none gets one that frames it, unless a certain one is asked for.
    ///
    /// # Errors
    /// No such camera, or what [`Viewpoint::apply`] refuses.
    pub fn choose(&self, scene: &mut Scene) -> Result<usize, ViewpointError> {
        if scene.own_cameras().is_empty() && self.camera.is_none() {
            // In front of one that was placed.
            scene.cameras.insert(0, Camera::framing(&scene.bounds()));
            log::warn!("the scene has no camera; one was placed to see all of it");
        }
        let index = self.own_index(scene)?;
        let camera = self.apply(&scene.cameras[index])?;
        Ok(if camera == scene.cameras[index] { index } else { scene.place_camera(camera) })
    }

    /// The flags one by one, as a program is given them.
    pub fn words(&self) -> Vec<String> {
        let points =
            [("--look-from", self.look_from), ("--look-at", self.look_at), ("--look-up", self.look_up)];
        let numbers = [("--fov", self.fov), ("--ortho-height", self.ortho_height)];
        let camera = self.camera.iter().map(|name| ("--camera", name.clone()));
        let points = points.into_iter().filter_map(|(flag, value)| Some((flag, point(value?))));
        let numbers = numbers.into_iter().filter_map(|(flag, value)| Some((flag, decimals(value?))));
        let pairs = camera.chain(points).chain(numbers);
        pairs.flat_map(|(flag, value)| [flag.to_string(), value]).collect()
    }

    /// The index of the scene's own camera that is asked for; by default the first, which there is.
    fn own_index(&self, scene: &Scene) -> Result<usize, ViewpointError> {
        let cameras = scene.own_cameras();
        let Some(wanted) = &self.camera else { return Ok(0) };
        if cameras.is_empty() {
            return Err(ViewpointError::NoCamera { wanted: wanted.clone() });
        }
        find(cameras, wanted).ok_or_else(|| {
            let list: Vec<String> =
                cameras.iter().enumerate().map(|(i, camera)| format!("{i} '{}'", camera.name)).collect();
            ViewpointError::UnknownCamera { wanted: wanted.clone(), list: list.join(", ") }
        })
    }
}

impl fmt::Display for Viewpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = |c: char| c.is_alphanumeric() || "_-+.,:/@%".contains(c);
        let quoted = |word: &String| match !word.is_empty() && word.chars().all(plain) {
            true => word.clone(),
            false => format!("'{}'", word.replace('\'', r"'\''")),
        };
        f.write_str(&self.words().iter().map(quoted).collect::<Vec<_>>().join(" "))
    }
}

/// The name of a camera that was one of the scene's.
pub fn moved_name(own: &Camera) -> String {
    format!("{} (moved)", own.name)
}

/// By name, else by number.
fn find(cameras: &[Camera], wanted: &str) -> Option<usize> {
    let by_name = cameras.iter().position(|camera| camera.name == wanted);
    by_name.or_else(|| wanted.parse().ok().filter(|&index| index < cameras.len()))
}

fn point(value: DVec3) -> String {
    value.to_array().map(decimals).join(",")
}

/// The shortest decimals that are read as the same number, with an exponent where it is very large or small.
fn decimals(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_string)
}

/// The number of fewest digits near `value` that is the `same`.
fn shortest(value: f64, same: impl Fn(f64) -> bool) -> f64 {
    let mut rounded = (0..17).filter_map(|digits| format!("{value:.digits$e}").parse().ok());
    rounded.find(|&number| same(number)).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Projection = Projection::Perspective { yfov: 0.7 };
    const PARALLEL: Projection = Projection::Orthographic { xmag: 0.3, ymag: 0.7 };

    fn own(name: &str, projection: Projection) -> Camera {
        Camera { name: name.into(), projection, ..Camera::framing(&Scene::default().bounds()) }
    }

    fn named(camera: &str) -> Viewpoint {
        Viewpoint { camera: Some(camera.into()), ..Viewpoint::default() }
    }

    fn looking(from: DVec3, at: DVec3) -> Viewpoint {
        Viewpoint { look_from: Some(from), look_at: Some(at), ..Viewpoint::default() }
    }

    #[test]
    fn a_camera_is_moved() {
        let mut scene = Scene { cameras: vec![own("a", LENS), own("b", PARALLEL)], ..Scene::default() };
        let before = scene.content_hash();
        assert_eq!(named("b").choose(&mut scene).unwrap(), 1);
        assert_eq!(scene.cameras.len(), 2, "nothing moved");

        let moved = looking(DVec3::new(-1.0, 2.0, 1e3), DVec3::new(-1.0, 2.0, 0.0));
        let moved = Viewpoint { look_up: Some(DVec3::Y * 3.0), fov: Some(90.0), ..moved };
        assert_eq!(moved.choose(&mut scene).unwrap(), 2);
        let camera = &scene.cameras[2];
        assert_eq!((camera.name.as_str(), camera.position), ("a (moved)", DVec3::new(-1.0, 2.0, 1e3)));
        assert_eq!(camera.forward, glam::Vec3::NEG_Z);
        assert_eq!(camera.projection, Projection::Perspective { yfov: std::f32::consts::FRAC_PI_2 });

        let taller = Viewpoint { ortho_height: Some(2.8), ..named("1") };
        assert_eq!(taller.choose(&mut scene).unwrap(), 2, "in place of the last that was placed");
        let camera = &scene.cameras[2];
        assert_eq!((camera.name.as_str(), camera.position), ("b (moved)", scene.cameras[1].position));
        assert_eq!(camera.projection, Projection::Orthographic { xmag: 0.6, ymag: 1.4 });
        assert_eq!(scene.content_hash(), before, "a model stays valid");
        assert!(named("2").choose(&mut scene).is_err(), "a placed camera has no number");
    }

    #[test]
    fn the_camera_that_stands_in_can_be_moved() {
        let mut scene = Scene::default();
        Viewpoint::default().choose(&mut scene).unwrap();
        let learnt = scene.content_hash();
        let mut scene = Scene::default();
        assert_eq!(looking(DVec3::Z * 5.0, DVec3::ZERO).choose(&mut scene).unwrap(), 1);
        assert_eq!((scene.cameras[1].name.as_str(), scene.content_hash()), ("framing (moved)", learnt));
        assert_eq!(Viewpoint::naming(&scene, 0), Viewpoint::default());
        let refused = named("a").choose(&mut Scene::default()).unwrap_err().to_string();
        assert!(refused.contains("leave the option out"), "{refused}");
    }

    #[test]
    fn what_makes_no_picture_is_refused() {
        let (fov, height) = (
            |degrees| Viewpoint { fov: Some(degrees), ..Viewpoint::default() },
            |units| Viewpoint { ortho_height: Some(units), ..Viewpoint::default() },
        );
        let from = DVec3::new(1.0, 2.0, 3.0);
        for (viewpoint, projection, says) in [
            (fov(40.0), PARALLEL, "give --ortho-height"),
            (height(4.0), LENS, "give --fov"),
            (fov(180.0), LENS, "below 180"),
            (fov(-3.0), LENS, "above 0"),
            (fov(f64::NAN), LENS, "above 0"),
            (height(0.0), PARALLEL, "positive"),
            (height(1e50), PARALLEL, "positive"),
            (looking(from, from), LENS, "same point"),
            (
                looking(from, from + DVec3::Y * 7.0),
                LENS,
                "from 1,2,3 at 1,9,3; give another direction by --look-up",
            ),
        ] {
            let refused = viewpoint.apply(&own("a", projection)).unwrap_err().to_string();
            assert!(refused.contains(says), "{viewpoint}: {refused}");
        }
    }

    #[test]
    fn cameras_are_named_so_that_they_are_found() {
        let names = ["front", "it's b", "front", "-5", "", "3"];
        let cameras = names.map(|name| own(name, LENS)).to_vec();
        let scene = Scene { cameras, ..Scene::default() };
        let lines = [0, 1, 2, 4].map(|index| Viewpoint::naming(&scene, index).to_string());
        assert_eq!(lines, ["--camera front", r"--camera 'it'\''s b'", "--camera 2", "--camera ''"]);
    }

    #[test]
    fn angles_come_back_in_few_digits() {
        for tenths in 1..1800 {
            let degrees = f64::from(tenths) / 10.0;
            let projection = Projection::perspective(degrees).unwrap();
            let pose = Pose { from: DVec3::Z, at: DVec3::ZERO, up: DVec3::Y, projection };
            assert_eq!(Viewpoint::default().moved(&pose).fov, Some(degrees));
        }
    }
}
