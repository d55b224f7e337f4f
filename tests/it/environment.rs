//! The environment: where its texels lie, and that no light is lost or gained on the way to the equal-area square.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use bytemuck::cast_slice;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, LayerAttributes,
    WritableImage,
};
use glam::{DVec2, DVec3, Vec2, Vec4};
use halfway::accel::Accel;
use halfway::device::scene::DeviceScene;
use halfway::device::shader::stitch_text;
use halfway::device::{Kernel, PagedBuffer};
use halfway::math::alias::AliasEntry;
use halfway::math::equal_area::{sphere_to_square, square_to_sphere};
use halfway::math::rng::{RandomKey, uniform4};
use halfway::scene::{Environment, EqualAreaMap, SceneError, SceneFeatures};
use serde_json::json;

use crate::gltf_file::GltfFile;
use crate::gpu;
use crate::judge::scene;

fn environment(width: u32, height: u32, texels: Vec<[f32; 3]>) -> Environment {
    Environment { name: "test".into(), width, height, texels, scale: 1.0, rotation: 0.0 }
}

/// Black but for one texel of radiance 1e6.
fn one_hot(width: u32, height: u32, column: u32, row: u32) -> Environment {
    let mut texels = vec![[0.0; 3]; (width * height) as usize];
    texels[(row * width + column) as usize] = [1e6, 2e6, 0.0];
    environment(width, height, texels)
}

fn map(environment: &Environment) -> EqualAreaMap {
    EqualAreaMap::new(environment).expect("a valid environment").expect("some light")
}

/// The planes whose irradiance is compared.
const NORMALS: [DVec3; 6] =
    [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::new(-0.6, 0.48, -0.64)];

/// Integral of radiance times solid angle, and times max(0, cos) besides for each of [`NORMALS`].
#[derive(Default)]
struct Integrals {
    radiance: f64,
    irradiance: [f64; 6],
}

impl Integrals {
    fn add(&mut self, direction: DVec3, radiance: f64) {
        self.radiance += radiance;
        for (sum, normal) in self.irradiance.iter_mut().zip(NORMALS) {
            *sum += radiance * normal.dot(direction).max(0.0);
        }
    }
}

/// Of the red channel of the map, with the cosine at the middles of each texel's quarters.
fn of_map(map: &EqualAreaMap) -> Integrals {
    let mut integrals = Integrals::default();
    let cells = 2 * map.size;
    let solid_angle = 4.0 * PI / f64::from(cells).powi(2);
    for y in 0..cells {
        for x in 0..cells {
            let radiance = f64::from(map.radiance[(y / 2 * map.size + x / 2) as usize][0]);
            if radiance > 0.0 {
                let square = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / f64::from(cells);
                integrals.add(square_to_sphere(square), solid_angle * radiance);
            }
        }
    }
    integrals
}

/// By quadrature in azimuth and polar angle, with a cell's solid angle in closed form.
fn by_angles(environment: &Environment) -> Integrals {
    let mut integrals = Integrals::default();
    let (columns, rows) = (360.max(12 * environment.width), 480.max(12 * environment.height));
    for row in 0..rows {
        let (from, to) = (PI * f64::from(row) / f64::from(rows), PI * f64::from(row + 1) / f64::from(rows));
        let solid_angle = (from.cos() - to.cos()) * TAU / f64::from(columns);
        for column in 0..columns {
            let azimuth = TAU * ((f64::from(column) + 0.5) / f64::from(columns) - 0.5);
            let direction = direction(azimuth, 0.5 * (from + to));
            let radiance = environment.radiance(direction).x;
            if radiance > 0.0 {
                integrals.add(direction, solid_angle * radiance);
            }
        }
    }
    integrals
}

fn direction(azimuth: f64, polar: f64) -> DVec3 {
    DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
}

/// Four numbers in [0, 1) a test may call its own by `purpose`.
fn random(index: u32, purpose: u32) -> Vec4 {
    uniform4(RandomKey { pixel: index, sample: 0, seed: 20 }, purpose)
}

fn assert_close(have: f64, want: f64, tolerance: f64, what: &str) {
    assert!((have - want).abs() <= tolerance * want.abs(), "{what}: {have} instead of {want}");
}

