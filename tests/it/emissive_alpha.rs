//! Emitters that are there in part: light that is met by chance and light that is drawn agree on how much of them shines.

use glam::{Affine2, DVec3, Vec3};
use halfway::integrator::{Bdpt, Connections, LvcBpt, Method, Strategy, View};
use halfway::render::{RenderOptions, Renderer};
use halfway::scene::builtin::shapes;
use halfway::scene::{AlphaMode, Filter, Image, Material, Scene, Texture, TextureRef, Wrap};

use crate::bidirectional::{assert_same_as_path, double_sided_lamp, mean, renders};
use crate::gpu;
use crate::judge::{grey, horizontal, lamp, scene, spot_camera};
use crate::shots::options;
use crate::stats::Moments;

const BDPT_T1: Method = Method::Bdpt(Bdpt { light_tracing: true });
const LVCBPT: Method =
    Method::LvcBpt(LvcBpt { light_paths: Some(600), connections: Connections::even(2), light_tracing: true });

/// A square lamp above a point of the floor, always with a texture: one set of kernels for all.
pub fn lamp_of(alpha_mode: AlphaMode, alpha: f32, opacities: [u8; 2]) -> Scene {
    let texels = opacities.map(|opacity| [255, 255, 255, opacity]).to_vec();
    let reference = TextureRef { texture: 0, uv_set: 0, transform: Affine2::IDENTITY };
    let lamp = Material { alpha, alpha_mode, base_color_texture: Some(reference), ..lamp(1.0) };
    let mut scene = scene([(grey(0.5), horizontal(0.02, 0.0, true)), (lamp, horizontal(1.0, 1.0, false))]);
    scene.images.push(Image { name: "opacity".into(), width: 2, height: 1, texels });
    scene.textures.push(Texture { image: 0, wrap: [Wrap::Clamp; 2], filter: Filter::Nearest });
    scene
}

#[test]
fn emitters_shine_as_far_as_they_are_there() {
    // A quarter there everywhere; all there on one side of the point only.
    for (what, mut scene, share) in [
        ("blended", lamp_of(AlphaMode::Blend, 0.25, [255, 255]), 0.25),
        ("masked", lamp_of(AlphaMode::Mask { cutoff: 0.5 }, 1.0, [255, 100]), 0.5),
    ] {
        scene.cameras = vec![
            spot_camera(),
            shapes::looking_at("up", DVec3::new(0.0, 0.1, 0.0), DVec3::new(0.0, 1.0, 1e-4), 30.0),
        ];
        // As `c07_form_factors`.
        let lit = 0.5 * 0.239_456_470_460_773_5 * share;
        for method in [Method::Path, BDPT_T1, LVCBPT] {
            let base = RenderOptions {
                view: View { max_depth: Some(2), ..options([16, 16], 64).view },
                method,
                ..options([16, 16], 64)
            };
            for (camera, expected) in [(0, lit), (1, share)] {
                let pictures = renders(&scene, &RenderOptions { camera, ..base.clone() }, 0..8);
                let means: Moments = pictures.iter().map(|picture| mean(picture)).collect();
                let name = format!("{what}, {}, camera {camera}", method.name());
                println!(
                    "{name}: {:.5} +- {:.5} of it",
                    means.mean / expected,
                    means.standard_error() / expected
                );
                means.assert_mean(&name, expected, 2e-2);
            }
        }
        // By chance alone, by drawing a point of the lamp alone.
        let base = RenderOptions {
            view: View { max_depth: Some(2), ..options([16, 16], 128).view },
            method: BDPT_T1,
            ..options([16, 16], 128)
        };
        let mut renderer = Renderer::new(gpu::context(), &scene, base).expect("a renderer");
        for (s, t) in [(0, 3), (1, 2)] {
            let run = |seed| {
                renderer.restart(seed, Some(Strategy { s, t, weighted: false })).expect("a restart");
                renderer.run(|_| false).expect("a render");
                let picture = renderer.picture().expect("a picture");
                picture.rgb.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / 256.0
            };
            let means: Moments = (0..8).map(run).collect();
            println!("{what}, s = {s}: {:.5} +- {:.5} of it", means.mean / lit, means.standard_error() / lit);
            means.assert_mean(&format!("{what}, s = {s}, t = {t}"), lit, 3e-2);
        }
    }
}

/// A lamp that light passes, from the light's side too.
#[test]
fn a_translucent_lamp_agrees_with_path() {
    let mut scene = double_sided_lamp();
    scene.name = "translucent lamp".into();
    scene.materials[0].alpha = 0.4;
    scene.materials[0].alpha_mode = AlphaMode::Blend;
    scene.materials[0].base_color = Vec3::splat(0.5);
    assert_same_as_path(&scene, BDPT_T1, 8);
    assert_same_as_path(&scene, LVCBPT, 8);
}
