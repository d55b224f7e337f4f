//! The camera that a picture is seen by.

use clap::Args;
use glam::DVec3;

use super::InputError;
use super::parse::parse_point;
use crate::scene::{Scene, Viewpoint};

/// Which camera.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct CameraNameArgs {
    /// Which of the scene's cameras, by name or number (default: the first; one that sees the whole scene if it has none).
    #[arg(long, value_name = "CAMERA")]
    camera: Option<String>,
}

impl CameraNameArgs {
    /// The index of the camera that is asked for.
    ///
    /// # Errors
    /// As [`Viewpoint::choose`].
    pub fn choose(&self, scene: &mut Scene) -> Result<usize, InputError> {
        Ok(Viewpoint { camera: self.camera.clone(), ..Viewpoint::default() }.choose(scene)?)
    }
}

/// Which camera, and how it is moved.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct CameraArgs {
    #[command(flatten)]
    name: CameraNameArgs,
    /// Stand at this point instead, in scene units; the camera's projection stays, and a model of the scene stays valid.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_at", allow_hyphen_values = true)]
    look_from: Option<DVec3>,
    /// The point in the middle of the picture then.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_from", allow_hyphen_values = true)]
    look_at: Option<DVec3>,
    /// The direction that is up in the picture then (default: 0,1,0).
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_from", allow_hyphen_values = true)]
    look_up: Option<DVec3>,
    /// Vertical field of view of a perspective camera, in place of its own; with or without moving it.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    fov: Option<f64>,
    /// Scene units from the bottom to the top of what an orthographic camera sees, in place of its own; with or without
    /// moving it.
    #[arg(long, value_name = "UNITS", allow_hyphen_values = true)]
    ortho_height: Option<f64>,
}

impl CameraArgs {
    /// What is asked for.
    pub fn viewpoint(&self) -> Viewpoint {
        Viewpoint {
            camera: self.name.camera.clone(),
            look_from: self.look_from,
            look_at: self.look_at,
            look_up: self.look_up,
            fov: self.fov,
            ortho_height: self.ortho_height,
        }
    }

    /// The index of the camera that is asked for, placed in the scene if it is moved.
    ///
    /// # Errors
    /// As [`Viewpoint::choose`].
    pub fn choose(&self, scene: &mut Scene) -> Result<usize, InputError> {
        Ok(self.viewpoint().choose(scene)?)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use proptest::prelude::*;

    use super::*;
    use crate::scene::{Camera, Pose, Projection};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        camera: CameraArgs,
    }

    fn parse(words: &[String]) -> Result<Viewpoint, clap::Error> {
        Line::try_parse_from(std::iter::once("program").chain(words.iter().map(String::as_str)))
            .map(|line| line.camera.viewpoint())
    }

    fn words(line: &str) -> Vec<String> {
        line.split(' ').map(str::to_string).collect()
    }

    fn own(projection: Projection) -> Camera {
        Camera { name: "a".into(), projection, ..Camera::framing(&Scene::default().bounds()) }
    }

    const LENS: Projection = Projection::Perspective { yfov: 0.7 };
    const PARALLEL: Projection = Projection::Orthographic { xmag: 0.3, ymag: 0.7 };

    #[test]
    fn flags_are_read() {
        let line =
            "--camera b --look-from -1,2,1e3 --look-at 4,5,6 --look-up 0,3,-1 --fov 90 --ortho-height -2";
        let expected = Viewpoint {
            camera: Some("b".into()),
            look_from: Some(DVec3::new(-1.0, 2.0, 1e3)),
            look_at: Some(DVec3::new(4.0, 5.0, 6.0)),
            look_up: Some(DVec3::new(0.0, 3.0, -1.0)),
            fov: Some(90.0),
            ortho_height: Some(-2.0),
        };
        assert_eq!(parse(&words(line)).unwrap(), expected);
        for line in [
            "--look-from 1,2,3",
            "--look-at 1,2,3",
            "--look-up 0,1,0",
            "--look-from 1,2 --look-at 1,2,3",
            "--look-from 1,2,inf --look-at 1,2,3",
        ] {
            assert!(parse(&words(line)).is_err(), "{line}");
        }
    }

    /// Every `f32` in a stretch, and steps through all binades.
    #[test]
    fn angles_come_back_from_their_flags() {
        let stretch = 0.7f32.to_bits()..0.7f32.to_bits() + 20_000;
        let steps = (1..std::f32::consts::PI.to_bits()).step_by(54_321);
        for yfov in stretch.chain(steps).map(f32::from_bits) {
            let projection = Projection::Perspective { yfov };
            let pose = Pose { from: DVec3::Z, at: DVec3::ZERO, up: DVec3::Y, projection };
            let again = parse(&Viewpoint::default().moved(&pose).words()).unwrap();
            assert_eq!(again.projection(&own(LENS)).unwrap(), projection, "{yfov:e}: {again}");
        }
    }

    proptest! {
        #[test]
        fn a_pose_comes_back_from_its_flags(
            from in prop::array::uniform3(prop::num::f64::NORMAL | prop::num::f64::ZERO),
            at in prop::array::uniform3(-1e3..1e3f64),
            up in prop::option::of(prop::array::uniform3(-1.0..1.0f64)),
            near in any::<bool>(),
            lens in any::<bool>(),
            size in 1e-30..3.1f32,
        ) {
            let at = DVec3::from(at);
            let from = if near { at + DVec3::from(from.map(f64::sin)) } else { DVec3::from(from) };
            let own = own(if lens { LENS } else { PARALLEL });
            let projection = match lens {
                true => Projection::Perspective { yfov: size },
                false => PARALLEL.with_height(f64::from(size)).unwrap(),
            };
            let pose = Pose { from, at, up: up.map_or(DVec3::Y, DVec3::from), projection };
            let camera = pose.camera("a (moved)");
            let words = Viewpoint::default().moved(&pose).words();
            let again = parse(&words).unwrap();
            prop_assert_eq!(again.pose(&own).unwrap(), Some(pose), "{}", words.join(" "));
            // Floats are written so that no two look alike.
            let again = again.apply(&own).ok();
            prop_assert_eq!(format!("{again:?}"), format!("{camera:?}"), "{}", words.join(" "));
        }
    }
}
