//! Texture lookup as glTF defines it.

use glam::{DVec2, DVec4, Vec2};
use halfway::scene::{Filter, Scene, TextureRef, Wrap};

/// The linear value of a texture at the texture coordinates of its set. `srgb`: the slot's RGB is encoded so.
pub fn lookup(scene: &Scene, slot: &TextureRef, uv: Vec2, srgb: bool) -> DVec4 {
    let texture = &scene.textures[slot.texture as usize];
    let image = &scene.images[texture.image as usize];
    let uv = slot.transform.transform_point2(uv).as_dvec2();
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    let texel = |x: f64, y: f64| {
        let column = wrap(x, size.x, texture.wrap[0]) as usize;
        let row = wrap(y, size.y, texture.wrap[1]) as usize;
        let value = image.texels[row * image.width as usize + column].map(|byte| f64::from(byte) / 255.0);
        let decode = |c: f64| if srgb { srgb_to_linear(c) } else { c };
        DVec4::new(decode(value[0]), decode(value[1]), decode(value[2]), value[3])
    };
    match texture.filter {
        Filter::Nearest => texel((uv.x * size.x).floor(), (uv.y * size.y).floor()),
        Filter::Linear => {
            let at = uv * size - 0.5;
            let corner = at.floor();
            let share = at - corner;
            let row = |y: f64| texel(corner.x, y).lerp(texel(corner.x + 1.0, y), share.x);
            row(corner.y).lerp(row(corner.y + 1.0), share.y)
        }
    }
}

fn wrap(at: f64, size: f64, mode: Wrap) -> f64 {
    match mode {
        Wrap::Repeat => at.rem_euclid(size),
        Wrap::Clamp => at.clamp(0.0, size - 1.0),
        Wrap::Mirror => {
            let at = at.rem_euclid(2.0 * size);
            if at < size { at } else { 2.0 * size - 1.0 - at }
        }
    }
}

fn srgb_to_linear(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
