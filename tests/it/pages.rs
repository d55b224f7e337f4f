//! Scenes beyond what a device binds at once: limits are lowered until what is small here takes pages.

use glam::{Affine2, DVec3, Vec2, Vec3};
use halfway::accel::Accel;
use halfway::device::pages::{PagedBuffer, Pages, paged};
use halfway::device::scene::{DeviceScene, SceneMemory};
use halfway::device::shader::{SOURCES, stitch};
use halfway::device::{Context, Features};
use halfway::integrator::{Connections, LvcBpt, Method};
use halfway::render::{RenderOptions, Renderer, Report};
use halfway::scene::builtin::{NAMES, builtin, shapes};
use halfway::scene::{Environment, Filter, Image, Material, Scene, SceneFeatures, Texture, TextureRef, Wrap};

use crate::gpu;
use crate::judge::{lamp, scene};
use crate::shots::options;

/// All that may be in pages: a textured ball of many vertices, in another one's plane, under a sky.
pub fn paged_scene() -> Scene {
    let texel = |i: u32| [(i * 7 % 256) as u8, (i * 13 % 256) as u8, (i / 3 % 256) as u8, 255];
    let image = |name: &str, side: u32| Image {
        name: name.into(),
        width: side,
        height: side,
        texels: (0..side * side).map(texel).collect(),
    };
    let reference = |texture| Some(TextureRef { texture, uv_set: 0, transform: Affine2::IDENTITY });
    let matt =
        |texture| Material { base_color_texture: reference(texture), ..Material::lambert("matt", Vec3::ONE) };
    let ball = shapes::smooth_sphere(DVec3::ZERO, 1.0, 2);
    let above = shapes::quad(DVec3::new(-0.5, 3.0, -0.5), DVec3::X, DVec3::Z);
    let floor = |side: f64, cells| {
        let corner = DVec3::new(-0.5 * side, -1.0, 0.5 * side);
        shapes::grid(corner, side * DVec3::X, -side * DVec3::Z, [cells; 2])
    };
    let parts = [(matt(0), ball), (matt(1), floor(6.0, 10)), (matt(0), floor(4.1, 7)), (lamp(4.0), above)];
    let mut scene = scene(parts);
    for mesh in &mut scene.meshes {
        let uv = |p: &DVec3| Vec2::new((p.x + 0.3 * p.y) as f32, p.z as f32);
        let down = if mesh.positions.len() == 4 { -Vec3::Y } else { Vec3::Y };
        mesh.normals.get_or_insert_with(|| vec![down; mesh.positions.len()]);
        mesh.uvs[0] = Some(mesh.positions.iter().map(uv).collect());
    }
    scene.cameras = vec![shapes::looking_at("from above", DVec3::new(1.0, 1.5, 4.0), DVec3::ZERO, 40.0)];
    scene.images = vec![image("one", 32), image("two", 33)];
    scene.textures =
        [0, 1].map(|image| Texture { image, wrap: [Wrap::Repeat; 2], filter: Filter::Linear }).to_vec();
    let sky = |i: u32| [0.2 + (i % 16) as f32, 1.0, if i == 40 { 300.0 } else { 0.5 }];
    scene.environment = Some(Environment {
        name: "sky".into(),
        width: 16,
        height: 8,
        texels: (0..128).map(sky).collect(),
        scale: 1.0,
        rotation: 0.3,
    });
    scene
}

fn picture(context: &Context, scene: &Scene, options: &RenderOptions) -> (Vec<[f32; 3]>, Report) {
    let mut renderer = Renderer::new(context, scene, options.clone()).expect("a renderer");
    renderer.run(|_| false).expect("a render");
    (renderer.picture().expect("a picture").rgb, renderer.report().expect("a report"))
}