#[test]
fn equal_area_map_is_one_to_one_and_preserves_area() {
    for index in 0..100_000 {
        let u = random(index, 1);
        let square = DVec2::new(f64::from(u[0]), f64::from(u[1]));
        let direction = square_to_sphere(square);
        assert!((direction.length() - 1.0).abs() < 1e-14);
        assert!((sphere_to_square(direction) - square).abs().max_element() < 1e-12, "{square}");
        // Away from the creases, where the map has no derivative, 4 pi times the area everywhere.
        let p = (2.0 * square - DVec2::ONE).abs();
        if p.min_element() > 1e-4 && (1.0 - p.x - p.y).abs() > 1e-4 && p.max_element() < 1.0 - 1e-4 {
            let h = 1e-6;
            let along =
                |step: DVec2| (square_to_sphere(square + step) - square_to_sphere(square - step)) / (2.0 * h);
            let area = along(DVec2::new(h, 0.0)).cross(along(DVec2::new(0.0, h))).length();
            assert_close(area, 4.0 * PI, 1e-5, "area");
        }
    }
    assert_eq!(square_to_sphere(DVec2::splat(0.5)), DVec3::Y);
    assert!((square_to_sphere(DVec2::ZERO) + DVec3::Y).length() < 1e-15);
    assert!((square_to_sphere(DVec2::new(1.0, 0.5)) - DVec3::X).length() < 1e-15);
    assert!((square_to_sphere(DVec2::new(0.5, 1.0)) + DVec3::Z).length() < 1e-15);
}

#[test]
fn c15_equal_area_on_the_device() {
    let mut squares: Vec<Vec2> = vec![];
    let mut directions: Vec<Vec4> = vec![];
    for x in [0.0f32, 0.25, 0.5, 0.75, 1.0] {
        squares.extend([0.0f32, 0.25, 0.5, 0.75, 1.0].map(|y| Vec2::new(x, y)));
    }
    for axis in [Vec4::X, Vec4::Y, Vec4::Z] {
        directions.extend([
            axis,
            -axis,
            (axis + 1e-6 * Vec4::X).normalize(),
            (axis - 1e-6 * Vec4::Z).normalize(),
        ]);
    }
    directions.extend([Vec4::new(0.0, -1.0, 1e-20, 0.0), Vec4::new(-1e-30, 1.0, -1e-30, 0.0)]);
    while squares.len() < 65_536 {
        let u = random(squares.len() as u32, 2);
        squares.push(Vec2::new(u[0], u[1]));
    }
    while directions.len() < squares.len() {
        let u = random(directions.len() as u32, 3);
        let d = square_to_sphere(DVec2::new(f64::from(u[0]), f64::from(u[1]).powi(4))).as_vec3();
        directions.push(d.extend(0.0));
    }
    let kernel = "
        #import lib/equal_area
        @group(0) @binding(0) var<storage, read> squares: array<vec2f>;
        @group(0) @binding(1) var<storage, read> directions: array<vec4f>;
        @group(0) @binding(2) var<storage, read_write> to_sphere: array<vec4f>;
        @group(0) @binding(3) var<storage, read_write> to_square: array<vec2f>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&squares) {
                to_sphere[id.x] = vec4f(square_to_sphere(squares[id.x]), 0.0);
                to_square[id.x] = sphere_to_square(directions[id.x].xyz);
            }
        }";
    let inputs = [("squares", cast_slice(&squares)), ("directions", cast_slice(&directions))];
    let outputs = [("to_sphere", 16 * squares.len()), ("to_square", 8 * squares.len())];
    let results = gpu::run(kernel, &[], &inputs, &outputs, squares.len() as u32);
    for (square, have) in squares.iter().zip(cast_slice::<u8, Vec4>(&results[0])) {
        let error = (have.truncate().as_dvec3() - square_to_sphere(square.as_dvec2())).length();
        assert!(error <= 1e-6, "{square}: {have}, off by {error}");
    }
    for (direction, have) in directions.iter().zip(cast_slice::<u8, Vec2>(&results[1])) {
        // Compared as directions, since neighbours across a seam lie apart in the square.
        let direction = direction.truncate().as_dvec3();
        let error = (square_to_sphere(have.as_dvec2()) - direction).length();
        assert!(have.min_element() >= 0.0 && have.max_element() <= 1.0, "{direction}: {have}");
        assert!(error <= 2e-6, "{direction}: {have}, off by {error}");
    }
}

