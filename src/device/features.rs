//! Every feature that an `#if` of a shader may name: the only list of them. What is off is not in the text of a kernel,
//! has no buffer and costs nothing.

use std::fmt;

use super::pages::Pages;
use crate::scene::SceneFeatures;

macro_rules! features {
    (
        scene { $($scene:ident $scene_field:ident, [$($scene_implied:ident),*], $scene_about:literal;)* }
        others { $($other:ident $other_name:ident, [$($other_implied:ident),*], $other_about:literal;)* }
    ) => {
        /// A part of the kernels that can be left out of their text.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Feature {
            $(#[doc = $scene_about] $scene,)*
            $(#[doc = $other_about] $other,)*
        }

        impl Feature {
            /// All of them, those of scenes first.
            pub const ALL: &'static [Self] = &[$(Self::$scene,)* $(Self::$other,)*];

            /// As `#if` has it.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$scene => stringify!($scene_field),)*
                    $(Self::$other => stringify!($other_name),)*
                }
            }

            /// What it is, or what it costs where it is on.
            pub fn about(self) -> &'static str {
                match self {
                    $(Self::$scene => $scene_about,)*
                    $(Self::$other => $other_about,)*
                }
            }

            /// What is on wherever this is.
            pub fn implies(self) -> &'static [Self] {
                match self {
                    $(Self::$scene => &[$(Self::$scene_implied),*],)*
                    $(Self::$other => &[$(Self::$other_implied),*],)*
                }
            }

            /// The switch of a scene's features that turns it on; `None` for what follows from others, from the method or
            /// from the device. A switch that is not in the table does not compile.
            pub fn switch(self, features: &mut SceneFeatures) -> Option<&mut bool> {
                let SceneFeatures { $($scene_field),* } = features;
                match self {
                    $(Self::$scene => Some($scene_field),)*
                    $(Self::$other => None,)*
                }
            }
        }
    };
}

features! {
    scene {
        LambertOnly lambert_only, [], "saves the microfacet code and its table of albedos";
        Transmission transmission, [], "adds refraction to the shading kernel";
        RoughTransmission rough_transmission, [Transmission], "adds a microfacet lobe for transmission";
        Absorption absorption, [], "an exponential for each segment inside a volume";
        Alpha alpha, [], "looks up opacity inside the traversal, at every hit of such a surface";
        Culling culling, [], "a test at every hit of the camera's rays on such a surface";
        Textures textures, [], "look-ups while shading; 4 bytes per texel of memory";
        MetallicRoughnessTexture metallic_roughness_texture, [Textures, SurfaceTextures], "one look-up per surface";
        SpecularTexture specular_texture, [Textures, SurfaceTextures], "two look-ups per surface";
        TransmissionTexture transmission_texture, [Textures, SurfaceTextures], "one look-up per surface";
        EmissionTexture emission_texture, [Textures], "one look-up per surface that emits";
        Normals normals, [Attributes, BentNormals], "12 bytes per vertex";
        NormalMap normal_map, [Attributes, Textures, BentNormals], "28 bytes per vertex, one look-up per surface";
        VertexColors vertex_colors, [Attributes], "16 bytes per vertex";
        Uv0 uv0, [Attributes], "8 bytes per vertex";
        Uv1 uv1, [Attributes], "8 bytes per vertex";
        AreaLights area_lights, [Lights], "one shadow ray per surface, shared by all lights";
        Unlit unlit, [], "a test per surface";
        PunctualLights punctual_lights, [Lights], "one shadow ray per surface, shared by all lights";
        Environment environment, [Lights], "16 bytes per texel; misses are shaded";
    }
    others {
        // From the scene.
        Attributes attributes, [], "vertices carry more than positions";
        BentNormals bent_normals, [], "directions are moved so that a bent normal loses no light";
        SurfaceTextures surface_textures, [], "what microfacets do follows from textures at each hit, not once for a material";
        Lights lights, [], "something can be sampled as a light";
        Coincident coincident, [], "hits of surfaces that lie in others, and samples of such lights, look at what is in front";
        Instances instances, [], "meshes in many places are stored once: rays go through a second level of trees";
        ThinGaps thin_gaps, [], "distances along rays are those of planes: surfaces that all but touch are told apart";
        DeepTree deep_tree, [], "the traversal's stack is four times as large";
        // From the device.
        Software software, [], "a workgroup's invocations run one after the other, each makes all connections of a vertex, and a minimum costs three instructions";
        RayQuery ray_query, [], "the driver's acceleration structure finds what rays meet, in hardware where it has any";
        // From the method, for all its kernels.
        Bidirectional bidirectional, [], "rays carry what bidirectional weights need, 32 bytes each";
        Splats splats, [], "the film adds what light paths brought to its pixels";
        Subspaces subspaces, [Bidirectional], "vertices are classified, connections drawn by subspace";
        SubspaceDirections subspace_directions, [Subspaces], "directions count in the classification";
        Thinning thinning, [Bidirectional], "eye vertices of narrow lobes make fewer connections";
        Learns learns, [Subspaces], "paths are written down in place of being shown";
        Resampling resampling, [Bidirectional], "weights know of records: eye paths keep a list of their vertices, 48 bytes each";
        AtRecords at_records, [Resampling], "weights know what light vertices bring to records: three rays for each vertex of all paths, and 80 bytes for each of eye paths";
        Independent independent, [Bidirectional], "each sample has points of its own, and each connection a draw of its own: for comparison";
        LambertVertices lambert_vertices, [LambertOnly, Bidirectional], "light vertices of 48 bytes in place of 64";
        // From the method, for single kernels.
        AnyHit any_hit, [], "the traversal ends at the first hit";
        Counted counted, [], "rays tell what they looked at: for `bench rays`";
        SplatsAtomic splats_atomic, [], "connections add to pixels in any order";
        FilmPages film_pages, [], "a kernel sees a part of the film: the picture is larger than a binding";
        LightPaths light_paths, [], "paths are numbered as light paths";
        SharedLightPaths shared_light_paths, [LightPaths], "light paths are spread over the whole iteration";
        LightCache light_cache, [], "light paths leave their vertices in the cache";
        LightOnly light_only, [], "there are no eye paths: lights themselves are connected to the camera";
        LightGuide light_guide, [Subspaces], "light paths go where their light is wanted";
        Nominal nominal, [Subspaces], "weights of connections to the camera take guided light paths for unguided";
        Transparent transparent, [], "the camera sees nothing where it would see the environment";
        ThroughMirrors through_mirrors, [], "layers show what is seen in mirrors and through smooth glass";
        Records records, [], "connections are drawn by the tables of the nearest records";
        OwnLightPath own_light_path, [], "an eye path is connected to its own light path";
    }
}

