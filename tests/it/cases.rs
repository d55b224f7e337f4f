//! Files that people brought, as small cases: what each of them shows, and what is said about it (`tests/cases`).

use std::path::{Path, PathBuf};

use halfway::render::{RenderOptions, Renderer};
use halfway::scene::gltf::{LoadOptions, load};
use halfway::scene::{Environment, Viewpoint};
use serde::Deserialize;

use crate::gpu;
use crate::shots::{Shot, options};
use crate::specialised::everything;

/// One row of `table.json`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    file: PathBuf,
    /// A uniform white environment lights it.
    #[serde(default = "yes")]
    env: bool,
    /// Middle pixel and mean of 33x33 pixels.
    picture: Option<Expected>,
    /// A part of each warning, in their order.
    #[serde(default)]
    warnings: Vec<String>,
    /// A part of the error of a file that is refused.
    error: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    centre: [f64; 3],
    mean: [f64; 3],
}

fn yes() -> bool {
    true
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases")
}

pub fn white() -> Environment {
    Environment {
        name: "white".into(),
        width: 16,
        height: 8,
        texels: vec![[1.0; 3]; 16 * 8],
        scale: 1.0,
        rotation: 0.0,
    }
}

impl Case {
    /// What is not as it should be.
    fn faults(&self) -> Vec<String> {
        let mut scene = match (load(&folder().join(&self.file), &LoadOptions::default()), &self.error) {
            (Ok(scene), None) => scene,
            (Ok(_), Some(part)) => return vec![format!("is not refused ({part})")],
            (Err(error), Some(part)) if error.to_string().contains(part.as_str()) => return Vec::new(),
            (Err(error), _) => return vec![format!("is refused: {error}")],
        };
        if self.env {
            scene.environment = Some(white());
        }
        let camera = Viewpoint::default().choose(&mut scene).unwrap();
        let mut faults = Vec::new();
        let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        let said = |(warning, part): (&String, &String)| warning.contains(part.as_str());
        if warnings.len() != self.warnings.len() || !warnings.iter().zip(&self.warnings).all(said) {
            faults.push(format!("warns of {warnings:?}"));
        }
        // Kernels for everything: compiled once for all of the table. That kernels of less show the same, s01 proves.
        let options = RenderOptions { camera, features: Some(everything()), ..options([33, 33], 32) };
        let mut renderer = Renderer::new(gpu::context(), &scene, options).unwrap();
        renderer.run(|_| false).unwrap();
        let shot = Shot { picture: renderer.picture().unwrap(), report: renderer.report().unwrap() };
        if shot.report.non_finite != 0 {
            faults.push(format!("{} samples are not finite", shot.report.non_finite));
        }
        let expected = self.picture.as_ref().expect("a picture or an error");
        for channel in 0..3 {
            let places = [
                ("centre", shot.part(channel, [16, 16], [1, 1]), expected.centre[channel], 0.02),
                ("mean", shot.channel(channel), expected.mean[channel], 0.002),
            ];
            for (place, found, expected, rounding) in places {
                if (found.mean - expected).abs() > 6.0 * found.error + rounding * expected.max(1.0) {
                    faults.push(format!("{place} {channel}: {found:?}, right is {expected}"));
                }
            }
        }
        faults
    }
}

/// Each file is loaded, or refused, as the table says, and looks as it should.
#[test]
fn r10_files_that_people_bring() {
    let table = std::fs::read_to_string(folder().join("table.json")).unwrap();
    let table: Vec<Case> = serde_json::from_str(&table).unwrap();
    let mut listed: Vec<&PathBuf> = table.iter().map(|case| &case.file).collect();
    listed.sort();
    let mut present = Vec::new();
    for part in ["faults", "right"] {
        for entry in std::fs::read_dir(folder().join(part)).unwrap() {
            let name = entry.unwrap().file_name();
            if Path::new(&name).extension().is_some_and(|end| end == "gltf" || end == "glb") {
                present.push(Path::new(part).join(name));
            }
        }
    }
    present.sort();
    assert!(listed.into_iter().eq(&present), "the table lists other files than the folders hold");

    let wrong: Vec<String> = table
        .iter()
        .flat_map(|case| {
            let name = case.file.display();
            case.faults().into_iter().map(move |fault| format!("{name}: {fault}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