#[test]
fn environment_looks_along_minus_z() {
    // One bright texel in turn; its centre's direction must see it, and see it in full.
    for (column, row) in [(0, 0), (1, 1), (4, 2), (7, 3), (6, 3)] {
        let environment = one_hot(8, 4, column, row);
        let azimuth = TAU * ((f64::from(column) + 0.5) / 8.0 - 0.5);
        let towards = direction(azimuth, PI * (f64::from(row) + 0.5) / 4.0);
        assert_close(environment.radiance(towards).x, 1e6, 1e-6, "centre");
        assert!(environment.radiance(-towards).x.abs() < 1e-3);
    }
    let ramp: Vec<[f32; 3]> = (0..256).map(|i| [(i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5, 0.0]).collect();
    let ramp = environment(64, 4, ramp);
    assert_close(ramp.radiance(DVec3::NEG_Z).x, 32.0, 1e-6, "the middle is -z");
    assert_close(ramp.radiance(DVec3::X).x, 48.0, 1e-6, "right of it is +x");
    assert_close(ramp.radiance(DVec3::NEG_X).x, 16.0, 1e-6, "left of it is -x");
    assert_close(ramp.radiance(DVec3::Y).y, 0.5, 1e-6, "row 0 is up");
    let turned = Environment { rotation: (PI / 2.0) as f32, scale: 2.0, ..ramp };
    assert_close(turned.radiance(DVec3::NEG_X).x, 64.0, 1e-5, "a quarter turn brings -z to -x");
}

#[test]
fn n20_environment_energy_is_kept() {
    let mut cases = vec![("constant", environment(8, 4, vec![[3.0; 3]; 32]))];
    cases.push(("single texel", environment(1, 1, vec![[2.0; 3]])));
    for (column, row) in [(0, 0), (2, 1)] {
        cases.push(("4x2", one_hot(4, 2, column, row)));
    }
    for row in [0, 8] {
        cases.push(("1x16", one_hot(1, 16, 0, row)));
    }
    for column in [0, 9] {
        cases.push(("16x1", one_hot(16, 1, column, 0)));
    }
    for (column, row) in [(0, 0), (63, 31), (17, 0), (5, 1), (40, 16)] {
        cases.push(("64x32", one_hot(64, 32, column, row)));
    }
    let stripes = (0..512).map(|i| if (i / 32) % 2 == 0 { [0.0; 3] } else { [1.0; 3] }).collect();
    cases.push(("zero rows", environment(32, 16, stripes)));
    cases.push(("turned", Environment { rotation: 1.0, scale: 0.5, ..one_hot(16, 8, 3, 2) }));

    let mut worst = 0.0f64;
    for (name, environment) in &cases {
        let map = map(environment);
        let edge = (4.0 * PI).sqrt() / f64::from(map.size);
        let (have, want) = (of_map(&map), by_angles(environment));
        assert_close(have.radiance, want.radiance, 2e-3, name);
        for ((have, expected), normal) in have.irradiance.iter().zip(want.irradiance).zip(NORMALS) {
            // Where a plane cuts through the light, the map knows nothing finer than its texels: there a light may
            // seem moved by half a texel.
            let error = (have - expected).abs() / want.radiance;
            let faces = expected > 0.5 * want.radiance;
            let tolerance = if faces { 2e-3 * expected / want.radiance } else { 0.5 * edge };
            assert!(error <= tolerance, "{name}, {normal}: {have} instead of {expected}");
            if faces {
                worst = worst.max(error);
            }
        }
    }
    println!("worst error {worst:.2e}");
}

/// The tent of one bright texel integrates to 2 sin(t) (1 - cos d) / d times the width of a column, d being the
/// height of a row; at a pole the half towards it is flat.
#[test]
fn n20_one_pixel_in_a_large_map_has_its_closed_form() {
    let (width, height) = (256, 128);
    let d = PI / f64::from(height);
    let mut worst = 0.0f64;
    let at_random = (0..6).map(|index| random(index, 4));
    let at_random = at_random.map(|u| ((u.x * width as f32) as u32, (u.y * height as f32) as u32));
    for (column, row) in
        [(0, 0), (255, 127), (100, 0), (7, 1), (200, 2), (77, 126)].into_iter().chain(at_random)
    {
        let polar = d * (f64::from(row) + 0.5);
        let tent = if row == 0 || row == height - 1 {
            (1.0 - (0.5 * d).cos()) + (0.5 * d).cos() - ((1.5 * d).sin() - (0.5 * d).sin()) / d
        } else {
            2.0 * polar.sin() * (1.0 - d.cos()) / d
        };
        let want = 1e6 * tent * TAU / f64::from(width);
        let map = map(&one_hot(width, height, column, row));
        let sum: f64 = map.radiance.iter().map(|texel| f64::from(texel[0])).sum();
        let have = sum * 4.0 * PI / f64::from(map.size * map.size);
        assert_close(have, want, 2e-3, &format!("column {column}, row {row}, size {}", map.size));
        worst = worst.max((have / want - 1.0).abs());
    }
    println!("worst error {worst:.2e}");
}

/// What the kernels take for a texel's density, from its radiance, is what the table draws it with; a sun of 10^7 beside
/// dim and black texels.
#[test]
fn n20_texels_are_drawn_as_often_as_kernels_think() {
    let texels = |i: u32| match i {
        77 => [1e5, 2e7, 3e6],
        i if i < 300 => [0.0; 3],
        i if i < 600 => [1e-6, 3e-6, 0.0],
        i => [(i % 17) as f32, 0.3, 0.1 * (i % 5) as f32],
    };
    let mut scene = scene([]);
    scene.environment = Some(environment(64, 32, (0..2048).map(texels).collect()));
    let accel = Accel::build(&scene).expect("a BVH");
    let context = gpu::context();
    let device =
        DeviceScene::new(context, &scene, &accel, SceneFeatures::of(&scene)).expect("a device scene");
    let table: Vec<AliasEntry> =
        PagedBuffer::EnvironmentAlias.read(context, &device.buffers).expect("a table");
    let mut units = vec![0u64; table.len()];
    for (slot, entry) in table.iter().enumerate() {
        let own = if entry.alias as usize == slot { 1 << 32 } else { u64::from(entry.threshold) };
        units[slot] += own;
        units[entry.alias as usize] += (1 << 32) - own;
    }
    let kernel = "#import lib/environment
        @group(1) @binding(0) var<storage, read_write> densities: array<f32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&densities) {
                densities[id.x] = texel_pdf_solid(texel_radiance(id.x));
            }
        }";
    let stitched = stitch_text("densities", kernel, device.kernel_features()).expect("directives");
    let kernel = Kernel::from_stitched(context, "densities", &stitched, &device.constants).expect("a kernel");
    let mut buffers = device.buffers.clone();
    buffers.create(context, "densities", 4 * units.len() as u64).expect("a buffer");
    let bound = kernel.bind(context, &buffers).expect("all buffers named");
    let mut encoder = context.device.create_command_encoder(&Default::default());
    bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), units.len() as u32);
    context.queue.submit([encoder.finish()]);
    let densities: Vec<f32> = buffers.read_all(context, "densities").expect("densities");
    let (mut worst, mut black) = (0.0f64, 0);
    for (&have, &units) in densities.iter().zip(&units) {
        let want = units as f64 / 2f64.powi(32) / (4.0 * PI);
        assert_eq!(have == 0.0, units == 0);
        black += u32::from(units == 0);
        if units > 0 {
            worst = worst.max((f64::from(have) / want - 1.0).abs());
        }
    }
    println!("{black} black texels of {}, worst error {worst:.2e}", units.len());
    assert!(black > 1000 && worst < 1e-6);
}