/// The device with the smallest pages for which a scene takes no more than `most` bindings besides, and how many it takes.
fn paged_context(scene: &Scene, most: u32) -> (Context, u32) {
    let memory = SceneMemory::of(scene, &SceneFeatures::of(scene));
    let page_bytes = (8..).map(|bits| 1 << bits).find(|&bytes| memory.pages(bytes).extra() <= most);
    let page_bytes: u64 = page_bytes.expect("large pages");
    (gpu::context().with_page_bytes(page_bytes), memory.pages(page_bytes).extra())
}

/// Names of the scene's buffers in pages.
fn split_buffers(report: &Report) -> Vec<&str> {
    let has = |name: &str| report.memory.iter().any(|(other, _)| other == name);
    PagedBuffer::ALL.iter().map(|buffer| buffer.name()).filter(|name| has(&format!("{name}_1"))).collect()
}

#[test]
fn r12_all_that_can_be_split_is_the_same_in_pages() {
    let lvcbpt = Method::LvcBpt(LvcBpt {
        light_paths: Some(100),
        connections: Connections::even(2),
        light_tracing: false,
    });
    let with_sky = paged_scene();
    let without_sky = Scene { environment: None, ..with_sky.clone() };
    let sky = vec!["environment_texels", "environment_alias"];
    let others = vec!["nodes", "triangles", "corner_vertices", "vertex_attributes", "texels"];
    for (scene, expected) in [(with_sky, sky), (without_sky, others)] {
        let (context, _) = paged_context(&scene, 16);
        for method in [Method::default(), lvcbpt] {
            let options = RenderOptions { method, ..options([24, 24], 4) };
            let (whole, report) = picture(gpu::context(), &scene, &options);
            assert_eq!(split_buffers(&report), [""; 0]);
            let (split, report) = picture(&context, &scene, &options);
            let found = split_buffers(&report);
            assert!(expected.iter().all(|name| found.contains(name)), "{found:?} in place of {expected:?}");
            assert!(whole == split, "{}: pages of {found:?} make another picture", method.name());
        }
    }
}

/// Of the built-in scenes those without microfacets, whose kernels take most of a minute to compile and have no readings of
/// their own (all of them were the same on 2026-11-29).
#[test]
fn r12_built_in_scenes_are_the_same_in_pages() {
    for name in NAMES {
        let scene = builtin(name).expect("a built-in scene");
        if !SceneFeatures::of(&scene).lambert_only {
            continue;
        }
        let (context, extra) = paged_context(&scene, 12);
        if extra == 0 {
            // A scene of one triangle has nothing to split.
            assert!(scene.triangle_count() < 8, "{name}");
            continue;
        }
        let options = options([16, 16], 2);
        let (whole, _) = picture(gpu::context(), &scene, &options);
        let (split, report) = picture(&context, &scene, &options);
        println!("{name}: {extra} more bindings, {:?}", split_buffers(&report));
        assert!(!split_buffers(&report).is_empty(), "{name}");
        assert!(whole == split, "{name}: pages make another picture");
    }
}

/// What a scene does not need costs nothing: in one page, the text of a kernel has nothing of pages.
#[test]
fn s03_kernels_of_one_page_know_no_pages() {
    let features = Features::from(SceneFeatures::of(&paged_scene()));
    let mut two = Pages::default();
    PagedBuffer::ALL.iter().for_each(|&buffer| two.set(buffer, 2));
    let mut differ = 0;
    for (name, _) in SOURCES {
        let [one, two] = [features, features.with_pages(two)].map(|features| stitch(name, features));
        let [one, two] = [one, two].map(|stitched| stitched.expect("directives").code);
        assert!(!one.contains("paged_") && !one.contains("page_bits"), "{name}");
        differ += u32::from(one != two);
        // Without what pages add, and with plain readings again, it is the same text.
        let is_added = |line: &&str| {
            let binding = PagedBuffer::ALL.iter().any(|b| line.contains(&format!("> {}_1:", b.name())));
            binding || line.contains("_page_bits") || line.contains("fn paged_") || line.contains("within")
        };
        if two.contains("fn paged_") {
            assert!(two.lines().filter(is_added).count() >= 4, "{name}");
        }
    }
    assert!(differ > 20, "{differ}");
}

