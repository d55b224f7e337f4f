//! Integers of the document: those that exporters write as `5.0`, since JSON has one kind of number and glTF two; and
//! those that `gltf::json` would cut to 32 bits without a word.

use serde_json::{Number, Value};

/// Properties that hold an index, a count, a size in bytes or a code, or a list of such.
const INTEGERS: &[&str] = &[
    "buffer",
    "bufferView",
    "byteLength",
    "byteOffset",
    "byteStride",
    "camera",
    "children",
    "componentType",
    "count",
    "index",
    "indices",
    "input",
    "inverseBindMatrices",
    "joints",
    "light",
    "magFilter",
    "material",
    "mesh",
    "minFilter",
    "mode",
    "node",
    "nodes",
    "output",
    "sampler",
    "scene",
    "skeleton",
    "skin",
    "source",
    "texCoord",
    "variants",
    "wrapS",
    "wrapT",
];

/// Those among them that are sizes, and have 64 bits.
const SIZES: &[&str] = &["byteLength", "byteOffset", "byteStride", "count"];

/// What stands in the document for an index or a code that 32 bits do not hold: more than any list has. The largest
/// number of 32 bits is left out, since `gltf::json` takes it for an absent image.
pub const BEYOND: u32 = u32::MAX - 1;

/// Objects in which every property is an index.
const OBJECTS_OF_INTEGERS: &[&str] = &["attributes", "targets"];

/// Where a document has fractions in place of integers.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// The place of the first one.
    pub first: String,
    pub count: usize,
}

/// Makes integers of whole numbers that are written with a fraction where an integer is due, and [`BEYOND`] of those
/// that are too large. What stands in `extras` is left alone.
pub fn repair(document: &mut Value) -> Repaired {
    let mut repaired = Repaired::default();
    walk(document, &mut String::new(), Due::default(), &mut repaired);
    repaired
}

/// What numbers have to be.
#[derive(Clone, Copy, Default)]
struct Due {
    /// Those that stand here, or in a list.
    integers: bool,
    /// They have 32 bits.
    narrow: bool,
    /// Those of an object that stands here: indices.
    members: bool,
}

/// `place` is as it was afterwards. The parser has limited the depth.
fn walk(value: &mut Value, place: &mut String, due: Due, repaired: &mut Repaired) {
    let length = place.len();
    match value {
        Value::Object(members) => {
            for (name, member) in members.iter_mut().filter(|(name, _)| *name != "extras") {
                if !place.is_empty() {
                    place.push('.');
                }
                place.push_str(name);
                let name = name.as_str();
                let due = Due {
                    integers: due.members || INTEGERS.contains(&name),
                    narrow: !SIZES.contains(&name),
                    members: OBJECTS_OF_INTEGERS.contains(&name),
                };
                walk(member, place, due, repaired);
                place.truncate(length);
            }
        }
        Value::Array(items) => {
            for (index, item) in items.iter_mut().enumerate() {
                // A list of plain numbers, such as a matrix, has nothing to look for.
                if due.integers || !item.is_number() {
                    place.push_str(&format!("[{index}]"));
                    walk(item, place, due, repaired);
                    place.truncate(length);
                }
            }
        }
        Value::Number(number) if due.integers => {
            if let Some(integer) = whole(number) {
                if repaired.count == 0 {
                    repaired.first.clone_from(place);
                }
                repaired.count += 1;
                *number = integer.into();
            }
            if due.narrow && number.as_u64().is_some_and(|index| index >= u64::from(BEYOND)) {
                *number = BEYOND.into();
            }
        }
        _ => {}
    }
}

/// The integer that a fraction stands for, as far as fractions hold integers exactly.
fn whole(number: &Number) -> Option<u64> {
    const LARGEST: f64 = (1_u64 << f64::MANTISSA_DIGITS) as f64;
    let value = number.as_f64().filter(|_| number.is_f64())?;
    (value.fract() == 0.0 && (0.0..=LARGEST).contains(&value)).then_some(value as u64)
}
