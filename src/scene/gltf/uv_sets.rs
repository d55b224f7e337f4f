//! Which sets of texture coordinates a material needs: a file may have any number, a mesh of the scene has two.

use super::faults::Faults;
use crate::scene::Material;

/// Gives the textures of a material, whose `uv_set` is the file's, the places of those sets among the two that are
/// read, and returns which these are. A set that is 0 or 1 keeps its place. Textures of a third set are left out.
pub fn choose(material: &mut Material, place: &str, faults: &mut Faults) -> [u32; 2] {
    let mut chosen: [Option<u32>; 2] = [None; 2];
    let wanted: Vec<u32> = material.textures().map(|texture| texture.uv_set).collect();
    for &set in wanted.iter().filter(|set| **set < 2) {
        chosen[set as usize] = Some(set);
    }
    for &set in wanted.iter().filter(|set| **set >= 2) {
        if !chosen.contains(&Some(set))
            && let Some(free) = chosen.iter_mut().find(|slot| slot.is_none())
        {
            *free = Some(set);
        }
    }
    for slot in material.slots_mut() {
        let Some(texture) = slot else { continue };
        match chosen.iter().position(|set| *set == Some(texture.uv_set)) {
            Some(found) => texture.uv_set = found as u32,
            None => {
                let problem = format!(
                    "a texture uses TEXCOORD_{}, but others use two more sets, and a material has two",
                    texture.uv_set
                );
                faults.note(place, problem, "it is left out");
                *slot = None;
            }
        }
    }
    [chosen[0].unwrap_or(0), chosen[1].unwrap_or(1)]
}
