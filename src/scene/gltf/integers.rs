//! Integers that exporters write as `5.0`: JSON has one kind of number, glTF and its readers have two.

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
    "wrapS",
    "wrapT",
];

/// Objects in which every property is an index.
const OBJECTS_OF_INTEGERS: &[&str] = &["attributes", "targets"];

/// Where a document has fractions in place of integers.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// The place of the first one.
    pub first: String,
    pub count: usize,
}

/// Makes integers of whole numbers that are written with a fraction where an integer is due. What stands in `extras` is
/// left alone.
pub fn repair(document: &mut Value) -> Repaired {
    let mut repaired = Repaired::default();
    walk(document, &mut String::new(), [false, false], &mut repaired);
    repaired
}

/// `due`: numbers that stand here, or in a list, are integers; and those of an object that stands here. `place` is as
/// it was afterwards. The parser has limited the depth.
fn walk(value: &mut Value, place: &mut String, due: [bool; 2], repaired: &mut Repaired) {
    let length = place.len();
    match value {
        Value::Object(members) => {
            for (name, member) in members.iter_mut().filter(|(name, _)| *name != "extras") {
                if !place.is_empty() {
                    place.push('.');
                }
                place.push_str(name);
                let name = name.as_str();
                let due = [due[1] || INTEGERS.contains(&name), OBJECTS_OF_INTEGERS.contains(&name)];
                walk(member, place, due, repaired);
                place.truncate(length);
            }
        }
        Value::Array(items) => {
            for (index, item) in items.iter_mut().enumerate() {
                // A list of plain numbers, such as a matrix, has nothing to look for.
                if due[0] || !item.is_number() {
                    place.push_str(&format!("[{index}]"));
                    walk(item, place, due, repaired);
                    place.truncate(length);
                }
            }
        }
        Value::Number(number) if due[0] => {
            if let Some(integer) = whole(number) {
                if repaired.count == 0 {
                    repaired.first.clone_from(place);
                }
                repaired.count += 1;
                *number = integer.into();
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
