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
    /// compute a shared edge from the same numbers in the same order (N-05 in docs/tests.md).
    pub struct Triangle {
        pub v0: [f32; 3],
        /// Material index in the low 24 bits, `TRIANGLE_*` flags above.
        pub material_flags: u32,
        pub v1: [f32; 3],
        /// Index into `lights` plus one; 0 for a triangle that does not emit.
        pub light: u32,
        pub v2: [f32; 3],
        /// Index into `covers`; 0 where nothing of the triangle's plane is in front of it.
        pub cover: u32,
    }
}

/// The sorted vertices run clockwise seen from the front.
pub const TRIANGLE_FLIPPED: u32 = 1 << 24;
/// The material has an alpha mask or blends.
pub const TRIANGLE_ALPHA: u32 = 1 << 25;
/// The camera looks through the triangle's back.
pub const TRIANGLE_CULLED: u32 = 1 << 26;

/// In the tree of the scene: an instance, whose index is in `light`.
pub const TRIANGLE_INSTANCE: u32 = 1 << 27;

device_struct! {
    /// A mesh in one of its places.
    pub struct Instance {
        /// Columns of the linear part, from the mesh's space to unit space.
        pub x: [f32; 3],
        /// Of the mesh's tree.
        pub root: u32,
        pub y: [f32; 3],
        /// What the numbers of its triangles are beyond their indices.
        pub shift: u32,
        pub z: [f32; 3],
        /// -1 of a mirror image, or 1.
        pub handedness: f32,
        pub origin: [f32; 3],
        /// The largest coordinate of any of its points in unit space.
        pub reach: f32,
        /// What rounding leaves out of `origin`.
        pub origin_rest: [f32; 3],
        pub pad0: u32,
        /// Columns of the inverse.
        pub inverse_x: [f32; 3],
        pub pad1: u32,
        pub inverse_y: [f32; 3],
        pub pad2: u32,
        pub inverse_z: [f32; 3],
        pub pad3: u32,
    }
}

device_struct! {
    /// How triangles of instances are numbered.
    pub struct InstanceNumbers {
        pub first: u32,
        pub block_bits: u32,
    }
}

device_struct! {
    /// Which samples of which pixels a batch holds.
    pub struct Batch {
        pub connections: [u32; 3],
        pub hit_scale: f32,
        pub density_scales: [f32; 3],
        pub width: u32,
        pub height: u32,
        pub crop_x: u32,
        pub crop_y: u32,
        pub crop_width: u32,
        pub crop_height: u32,
        pub crop_stride: u32,
        pub first_pixel: u32,
        pub pixel_count: u32,
        pub first_sample: u32,
        pub sample_count: u32,
        pub seed: u32,
        pub max_depth: u32,
        pub light_seed: u32,
        pub first_light_path: u32,
        pub light_path_count: u32,
        pub camera_paths: f32,
        pub only_s: u32,
        pub only_t: u32,
        pub weighted: u32,
        pub subspaces: u32,
        pub splat_scale: f32,
        pub records: u32,
        pub first_record: u32,
        pub vertices_per_path: f32,
    }
}

/// In the place of a strategy's number of vertices: all strategies.
pub const EVERY_STRATEGY: u32 = u32::MAX;
/// In [`Hit::triangle`] where a ray leaves the scene: `bind/accel.wgsl`.
pub const NO_TRIANGLE: u32 = u32::MAX;
/// Samples of a pixel that belong together, counted from the first.
pub const SAMPLES_A_GROUP: u32 = 8;

device_struct! {
    /// The camera in normalised scene space. A film point (x, y) in [0,1]^2 (y down) looks from
    /// `origin + x * origin_dx + y * origin_dy` along `direction + x * direction_dx + y * direction_dy`.
    pub struct Camera {
        pub origin: [f32; 3],
        /// Distance from the camera to where its rays start.
        pub before: f32,
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
        /// Index into `triangles`, `NO_TRIANGLE` for none.
        pub triangle: u32,
        pub b1: f32,
        pub b2: f32,
    }
}

device_struct! {
    /// A connection waiting for its visibility test.
    pub struct ShadowRay {
        pub origin: [f32; 3],
        /// A connection slot of `radiance`, or a pixel of `splats`.
        pub slot: u32,
        pub direction: [f32; 3],
        pub t_max: f32,
        pub contribution: [f32; 3],
        pub depth: u32,
    }
}

device_struct! {
    /// Lengths of queues and totals over the render (low word, high word).
    pub struct Counts {
        pub paths_in: u32,
        pub paths_out: u32,
        pub shadow_in: u32,
        pub shadow_out: u32,
        pub closest_total: [u32; 2],
        pub shadow_total: [u32; 2],
        pub light_vertices: u32,
        pub longest_light_path: u32,
        pub connection_round: u32,
        pub non_finite_vertices: u32,
    }
}