/// A smaller map is blurred, and has the same light.
#[test]
fn n20_a_smaller_map_keeps_the_energy() {
    let environment = one_hot(64, 32, 40, 16);
    let want = by_angles(&environment);
    assert_eq!(EqualAreaMap::size_for(&environment), 256);
    for size in [128, 64] {
        let map = EqualAreaMap::with_size(&environment, size).expect("valid").expect("some light");
        assert_eq!((map.size, map.radiance.len()), (size, (size * size) as usize));
        assert_close(of_map(&map).radiance, want.radiance, 2e-3, "smaller");
    }
}

#[test]
fn n20_constant_stays_constant_and_black_is_no_light() {
    let map = map(&environment(30, 15, vec![[0.7, 0.1, 0.3]; 450]));
    assert!(map.size.is_power_of_two());
    for texel in &map.radiance {
        for (have, want) in texel.iter().zip([0.7, 0.1, 0.3]) {
            assert!((have - want).abs() <= 2.0 * f32::EPSILON * want, "{texel:?}");
        }
    }
    let black = environment(4, 2, vec![[0.0; 3]; 8]);
    assert_eq!(EqualAreaMap::new(&black).expect("valid"), None);
    let switched_off = Environment { scale: 0.0, ..environment(4, 2, vec![[1.0; 3]; 8]) };
    assert_eq!(EqualAreaMap::new(&switched_off).expect("valid"), None);
}

