//! The document of a glTF 2.0 file: `gltf::json::Root`, and beside it what that type cannot hold as the file has it.
//!
//! Nothing here is validated beyond its shape; each index is looked up through [`Document::get`].

use std::collections::HashMap;
use std::ops::Deref;

use gltf::json::{Index, Root};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::integers::BEYOND;
use super::parts::{Listed, Morph, Transform};
use super::sieve;
use crate::scene::SceneError;

/// The root object. Parts that are faulty are empty there.
#[derive(Debug)]
pub struct Document {
    root: Root,
    /// Of each node.
    pub transforms: Vec<Transform>,
    /// Of each mesh.
    pub morphs: Vec<Morph>,
    /// What is wrong, by the place of the part.
    faulty: HashMap<String, String>,
}

impl Deref for Document {
    type Target = Root;

    fn deref(&self) -> &Root {
        &self.root
    }
}

impl Document {
    /// Reads the document from its JSON, of which `integers::repair` has made integers of what has to be some.
    ///
    /// # Errors
    /// [`SceneError::Json`] where the root, a node, a scene or a buffer has another shape than glTF prescribes. What is
    /// wrong with other parts is an error of [`Self::get`].
    pub fn new(mut value: Value) -> Result<Self, SceneError> {
        sieve::tidy(&mut value);
        let mut faulty = HashMap::new();
        let morphs = sieve::faulty_parts(&mut value, &mut faulty);
        let malformed = |cause| SceneError::Json { cause };
        let transforms = match value.get("nodes") {
            Some(nodes) => Vec::deserialize(nodes).map_err(malformed)?,
            None => Vec::new(),
        };
        let root = Root::deserialize(value).map_err(malformed)?;
        Ok(Self { root, transforms, morphs, faulty })
    }

    /// The part that `index` refers to; `from` names the place of the reference.
    ///
    /// # Errors
    /// A part that is not there, or that has another shape than glTF prescribes.
    pub fn get<T: Listed>(&self, index: Index<T>, from: &str) -> Result<&T, SceneError> {
        let items = T::list(&self.root);
        let item = at(items, index, from)?;
        self.whole(&format!("{}[{}]", T::LIST, index.value()))?;
        Ok(item)
    }

    /// The names of the file's variants.
    pub fn variants(&self) -> Vec<String> {
        let extensions = self.root.extensions.as_ref();
        let list = extensions.and_then(|extensions| extensions.khr_materials_variants.as_ref());
        list.into_iter().flat_map(|list| &list.variants).map(|variant| variant.name.clone()).collect()
    }

    /// Says what is wrong with the shape of the part at `place`.
    pub fn whole(&self, place: &str) -> Result<(), SceneError> {
        match self.faulty.get(place) {
            None => Ok(()),
            Some(detail) => {
                Err(SceneError::invalid(place, "TYPE_MISMATCH", format!("it cannot be read: {detail}")))
            }
        }
    }
}

/// Element `index` of a list that goes with the root's list of `T`, or the error that names both and the place of the
/// reference.
pub fn at<'a, T: Listed, U>(items: &'a [U], index: Index<T>, from: &str) -> Result<&'a U, SceneError> {
    items.get(index.value()).ok_or_else(|| {
        let (list, count) = (T::LIST, items.len());
        let detail = if index.value() == BEYOND as usize {
            format!("refers to {list} by an index that 32 bits do not hold, but there are only {count}")
        } else {
            format!("refers to {list}[{}], but there are only {count}", index.value())
        };
        SceneError::invalid(from, "UNRESOLVED_REFERENCE", detail)
    })
}

/// Reads an extension object for which `gltf::json` has no type; `None` where it is absent.
pub fn extension<T: DeserializeOwned>(
    extensions: Option<&Map<String, Value>>,
    name: &str,
    from: &str,
) -> Result<Option<T>, SceneError> {
    let Some(value) = extensions.and_then(|extensions| extensions.get(name)) else { return Ok(None) };
    T::deserialize(value).map(Some).map_err(|error| {
        SceneError::invalid(from, "TYPE_MISMATCH", format!("cannot read extension {name}: {error}"))
    })
}
