//! Host and shader agree: structs and constants that stand on both sides. No device is needed.

use std::collections::BTreeSet;

use halfway::device::layout;
use halfway::device::shader::{SOURCES, stitch};
use halfway::device::{Feature, Features};
use halfway::integrator::DEFAULT_ROULETTE_CAP;
use naga::proc::Layouter;
use naga::{Literal, Module, TypeInner};

/// Name, size and fields of host structs.
macro_rules! host_structs {
    ($($name:ident),* $(,)?) => {
        [$((stringify!($name), size_of::<layout::$name>(), layout::$name::FIELDS)),*]
    };
}

/// Name and value of host constants.
macro_rules! host_constants {
    ($($name:ident),* $(,)?) => { [$((stringify!($name), layout::$name)),*] };
}

const STRUCTS: &[(&str, usize, &[layout::Field])] = &host_structs![
    Triangle,
    Instance,
    InstanceNumbers,
    Batch,
    Camera,
    PathRay,
    Hit,
    ShadowRay,
    SubPath,
    EyeMis,
    LightMis,
    LightVertex,
    LambertVertex,
    Record,
    EyeLink,
    RecordLink,
    TrainingVertex,
    TrainingEnd,
    LightFeature,
    Counts,
    FilmPixel,
    Page,
    Material,
    TextureSlot,
    Light,
    EnvironmentMap,
    PunctualLight,
    GuidePick,
    FirstHitPixel,
    TreeNode,
];

const CONSTANTS: &[(&str, u32)] = &host_constants![
    TRIANGLE_FLIPPED,
    TRIANGLE_ALPHA,
    TRIANGLE_CULLED,
    TRIANGLE_INSTANCE,
    EVERY_STRATEGY,
    NO_TRIANGLE,
    MATERIAL_DELTA,
    MATERIAL_VOLUME,
    MATERIAL_DOUBLE_SIDED,
    MATERIAL_UNLIT,
    MATERIAL_MASK,
    THINNING_SHIFT,
    THINNING_UNITS,
    TEXTURE_NEAREST,
    TEXTURE_SRGB,
    TEXTURE_UV1,
    LIGHT_TRIANGLE,
    LIGHT_ENVIRONMENT,
    LIGHT_POINT,
    LIGHT_SPOT,
    LIGHT_DIRECTIONAL,
    SAMPLES_A_GROUP,
    TREE_KIND,
    TREE_CHILD,
    TREE_LEAF,
    TREE_POSITION,
    TREE_NORMAL,
    TREE_DIRECTION,
];

/// The files with an entry point.
fn kernels() -> impl Iterator<Item = &'static str> {
    SOURCES.iter().map(|(name, _)| *name).filter(|name| !name.contains('/'))
}

/// All kernels with everything on, parsed, and one in its form for less: together they hold every struct and constant.
fn full_modules() -> Vec<(&'static str, Module)> {
    let features: Features =
        Feature::of_scenes().filter(|&feature| feature != Feature::LambertOnly).collect();
    let features =
        features.with(&[Feature::LightPaths, Feature::LightCache, Feature::Subspaces, Feature::Instances]);
    let lambert = Features::from([Feature::LambertVertices, Feature::LightPaths, Feature::LightCache]);
    let pages = features.with(&[Feature::FilmPages, Feature::SplatsAtomic]);
    let at_records = lambert.with(&[Feature::AtRecords]);
    let of = |name| match name {
        "splat_page" => pages,
        "eye_reach" | "light_edges" => at_records,
        _ => features,
    };
    kernels()
        .map(|name| (name, stitch(name, of(name))))
        .chain([("light_shade", stitch("light_shade", lambert))])
        .chain([("eye_shade", stitch("eye_shade", lambert.with(&[Feature::Resampling])))])
        .chain([("light_rays", stitch("light_rays", features.with(&[Feature::LightGuide])))])
        .map(|(name, stitched)| (name, stitched.expect("directives").validate().expect("a valid kernel").0))
        .collect()
}

/// The word after `prefix` of every line that starts with it in the host's layout.
fn declared(prefix: &str) -> BTreeSet<&'static str> {
    include_str!("../../src/device/layout.rs")
        .lines()
        .filter_map(|line| line.trim().strip_prefix(prefix))
        .map(|rest| rest.split([' ', ':']).next().expect("split yields something"))
        .filter(|name| !name.starts_with('$'))
        .collect()
}

#[test]
fn structs_have_one_layout() {
    let modules = full_modules();
    let names: BTreeSet<&str> = STRUCTS.iter().map(|(name, ..)| *name).collect();
    assert_eq!(names, declared("pub struct "), "a struct of the host without its test");
    for &(name, size, fields) in STRUCTS {
        let mut found = 0;
        for (kernel, module) in &modules {
            let mut layouter = Layouter::default();
            layouter.update(module.to_ctx()).expect("laid out by the validator already");
            for (_, ty) in module.types.iter().filter(|(_, ty)| ty.name.as_deref() == Some(name)) {
                // Where a method carries nothing, `lib/weights_ratio` has a number of the same name.
                let TypeInner::Struct { members, span } = &ty.inner else { continue };
                found += 1;
                let of_shader: Vec<(&str, usize, usize)> = members
                    .iter()
                    .map(|member| {
                        let name = member.name.as_deref().unwrap_or_default();
                        (name, member.offset as usize, layouter[member.ty].size as usize)
                    })
                    .collect();
                assert_eq!(of_shader, fields, "{name} in {kernel}");
                assert_eq!(*span as usize, size, "{name} in {kernel}: span");
            }
        }
        assert!(found > 0, "no kernel knows {name}");
    }
}

fn constant(module: &Module, name: &str) -> Option<Literal> {
    let (_, constant) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name))?;
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(literal) => Some(literal),
        _ => None,
    }
}

#[test]
fn constants_have_one_value() {
    let modules = full_modules();
    let names: BTreeSet<&str> = CONSTANTS.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, declared("pub const ").difference(&BTreeSet::from(["FIELDS"])).copied().collect());
    for &(name, value) in CONSTANTS {
        let found: Vec<Literal> = modules.iter().filter_map(|(_, module)| constant(module, name)).collect();
        assert!(!found.is_empty(), "no kernel knows {name}");
        assert!(found.iter().all(|literal| *literal == Literal::U32(value)), "{name}: {found:?}");
    }
    // A material's flags become a surface's without a shift.
    for (surface, material) in
        [("SURFACE_DELTA", layout::MATERIAL_DELTA), ("SURFACE_VOLUME", layout::MATERIAL_VOLUME)]
    {
        let found = modules.iter().find_map(|(_, module)| constant(module, surface));
        assert_eq!(found, Some(Literal::U32(material)), "{surface}");
    }
}

/// What kernels do where the host says nothing is what it says by default.
#[test]
fn roulette_has_one_default() {
    let defaults: Vec<Literal> = full_modules()
        .iter()
        .filter_map(|(_, module)| {
            let (_, cap) =
                module.overrides.iter().find(|(_, o)| o.name.as_deref() == Some("ROULETTE_CAP"))?;
            match module.global_expressions[cap.init?] {
                naga::Expression::Literal(literal) => Some(literal),
                _ => None,
            }
        })
        .collect();
    assert!(!defaults.is_empty(), "no kernel plays roulette");
    assert!(defaults.iter().all(|literal| *literal == Literal::F32(DEFAULT_ROULETTE_CAP)), "{defaults:?}");
}
