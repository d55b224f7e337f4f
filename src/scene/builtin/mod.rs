//! Built-in scenes, as code: the ones with a known answer that tests are made of, and small classics to look at.
//!
//! The command line takes `builtin:NAME` where it takes a file. All surfaces are Lambert unless stated otherwise.

pub mod closed;
pub mod lamps;
pub mod rooms;
pub mod shapes;
mod stage;
pub mod surfaces;

use crate::scene::Scene;

/// Makes a scene with its default parameters.
type Maker = fn() -> Scene;

/// The built-in scenes: name, maker.
const SCENES: &[(&str, Maker)] = &[
    ("cornell", rooms::cornell),
    ("door", rooms::door),
    ("spheres", surfaces::spheres),
    ("glass-slab", || surfaces::glass_slab(1.5)),
    ("bumpy-plane", || surfaces::bumpy_plane(1.2)),
    ("furnace-sphere", || closed::furnace_sphere(0.5, 1.0, 3)),
    ("furnace-box", || closed::furnace_box(0.5, 1.0)),
    ("plates", closed::plates),
    ("many-lights", || lamps::many_lights(1000, [-10.0, 10.0])),
    ("three-lights", lamps::three_lights),
];

/// The names that [`builtin`] knows, in the order in which they are shown to users.
pub const NAMES: [&str; SCENES.len()] = {
    let mut names = [""; SCENES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = SCENES[i].0;
        i += 1;
    }
    names
};

/// The built-in scene of that name, `None` for a name that is not in [`NAMES`].
pub fn builtin(name: &str) -> Option<Scene> {
    SCENES.iter().find(|&&(known, _)| known == name).map(|&(_, make)| make())
}
