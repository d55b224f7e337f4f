//! glTF files made in code: a document, its binary data, and the containers they travel in.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use halfway::scene::gltf::{LoadOptions, load_slice};
use halfway::scene::{Scene, SceneError};
use serde_json::{Value, json};

pub const U8: u64 = 5121;
pub const I8: u64 = 5120;
pub const I16: u64 = 5122;
pub const U16: u64 = 5123;
pub const U32: u64 = 5125;
pub const F32: u64 = 5126;

/// A glTF file in the making. The document has no buffer until it is written.
#[derive(Clone)]
pub struct GltfFile {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl GltfFile {
    /// No nodes, no meshes.
    pub fn empty() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "nodes": [], "meshes": [], "accessors": [], "bufferViews": [],
        });
        Self { json, bin: Vec::new() }
    }

    /// One node with one mesh of one triangle: (0,0,0), (1,0,0), (0,1,0).
    pub fn triangle() -> Self {
        let mut file = Self::empty();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        file.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
        file.push("nodes", json!({"mesh": 0}));
        file
    }

    /// Appends to a root array; returns the index.
    pub fn push(&mut self, array: &str, value: Value) -> usize {
        if self.json.get(array).is_none() {
            self.json[array] = json!([]);
        }
        let items = self.json[array].as_array_mut().expect("a root array");
        items.push(value);
        items.len() - 1
    }

    /// A buffer view over new bytes, which begin at a multiple of four.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// A packed accessor over new bytes.
    pub fn accessor(&mut self, bytes: &[u8], component: u64, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    /// A packed accessor of `f32`.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let lanes = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, F32, kind, values.len() / lanes)
    }

    /// Gives the first primitive of mesh 0 an attribute.
    pub fn attribute(&mut self, name: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    /// Gives the first primitive of mesh 0 a material, which becomes material 0.
    pub fn material(&mut self, material: Value) {
        self.json["materials"] = json!([material]);
        self.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    }

    /// Image and texture over the bytes of a picture; returns the texture.
    pub fn texture(&mut self, picture: &[u8]) -> usize {
        let view = self.view(picture);
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}))
    }

    /// The document with the binary data as a data: URI.
    pub fn gltf(&self) -> Vec<u8> {
        self.with_buffer(Some(format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bin))))
    }

    /// The document with its buffer at `uri`, or without one.
    pub fn with_buffer(&self, uri: Option<String>) -> Vec<u8> {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{"byteLength": self.bin.len()}]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = json!(uri);
            }
        }
        json.to_string().into_bytes()
    }

    /// The file as GLB.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.with_buffer(None);
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut glb = b"glTF".to_vec();
        for word in [2, 28 + json.len() + bin.len(), json.len(), 0x4E4F_534A] {
            glb.extend((word as u32).to_le_bytes());
        }
        glb.extend(json);
        for word in [bin.len() as u32, 0x004E_4942] {
            glb.extend(word.to_le_bytes());
        }
        glb.extend(bin);
        glb
    }

    /// Loads the file with its data embedded.
    pub fn load(&self) -> Result<Scene, SceneError> {
        load_slice(&self.gltf(), None, &LoadOptions::default())
    }

    /// Loads a file that must be right.
    pub fn scene(&self) -> Scene {
        self.load().expect("a file that is right")
    }

    /// The code of the fault for which the file is refused where it is read strictly.
    pub fn fault(&self) -> &'static str {
        code(load_slice(&self.gltf(), None, &strict()))
    }

    /// Loads a file that has one fault, of `part`: strictly it is refused, else it is a warning, the only one.
    pub fn tolerated(&self, part: &str) -> Scene {
        assert_ne!(self.fault(), "no fault", "{part}");
        let scene = self.load().unwrap_or_else(|error| panic!("{part}: {error}"));
        assert_eq!(scene.warnings.len(), 1, "{part}: {:?}", scene.warnings);
        assert!(scene.warnings[0].part.starts_with(part), "{part}: {}", scene.warnings[0]);
        scene
    }

    /// Writes `scene.gltf` and `scene.bin` into a folder.
    pub fn write(&self, folder: &Path) -> std::path::PathBuf {
        std::fs::write(folder.join("scene.bin"), &self.bin).expect("a writable folder");
        let path = folder.join("scene.gltf");
        std::fs::write(&path, self.with_buffer(Some("scene.bin".into()))).expect("a writable folder");
        path
    }
}

/// Any fault is an error.
pub fn strict() -> LoadOptions {
    LoadOptions { strict: true, ..LoadOptions::default() }
}

/// The code of a fault, or the variant's name where it has none; faults of environments do not concern glTF.
pub fn code(result: Result<Scene, SceneError>) -> &'static str {
    match result {
        Ok(_) => "no fault",
        Err(SceneError::Invalid { code, .. } | SceneError::Container { code, .. }) => code,
        Err(SceneError::Read { .. }) => "read",
        Err(SceneError::Json { .. }) => "json",
        Err(SceneError::Version { .. }) => "version",
        Err(SceneError::Uri { .. }) => "uri",
        Err(SceneError::Extensions { .. }) => "extensions",
        Err(SceneError::Limit { .. }) => "limit",
        Err(SceneError::Image { .. }) => "image",
        Err(_) => "a fault that no glTF file has",
    }
}

/// A picture encoded as PNG, JPEG or WebP.
pub fn encode(picture: &image::DynamicImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("a picture that can be encoded");
    bytes.into_inner()
}