device_struct! {
    /// What a waiting ray of a bidirectional sub-path carries beside its [`PathRay`].
    pub struct SubPath {
        /// The vertex that the ray leaves.
        pub position: [f32; 3],
        /// Of the densities of all other strategies to this one's, for the vertex to come: `lib/mis`.
        pub ratio: f32,
        /// Geometric normal of the vertex; zero for one without.
        pub normal: [f32; 3],
        pub flags: u32,
    }
}

device_struct! {
    /// What a ray that leaves an eye vertex carries for weights by subspaces.
    pub struct EyeMis {
        /// The colour A of `lib/weights_subspaces`.
        pub a: [f32; 3],
        /// Eye subspace of the vertex.
        pub label: u32,
    }
}

device_struct! {
    /// The same for a ray that leaves a light vertex.
    pub struct LightMis {
        /// |w| / Q of the vertex; 0 for a delta vertex.
        pub w_over_q: f32,
        /// What connecting it to the vertex before adds to the ratio of the ray. In training: density per area of that vertex, as
        /// the eye's side would sample it.
        pub behind: f32,
        /// Density of an unguided sub-path up to where the ray arrives, over that of this one; 1 where nothing is guided.
        pub nominal: f32,
        /// Light subspace of the vertex.
        pub label: u32,
    }
}

device_struct! {
    /// A vertex of an eye path that pre-tracing wrote down.
    pub struct TrainingVertex {
        pub position: [f32; 3],
        pub path: u32,
        pub normal: [f32; 3],
        /// Number of the vertex in the low 16 bits; above them its thinning in units, 0 of a delta vertex.
        pub depth_thinning: u32,
        pub direction: [f32; 3],
        pub pdf_area: f32,
        pub f: [f32; 3],
        pub geometry: f32,
    }
}

device_struct! {
    /// A light that an eye path of pre-tracing found.
    pub struct TrainingEnd {
        pub emitted: [f32; 3],
        pub path: u32,
        pub f: [f32; 3],
        pub depth_sampled: u32,
        pub f_light: [f32; 3],
        pub vertex: u32,
        pub contribution: f32,
        pub p0: f32,
        pub geometry: f32,
        pub light: u32,
        pub at: [f32; 2],
        pub pdf_light: f32,
        pub pdf_back: f32,
        pub direction: [f32; 3],
        pub share: f32,
    }
}

device_struct! {
    /// A vertex of the light cache as the host learns from it.
    pub struct LightFeature {
        pub position: [f32; 3],
        pub weight: f32,
        pub normal: [f32; 3],
        pub light: u32,
        pub direction: [f32; 3],
        pub depth: u32,
        pub pdf_area: f32,
        pub pdf_back: f32,
        pub can_be_hit: u32,
        /// Of a vertex on a surface.
        pub thinning: f32,
    }
}

device_struct! {
    /// A vertex of the light cache.
    pub struct LightVertex {
        pub weight: [f32; 3],
        pub index: u32,
        pub world_from: [f32; 3],
        pub depth_kind: u32,
        pub b1: f32,
        pub b2: f32,
        pub pdf_area: f32,
        pub ratio: f32,
        pub to_previous: f32,
        pub edge: f32,
        pub path: u32,
        pub number_label: u32,
    }
}

device_struct! {
    /// A vertex of the light cache where all surfaces scatter by Lambert's law alone.
    pub struct LambertVertex {
        pub weight: [f32; 3],
        pub index_kind: u32,
        pub b1: f32,
        pub b2: f32,
        pub size: f32,
        pub step: f32,
        pub edge_step: f32,
        pub pdf_scale: f32,
        pub path: u32,
        pub depth_label: u32,
    }
}

device_struct! {
    /// A vertex of an eye path that draws light vertices for those near to it.
    pub struct Record {
        pub position: [f32; 3],
        pub triangle: u32,
        pub b1: f32,
        pub b2: f32,
        pub path: u32,
        pub depth_sides: u32,
        pub most_geometry: f32,
        pub inv_q: f32,
        pub pad0: u32,
        pub pad1: u32,
    }
}

device_struct! {
    /// A vertex of an eye path in its path's list.
    pub struct EyeLink {
        pub step: [f32; 3],
        pub before: u32,
        pub inv_q: [f32; 3],
        pub pdf_before: f32,
        pub pdf_area: f32,
        pub scale: f32,
        pub pad0: u32,
        pub pad1: u32,
    }
}

device_struct! {
    /// The same, where weights know what light vertices bring to records.
    pub struct RecordLink {
        pub step: [f32; 3],
        pub before: u32,
        pub reach0: [f32; 3],
        pub pdf_before: f32,
        pub reach1: [f32; 3],
        pub pdf_area: f32,
        pub reach2: [f32; 3],
        pub scale: f32,
        pub records: [u32; 3],
        pub pad0: u32,
    }
}

