//! Structs that stand on both sides. WGSL is the law; the integration test `layout` compares every struct here
//! with the WGSL struct of the same name, field by field.

/// Name, offset and size in bytes of a field.
pub type Field = (&'static str, usize, usize);

/// A `#[repr(C)]` plain-old-data struct with the table of its fields.
macro_rules! device_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $type,)* }

        impl $name {
            /// The fields as the host lays them out.
            pub const FIELDS: &'static [Field] = &[
                $((stringify!($field), std::mem::offset_of!($name, $field), std::mem::size_of::<$type>()),)*
            ];
        }
    };
}

device_struct! {
    /// A triangle as the traversal reads it. Vertices are sorted by their bit patterns, so that two triangles
    /// compute a shared edge from the same numbers in the same order (numerics.md, N-05).
    pub struct Triangle {
        pub v0: [f32; 3],
        /// Material index in the low 24 bits, `TRIANGLE_*` flags above.
        pub material_flags: u32,
        pub v1: [f32; 3],
        /// Index into `lights` plus one; 0 for a triangle that does not emit.
        pub light: u32,
        pub v2: [f32; 3],
        /// Index of the triangle in the scene's order.
        pub scene_index: u32,
    }
}

/// The sorted vertices run clockwise seen from the front.
pub const TRIANGLE_FLIPPED: u32 = 1 << 24;
/// The material has an alpha mask or blends.
pub const TRIANGLE_ALPHA: u32 = 1 << 25;

device_struct! {
    /// What changes from batch to batch: which samples of which pixels a batch holds.
    pub struct Batch {
        pub width: u32,
        pub height: u32,
        /// First pixel of the batch (row-major index) and how many pixels.
        pub first_pixel: u32,
        pub pixel_count: u32,
        /// First sample index of the batch and how many samples a pixel.
        pub first_sample: u32,
        pub sample_count: u32,
        pub seed: u32,
        /// Paths end after this many surface vertices.
        pub max_depth: u32,
    }
}

device_struct! {
    /// The camera in normalised scene space. A film point (x, y) in [0,1]^2 (y down) looks from
    /// `origin + x * origin_dx + y * origin_dy` along `direction + x * direction_dx + y * direction_dy`.
    pub struct Camera {
        pub origin: [f32; 3],
        pub pad0: u32,
        pub origin_dx: [f32; 3],
        pub pad1: u32,
        pub origin_dy: [f32; 3],
        pub pad2: u32,
        pub direction: [f32; 3],
        pub pad3: u32,
        pub direction_dx: [f32; 3],
        pub pad4: u32,
        pub direction_dy: [f32; 3],
        pub pad5: u32,
    }
}

device_struct! {
    /// A path waiting for its next surface: the ray and what it carries.
    pub struct PathRay {
        pub origin: [f32; 3],
        /// Index of the sample in the batch.
        pub path: u32,
        /// Unit direction.
        pub direction: [f32; 3],
        /// Density of `direction` (solid angle, roulette included); 0 when no light sampling could have made it
        /// (camera rays, delta lobes).
        pub pdf_solid: f32,
        pub throughput: [f32; 3],
        /// Number of surface vertices so far in the low 16 bits; above them the material index plus one of the
        /// volume the ray starts in, 0 for none.
        pub depth_medium: u32,
    }
}

device_struct! {
    /// Where a ray ends. Barycentrics belong to `v1` and `v2` of the stored (sorted) triangle.
    pub struct Hit {
        /// Distance in units of the ray direction's length.
        pub t: f32,
        /// Index into `triangles`, `NO_HIT` for none.
        pub triangle: u32,
        pub b1: f32,
        pub b2: f32,
    }
}