fn loaded(path: &Path) -> Result<(Environment, Vec<String>), SceneError> {
    let mut warnings = Vec::new();
    let environment = Environment::load(path, &mut warnings)?;
    Ok((environment, warnings.iter().map(ToString::to_string).collect()))
}

/// The environment of 4x3 texels that are all 1 but for those given, by index and channel.
fn with_values(values: &[(usize, usize, f32)]) -> Result<(Environment, Vec<String>), SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    let mut rgb = vec![[1.0; 3]; 12];
    for &(index, channel, value) in values {
        rgb[index][channel] = value;
    }
    halfway::film::exr::write(&path, &halfway::film::Picture::new(4, 3, rgb)).unwrap();
    loaded(&path)
}

#[test]
fn texels_that_are_no_radiance_are_replaced_with_a_warning() {
    for (value, said, becomes) in
        [(-1.0, "-1", 0.0), (f32::NAN, "NaN", 0.0), (f32::NEG_INFINITY, "-inf", 0.0)]
    {
        let (environment, warnings) = with_values(&[(7, 1, value), (8, 1, value), (2, 0, 9.0)]).unwrap();
        assert_eq!(environment.texels[7], [1.0, becomes, 1.0]);
        for phrase in ["sky.exr", "2 texels are negative", "column 3, row 1", said] {
            assert!(warnings[0].contains(phrase), "{phrase} not in {warnings:?}");
        }
        assert_eq!(warnings.len(), 1);
    }
    // Infinite neighbours, and the largest of a channel far away.
    let sun = [(5, 0), (5, 1), (5, 2), (6, 0), (6, 1), (6, 2)]
        .map(|(index, channel)| (index, channel, f32::INFINITY));
    let bright = [(0, 0, 50.0), (11, 1, 40.0), (3, 2, -2.0)];
    let (environment, warnings) = with_values(&[&sun[..], &bright].concat()).unwrap();
    assert_eq!([environment.texels[5], environment.texels[6]], [[50.0, 40.0, 1.0]; 2]);
    assert_eq!(environment.texels[3], [1.0, 1.0, 0.0]);
    assert!(warnings[0].contains("1 texels are negative") && warnings[0].contains("2 texels are infinite"));

    let all: Vec<_> = (0..36).map(|i| (i / 3, i % 3, f32::INFINITY)).collect();
    let message = with_values(&all).unwrap_err().to_string();
    assert!(message.contains("12 texels are infinite"), "{message}");
    assert!(with_values(&[]).unwrap().1.is_empty(), "nothing to warn of");
}

