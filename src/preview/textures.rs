//! The pictures of the window as textures, made again where what they show has changed.

use egui::{ColorImage, Context, TextureFilter, TextureHandle, TextureOptions};

use super::display::{self, Look};
use super::panel::Split;
use super::snapshot::Snapshot;
use crate::film::Picture;

/// See the module.
#[derive(Default)]
pub struct Textures {
    pub picture: Option<TextureHandle>,
    /// The other side of a split.
    pub beside: Option<TextureHandle>,
    /// The number of the snapshot, and how it is shown.
    made_of: Option<(u64, Look, Split)>,
}

impl Textures {
    /// Shows the snapshot; before the first picture there is nothing to show.
    pub fn update(
        &mut self,
        context: &Context,
        snapshot: &Snapshot,
        look: Look,
        split: Split,
        reference: Option<&Picture>,
    ) {
        let made_of = (snapshot.number, look, split);
        if self.made_of == Some(made_of) || snapshot.picture.rgb.is_empty() {
            return;
        }
        let shown = || {
            display::image(snapshot, &look, reference).or_else(|| display::radiance(&snapshot.picture, &look))
        };
        let image = display::in_own_threads(shown);
        let other = match split {
            Split::None => None,
            Split::Reference => reference,
            Split::Slot(slot) => {
                snapshot.beside.as_ref().filter(|beside| beside.0 == slot).map(|beside| &*beside.1)
            }
        };
        let beside = other.and_then(|picture| display::in_own_threads(|| display::radiance(picture, &look)));
        set(&mut self.picture, context, "picture", image);
        set(&mut self.beside, context, "beside", beside);
        self.made_of = Some(made_of);
    }
}

fn set(texture: &mut Option<TextureHandle>, context: &Context, name: &str, image: Option<ColorImage>) {
    let options = TextureOptions { magnification: TextureFilter::Nearest, ..TextureOptions::LINEAR };
    match (texture.as_mut(), image) {
        (Some(texture), Some(image)) => texture.set(image, options),
        (None, Some(image)) => *texture = Some(context.load_texture(name, image, options)),
        (_, None) => *texture = None,
    }
}