#[test]
fn readings_of_pages() {
    let mut pages = Pages::default();
    let line = "let a = vertex_attributes[corner_vertices[t * 3u] + 1u] + covers_at(x)[0]; // texels[0]";
    assert_eq!(paged(line, pages), Ok(None));
    pages.set(PagedBuffer::CornerVertices, 2);
    pages.set(PagedBuffer::Covers, 2);
    let corner =
        "let a = vertex_attributes[paged_corner_vertices(t * 3u) + 1u] + covers_at(x)[0]; // texels[0]";
    assert_eq!(paged(line, pages), Ok(Some(corner.into())));
    pages.set(PagedBuffer::VertexAttributes, 3);
    pages.set(PagedBuffer::Texels, 3);
    let both =
        "let a = paged_vertex_attributes(paged_corner_vertices(t * 3u) + 1u) + covers_at(x)[0]; // texels[0]";
    assert_eq!(paged(line, pages), Ok(Some(both.into())));
    assert!(paged("texels[1", pages).is_err());
    let declared = paged("@group(0) @binding(6) var<storage, read> texels: array<u32>;", pages);
    let declared = declared.expect("a declaration").expect("pages");
    assert_eq!(declared.matches("array<u32>;").count(), 3, "{declared}");
    assert_eq!(PagedBuffer::Texels.pages(1 << 25, 1 << 27), 1);
    assert_eq!(PagedBuffer::Texels.pages((1 << 25) + 1, 1 << 27), 2);
    // What fits in one page is in one, whether or not its length is a power of two.
    assert_eq!(PagedBuffer::Triangles.pages((1 << 27) / 48, 1 << 27), 1);
    assert_eq!(PagedBuffer::Triangles.pages(10_000_000, 1 << 27), 5);
}

/// Bytes of the device are foretold exactly, but for nodes, and what does not fit is refused before anything is built.
#[test]
fn r12_memory_is_foretold() {
    let mut scenes: Vec<Scene> =
        ["cornell", "spheres", "bumpy-plane"].map(|name| builtin(name).unwrap()).into();
    scenes.push(paged_scene());
    for scene in &scenes {
        let features = SceneFeatures::of(scene);
        let memory = SceneMemory::of(scene, &features);
        let accel = Accel::build(scene).expect("a BVH");
        let device = DeviceScene::new(gpu::context(), scene, &accel, features).expect("a device scene");
        for &(buffer, foretold) in &memory.buffers {
            let have = device.buffers.get(buffer.name()).expect("foretold").size();
            if buffer != PagedBuffer::Nodes {
                assert_eq!(have, foretold.max(16).next_multiple_of(16), "{}: {buffer:?}", scene.name);
            } else if scene.triangle_count() > 1000 {
                assert!(have.abs_diff(foretold) < have / 5, "{}: {have} for {foretold}", scene.name);
            }
        }
        let named = |buffer: PagedBuffer| memory.buffers.iter().any(|(other, _)| *other == buffer);
        for buffer in
            PagedBuffer::ALL.iter().filter(|&&buffer| !named(buffer) && buffer != PagedBuffer::Covers)
        {
            assert!(device.buffers.get(buffer.name()).is_err(), "{}: {buffer:?}", scene.name);
        }
    }
    let scene = paged_scene();
    let mut small = gpu::context().clone();
    small.memory = Some(1 << 20);
    let error = Renderer::new(&small, &scene, options([8, 8], 1)).err().expect("too large").to_string();
    println!("{error}");
    assert!(error.contains("1.0 MiB are free") && error.contains("smaller environment"), "{error}");
    let memory = SceneMemory::of(&scene, &SceneFeatures::of(&scene));
    let error = memory.check_for(1 << 12, 8, None).expect_err("too many pages").to_string();
    println!("{error}");
    assert!(error.contains("this device has 8"), "{error}");
}