impl Feature {
    /// The feature of that name.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|feature| feature.name() == name)
    }

    /// Those that a scene turns on or off, in the order of their table.
    pub fn of_scenes() -> impl Iterator<Item = Self> {
        let mut features = SceneFeatures::default();
        Self::ALL.iter().copied().filter(move |feature| feature.switch(&mut features).is_some())
    }

    fn bit(self) -> u64 {
        1 << self as u32
    }
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a stitched text is made with. Whatever a feature implies comes with it.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Features {
    on: u64,
    /// Of the scene's buffers.
    pages: Pages,
}

impl Features {
    /// Turns a feature on, and all that it implies.
    pub fn insert(&mut self, feature: Feature) {
        if !self.contains(feature) {
            self.on |= feature.bit();
            self.extend(feature.implies().iter().copied());
        }
    }

    /// These and some more.
    pub fn with(mut self, more: &[Feature]) -> Self {
        self.extend(more.iter().copied());
        self
    }

    /// These without one, which none of them implies.
    pub fn without(mut self, feature: Feature) -> Self {
        debug_assert!(self.iter().all(|other| !other.implies().contains(&feature)), "{feature}");
        self.on &= !feature.bit();
        self
    }

    pub fn contains(self, feature: Feature) -> bool {
        self.on & feature.bit() != 0
    }

    /// These, with a scene's buffers in so many pages.
    pub fn with_pages(self, pages: Pages) -> Self {
        Self { pages, ..self }
    }

    /// Pages of the scene's buffers.
    pub fn pages(self) -> Pages {
        self.pages
    }

    /// In the order of the table.
    pub fn iter(self) -> impl Iterator<Item = Feature> {
        Feature::ALL.iter().copied().filter(move |&feature| self.contains(feature))
    }
}

impl From<SceneFeatures> for Features {
    fn from(mut scene: SceneFeatures) -> Self {
        Feature::of_scenes().filter(|feature| feature.switch(&mut scene).is_some_and(|on| *on)).collect()
    }
}

impl Extend<Feature> for Features {
    fn extend<I: IntoIterator<Item = Feature>>(&mut self, features: I) {
        features.into_iter().for_each(|feature| self.insert(feature));
    }
}

impl FromIterator<Feature> for Features {
    fn from_iter<I: IntoIterator<Item = Feature>>(features: I) -> Self {
        let mut set = Self::default();
        set.extend(features);
        set
    }
}

impl<const N: usize> From<[Feature; N]> for Features {
    fn from(features: [Feature; N]) -> Self {
        features.into_iter().collect()
    }
}

impl fmt::Debug for Features {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_set().entries(self.iter().map(Feature::name)).finish()
    }
}