#[test]
fn layers_and_parts_of_an_environment() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    let at = |layer: &str| folder.path().join(format!("sky.exr#{layer}"));
    let red = |path: &Path| loaded(path).map(|(environment, warnings)| (environment.texels[0][0], warnings));

    write_exr(&path, &[("", [1, 1], &[("View Layer.Combined", 2.0)])]);
    assert_eq!(red(&path).unwrap(), (2.0, vec![]));

    write_exr(&path, &[("", [1, 1], &[("A.Direct", 1.0), ("A.Combined", 2.0), ("Z", 3.0)])]);
    assert_eq!(red(&path).unwrap(), (2.0, vec![]), "Blender's name for the finished picture");
    assert_eq!(red(&at("A.Direct")).unwrap(), (1.0, vec![]));
    let message = red(&at("A.Diffuse")).unwrap_err().to_string();
    for phrase in ["'A.Diffuse'", "'A.Direct'", "'A.Combined'", "'Z'"] {
        assert!(message.contains(phrase), "{message}");
    }

    // Parts: the first, with a list; their names come before the channels'.
    write_exr(&path, &[("left", [1, 1], &[("", 1.0)]), ("right", [2, 1], &[("", 2.0)])]);
    let (value, warnings) = red(&path).unwrap();
    assert_eq!(value, 1.0);
    assert!(warnings.is_empty(), "parts of another size are no choice: {warnings:?}");
    assert_eq!(red(&at("right")).unwrap(), (2.0, vec![]));
    write_exr(&path, &[("left", [1, 1], &[("", 1.0)]), ("right", [1, 1], &[("", 2.0)])]);
    let (value, warnings) = red(&path).unwrap();
    assert_eq!((value, warnings.len()), (1.0, 1));
    for phrase in ["sky.exr", "'left', 'right'", "'left' is used", "--env FILE#LAYER"] {
        assert!(warnings[0].contains(phrase), "{warnings:?}");
    }
    write_exr(&path, &[("a", [1, 1], &[("a.x", 1.0)]), ("b", [1, 1], &[("", 2.0)])]);
    assert_eq!(red(&at("a.x")).unwrap(), (1.0, vec![]), "the part's name is not written twice");
    write_exr(&path, &[("", [1, 1], &[("a", 1.0), ("", 2.0)])]);
    assert_eq!(red(&path).unwrap(), (2.0, vec![]), "channels that stand in no layer come first");

    // A file of that very name is meant.
    write_exr(&folder.path().join("sky.exr#1.exr"), &[("", [1, 1], &[("", 7.0)])]);
    assert_eq!(red(&folder.path().join("sky.exr#1.exr")).unwrap().0, 7.0);
}

/// The name of a part, its size, and the channels with the value of all their pixels.
type ExrPart<'a> = (&'a str, [usize; 2], &'a [(&'a str, f32)]);

/// Parts by name and size, each with layers of one value.
fn write_exr(path: &Path, parts: &[ExrPart]) {
    let parts = parts.iter().map(|(part, [width, height], layers)| {
        let channels = layers.iter().flat_map(|(layer, value)| {
            ["R", "G", "B"].map(|channel| {
                let name = if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") };
                AnyChannel::new(name.as_str(), FlatSamples::F32(vec![*value; width * height]))
            })
        });
        let attributes = match part.is_empty() {
            true => LayerAttributes::default(),
            false => LayerAttributes::named(*part),
        };
        exr::image::Layer::new(
            (*width, *height),
            attributes,
            Encoding::UNCOMPRESSED,
            AnyChannels::sort(channels.collect()),
        )
    });
    let window = IntegerBounds::from_dimensions((2, 1));
    Image::from_layers(ImageAttributes::new(window), parts.collect::<Vec<_>>())
        .write()
        .to_file(path)
        .unwrap();
}

#[test]
fn environment_in_the_gltf_is_named() {
    for name in ["EXT_lights_image_based", "KHR_lights_image_based"] {
        let mut file = GltfFile::triangle();
        file.json["extensionsUsed"] = json!([name]);
        file.json["extensions"] = json!({name: {"lights": []}});
        let warnings: Vec<String> = file.scene().warnings.iter().map(ToString::to_string).collect();
        assert!(
            warnings.len() == 1 && warnings[0].contains(name) && warnings[0].contains("--env"),
            "{warnings:?}"
        );
    }
}

#[test]
fn bad_environments_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("good.exr");
    let picture = halfway::film::Picture::new(2, 1, vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    halfway::film::exr::write(&path, &picture).unwrap();
    let (good, _) = loaded(&path).unwrap();
    assert_eq!((good.name.as_str(), good.width, good.texels), ("good", 2, picture.rgb));

    let bright = environment(1, 1, vec![[1e30; 3]]);
    for (scale, rotation) in [(1e10, 0.0), (-1.0, 0.0), (f32::NAN, 0.0), (1.0, f32::INFINITY)] {
        let message =
            EqualAreaMap::new(&Environment { scale, rotation, ..bright.clone() }).unwrap_err().to_string();
        assert!(message.contains("--env-scale"), "{message}");
    }
}