device_struct! {
    /// Sums over the samples of a pixel since the host last took them.
    pub struct FilmPixel {
        pub sum: [f32; 3],
        pub count: u32,
        pub sum_sq: [f32; 3],
        pub non_finite: u32,
        pub open: [f32; 3],
        pub open_groups: u32,
    }
}

device_struct! {
    /// A page of what there is of every pixel.
    pub struct Page {
        pub first_pixel: u32,
        pub pixel_count: u32,
        pub pad0: u32,
        pub pad1: u32,
    }
}

device_struct! {
    /// A material; textures are indices into `texture_slots` plus one.
    pub struct Material {
        pub base_color: [f32; 3],
        pub flags: u32,
        pub emission: [f32; 3],
        pub opacity: f32,
        pub f0: [f32; 3],
        pub f90: f32,
        pub absorption: [f32; 3],
        pub alpha_cutoff: f32,
        pub metallic: f32,
        pub alpha: f32,
        pub transmission: f32,
        pub eta: f32,
        pub inv_base_average: f32,
        pub albedo_row: u32,
        pub roughness: f32,
        pub ior: f32,
        pub specular_color: [f32; 3],
        pub specular: f32,
        pub normal_scale: f32,
        pub base_color_texture: u32,
        pub metallic_roughness_texture: u32,
        pub normal_texture: u32,
        pub emission_texture: u32,
        pub specular_texture: u32,
        pub specular_color_texture: u32,
        pub transmission_texture: u32,
    }
}

/// Where a material's flags, and a sub-path's, have the thinning of connections, in whole units: `shaders/lib/thinning.wgsl`.
pub const THINNING_SHIFT: u32 = 8;
pub const THINNING_UNITS: u32 = 256;
pub const MATERIAL_DELTA: u32 = 1;
pub const MATERIAL_VOLUME: u32 = 2;
pub const MATERIAL_DOUBLE_SIDED: u32 = 4;
pub const MATERIAL_UNLIT: u32 = 8;
pub const MATERIAL_MASK: u32 = 16;

device_struct! {
    /// A texture in a material's slot.
    pub struct TextureSlot {
        pub offset: u32,
        pub width: u32,
        pub height: u32,
        pub flags: u32,
        pub row_u: [f32; 3],
        pub pad0: u32,
        pub row_v: [f32; 3],
        pub pad1: u32,
    }
}

pub const TEXTURE_NEAREST: u32 = 16;
pub const TEXTURE_SRGB: u32 = 32;
pub const TEXTURE_UV1: u32 = 64;

device_struct! {
    /// A light with its slot of the alias table over all lights.
    pub struct Light {
        pub kind: u32,
        pub index: u32,
        pub threshold: u32,
        pub alias_index: u32,
        pub pdf_select: f32,
    }
}

device_struct! {
    /// What there is to know of an environment beside its texels.
    pub struct EnvironmentMap {
        /// Texels along a side.
        pub size: u32,
        /// Index of the environment in the list of lights.
        pub light: u32,
        /// Density per solid angle of a texel: its luminance times the one, plus the other.
        pub pdf_scale: f32,
        pub pdf_floor: f32,
    }
}

pub const LIGHT_TRIANGLE: u32 = 0;
pub const LIGHT_ENVIRONMENT: u32 = 1;
pub const LIGHT_POINT: u32 = 2;
pub const LIGHT_SPOT: u32 = 3;
pub const LIGHT_DIRECTIONAL: u32 = 4;

device_struct! {
    /// A light without a surface, in unit space.
    pub struct PunctualLight {
        pub position: [f32; 3],
        pub cone: f32,
        pub intensity: [f32; 3],
        pub falloff_scale: f32,
        pub direction: [f32; 3],
        pub pad: u32,
    }
}

device_struct! {
    /// Sums over what the camera sees first in a pixel.
    pub struct FirstHitPixel {
        pub albedo: [f32; 3],
        pub depth: f32,
        pub normal: [f32; 3],
        pub hits: u32,
    }
}

device_struct! {
    /// A light's slot of the alias table that guided light paths pick their light from.
    pub struct GuidePick {
        pub threshold: u32,
        pub alias_index: u32,
        pub pdf_select: f32,
        pub pad: u32,
    }
}

device_struct! {
    /// A node of a classification tree.
    pub struct TreeNode {
        pub split: [f32; 3],
        pub child_kind: u32,
    }
}

pub const TREE_KIND: u32 = 0xc000_0000;
pub const TREE_CHILD: u32 = 0x3fff_ffff;
pub const TREE_LEAF: u32 = 0;
pub const TREE_POSITION: u32 = 0x4000_0000;
pub const TREE_NORMAL: u32 = 0x8000_0000;
pub const TREE_DIRECTION: u32 = 0xc000_0000;
