//! Pictures on disk: what is written is what is read, and a failure costs nothing.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, LayerAttributes, LineOrder,
    MetaData, Vec2, WritableImage, f16,
};
use halfway::film::tonemap::{ViewTransform, srgb_decode, srgb_encode};
use halfway::film::{Attribute, FilmError, Picture, exr as film_exr, png as film_png, write::write_atomic};
use halfway::picture_file::PictureFile;

/// A picture with every layer we write, over the whole range of `f32`.
fn full_picture() -> Picture {
    let (width, height) = (37, 23);
    let count = width * height;
    let value =
        |index: usize, seed: f32| (seed * index as f32).sin().abs() * 2f32.powi(index as i32 % 200 - 100);
    let rgb = (0..count).map(|i| [value(i, 0.1), value(i, 0.2), -value(i, 0.3)]).collect();
    let mut picture = Picture::new(width as u32, height as u32, rgb);
    let layers =
        [("albedo", "RGB"), ("normal", "XYZ"), ("depth", "Z"), ("variance", "RGB"), ("samples", "Y")];
    for (layer, channels) in layers {
        for (index, channel) in channels.chars().enumerate() {
            let samples = (0..count).map(|i| value(i, 1.0 + index as f32)).collect();
            picture.push_channel(layer, &channel.to_string(), samples);
        }
    }
    picture.metadata = vec![
        ("commandLine".into(), Attribute::Text("halfway render Häuschen.glb -o 猫.exr".into())),
        ("integrator".into(), Attribute::Text("path".into())),
        ("renderSeconds".into(), Attribute::Number(1.0 / 3.0)),
        ("seed".into(), Attribute::Number(9_007_199_254_740_991.0)),
    ];
    picture
}

#[test]
fn exr_round_trip_keeps_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("full.exr");
    let picture = full_picture();
    film_exr::write(&path, &picture).unwrap();
    let back = Picture::read(&path).unwrap();
    assert_eq!((back.width, back.height), (37, 23));
    assert_eq!(back.rgb, picture.rgb);
    assert_eq!(back.metadata, picture.metadata);
    let channel_count =
        |picture: &Picture| picture.layers.iter().map(|layer| layer.channels.len()).sum::<usize>();
    assert_eq!(channel_count(&back), channel_count(&picture));
    for layer in &picture.layers {
        for (name, samples) in &layer.channels {
            assert_eq!(back.channel(&layer.name, name), Some(samples.as_slice()), "{}.{name}", layer.name);
        }
    }
    let header = &MetaData::read_from_file(&path, true).unwrap().headers[0];
    let declared = header.shared_attributes.chromaticities.unwrap();
    assert_eq!((declared.red, declared.white), (Vec2(0.64, 0.33), Vec2(0.3127, 0.3290)));
    assert_eq!(header.compression, Compression::ZIP16);
    assert_eq!(header.blocks, exr::meta::BlockDescription::ScanLines);
}

#[test]
fn exr_reads_half_integer_and_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mixed.exr");
    let size = Vec2(50, 20);
    let values = |scale: u32| (0..1000).map(move |i| i * scale);
    let channels = [
        AnyChannel::new("R", FlatSamples::F16(values(1).map(|v| f16::from_f32(v as f32)).collect())),
        AnyChannel::new("G", FlatSamples::U32(values(2).collect())),
        AnyChannel::new("B", FlatSamples::F32(values(3).map(|v| v as f32).collect())),
    ];
    let encoding = Encoding {
        compression: Compression::PIZ,
        blocks: Blocks::Tiles(Vec2(16, 16)),
        line_order: LineOrder::Unspecified,
    };
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = exr::image::Layer::new(size, LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let picture = Picture::read(&path).unwrap();
    for (i, pixel) in picture.rgb.iter().enumerate() {
        let i = i as f32;
        assert_eq!(*pixel, [i, 2.0 * i, 3.0 * i]);
    }
}

#[test]
fn foreign_primaries_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("acescg.exr");
    let channels = ["R", "G", "B"].map(|name| AnyChannel::new(name, FlatSamples::F32(vec![1.0])));
    let mut image = Image::from_channels((1, 1), AnyChannels::sort(channels.into_iter().collect()));
    image.attributes.chromaticities = Some(exr::meta::attribute::Chromaticities {
        red: Vec2(0.713, 0.293),
        green: Vec2(0.165, 0.830),
        blue: Vec2(0.128, 0.044),
        white: Vec2(0.32168, 0.33767),
    });
    image.write().to_file(&path).unwrap();
    let message = Picture::read(&path).unwrap_err().to_string();
    assert!(message.contains("Rec.709"), "{message}");
}

#[test]
fn radiance_hdr_and_pfm_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    let pixels = [image::Rgb([1.0f32, 0.5, 0.25]), image::Rgb([4096.0, 0.0, 32.0])];
    let file = std::fs::File::create(&path).unwrap();
    image::codecs::hdr::HdrEncoder::new(file).encode(&pixels, 2, 1).unwrap();
    let picture = Picture::read(&path).unwrap();
    assert_eq!((picture.width, picture.height), (2, 1));
    assert_eq!(picture.rgb, [[1.0, 0.5, 0.25], [4096.0, 0.0, 32.0]]);

    let path = folder.path().join("map.pfm");
    let mut bytes = b"PF\n1 2\n-1.0\n".to_vec();
    bytes.extend([1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(Picture::read(&path).unwrap().rgb, [[4.0, 5.0, 6.0], [1.0, 2.0, 3.0]], "bottom row first");
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    assert!(Picture::read(&path).unwrap_err().to_string().contains("announced"));
}

/// A picture of one pixel, (2, 4, 8) in the file, with these lines for a header.
fn radiance_hdr(header: &str) -> PictureFile {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    let mut bytes = format!("{header}\n\n-Y 1 +X 1\n").into_bytes();
    bytes.extend([32, 64, 128, 132]);
    std::fs::write(&path, &bytes).unwrap();
    PictureFile::read(&path, None).unwrap()
}

#[test]
fn radiance_hdr_header_is_honoured() {
    for (header, want) in [
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe", [2.0, 4.0, 8.0]),
        ("#?RGBE\nFORMAT=32-bit_rle_rgbe", [2.0, 4.0, 8.0]),
        ("#?RADIANCE\npfilt -1 -e 2\n# made by hand\nVIEW= -vtv", [2.0, 4.0, 8.0]),
        ("#?RADIANCE\nEXPOSURE=2.0", [1.0, 2.0, 4.0]),
        ("#?RADIANCE\nEXPOSURE= 4\nEXPOSURE=0.5", [1.0, 2.0, 4.0]),
        ("#?RGBE\nCOLORCORR=1 2 4\nEXPOSURE=2", [1.0, 1.0, 1.0]),
    ] {
        let file = radiance_hdr(header);
        assert_eq!(file.colors(None).unwrap().rgb, [want], "{header}");
        assert!(file.notes.is_empty(), "{header}: {:?}", file.notes);
    }
    for line in ["EXPOSURE=0", "EXPOSURE=-1", "EXPOSURE=bright", "EXPOSURE=nan", "COLORCORR=1 2"] {
        let file = radiance_hdr(&format!("#?RADIANCE\n{line}"));
        assert_eq!(file.colors(None).unwrap().rgb, [[2.0, 4.0, 8.0]], "{line}");
        assert!(file.notes.len() == 1 && file.notes[0].contains(line), "{:?}", file.notes);
    }
}

#[test]
fn bad_pictures_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        Picture::read(&path).unwrap_err().to_string()
    };
    for (name, bytes, expected) in [
        ("empty.exr", &b""[..], "not OpenEXR"),
        ("text.exr", b"this is no picture at all", "not OpenEXR"),
        ("text.hdr", b"this is no picture at all", "not Radiance HDR"),
        ("text.pfm", b"this is no picture at all", "not a portable float map"),
        ("huge.pfm", b"PF 99999 99999 -1.0 ", "scale it down"),
        ("text.png", b"this is no picture at all", "not PNG"),
        ("picture.tga", b"", "convert it to OpenEXR"),
    ] {
        let message = read(name, bytes);
        assert!(message.contains(name) && message.contains(expected), "{name}: {message}");
    }
    let gone = Picture::read(&folder.path().join("gone.exr")).unwrap_err().to_string();
    assert!(gone.contains("gone.exr") && gone.contains("No such file"), "{gone}");

    let path = folder.path().join("only.exr");
    let depth = AnyChannels::sort([AnyChannel::new("Z", FlatSamples::F32(vec![1.0]))].into_iter().collect());
    Image::from_channels((1, 1), depth).write().to_file(&path).unwrap();
    assert!(Picture::read(&path).unwrap_err().to_string().contains("only Z"));
}

#[test]
fn bad_pictures_truncated_exr_never_reads_as_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.exr");
    film_exr::write(&path, &full_picture()).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in (0..whole.len()).step_by(whole.len() / 50) {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(Picture::read(&path).is_err(), "{length} of {} bytes", whole.len());
    }
}

fn files_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder of the test's own");
    entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn r04_failed_write_is_reported_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let picture = full_picture();
    let missing = folder.path().join("missing/picture.exr");
    let message = film_exr::write(&missing, &picture).unwrap_err().to_string();
    assert!(message.contains("missing/picture.exr") && message.contains("os error 2"), "{message}");

    let directory = folder.path().join("directory.exr");
    std::fs::create_dir(&directory).unwrap();
    assert!(matches!(film_exr::write(&directory, &picture), Err(FilmError::Write { .. })));
    assert_eq!(files_in(folder.path()), ["directory.exr"]);
    assert!(files_in(&directory).is_empty());
}

#[test]
#[cfg(target_os = "linux")]
fn r04_device_full_is_reported() {
    let message = film_exr::write(Path::new("/dev/full"), &full_picture()).unwrap_err().to_string();
    assert!(message.contains("os error 28"), "{message}");
    let message = film_png::write(
        Path::new("/dev/full"),
        &Picture::new(1, 1, vec![[0.0; 3]]),
        ViewTransform::Srgb,
        0.0,
    )
    .unwrap_err();
    assert!(message.to_string().contains("os error 28"), "{message}");
    assert!(Path::new("/dev/full").exists());
}

#[test]
#[cfg(unix)]
fn r04_link_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real.txt"), folder.path().join("link.txt"));
    std::fs::write(&real, b"old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write_atomic(&link, b"new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(std::fs::read(&real).unwrap(), b"new");
    assert_eq!(files_in(folder.path()).len(), 2);
}

#[test]
fn png_is_srgb_and_to_the_nearest_level() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grey.png");
    let rgb: Vec<[f32; 3]> = (0..256).map(|i| [srgb_decode(i as f32 / 255.0); 3]).collect();
    let picture = Picture::new(256, 1, rgb);
    film_png::write(&path, &picture, ViewTransform::Srgb, 0.0).unwrap();
    let bytes = image::open(&path).unwrap().into_rgb8();
    for (i, pixel) in bytes.pixels().enumerate() {
        assert_eq!(pixel.0, [i as u8; 3]);
    }
    let reader = png::Decoder::new(std::io::Cursor::new(std::fs::read(&path).unwrap())).read_info().unwrap();
    assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::RelativeColorimetric));
    let back = Picture::read(&path).unwrap();
    for (have, want) in back.rgb.iter().zip(&picture.rgb) {
        assert!((have[0] - want[0]).abs() <= 1e-6 * (1.0 + want[0]), "{have:?} {want:?}");
    }
    film_png::write(&path, &picture, ViewTransform::Srgb, -1.0).unwrap();
    let darker = Picture::read(&path).unwrap();
    assert!((darker.rgb[255][0] - 0.5).abs() < 0.005, "one stop is a factor of two");

    let broken = Picture::new(2, 1, vec![[0.0; 3], [0.0, f32::NAN, 0.0]]);
    let message = film_png::write(&path, &broken, ViewTransform::Neutral, 0.0).unwrap_err().to_string();
    assert!(message.contains("1 pixels are NaN or infinite"), "{message}");
}

#[test]
fn srgb_curve_is_its_own_inverse() {
    for i in 0..=1000 {
        let x = i as f32 / 1000.0;
        assert!((srgb_decode(srgb_encode(x)) - x).abs() < 2e-6, "{x}");
    }
    assert!((srgb_encode(0.214_041_14) - 0.5).abs() < 1e-6);
}

#[test]
fn views_follow_their_sources() {
    // PBR Neutral: below the shoulder only the Fresnel offset of 0.04 is taken away.
    let shown = ViewTransform::Neutral.display(0.0, [0.5, 0.3, 0.2]);
    for (have, want) in shown.iter().zip([0.46, 0.26, 0.16]) {
        assert!((have - want).abs() < 1e-6, "{shown:?}");
    }
    // At the peak 1.04, that is 1 after the offset: 1 - 0.24^2 / (1 + 0.24 - 0.76) = 0.88.
    let shown = ViewTransform::Neutral.display(0.0, [1.04; 3]);
    assert!((shown[1] - 0.88).abs() < 1e-6, "{shown:?}");
    // AgX: middle grey lands at half the signal, by the fit evaluated by hand at log2(0.18).
    let grey = srgb_encode(ViewTransform::Agx.display(0.0, [0.18; 3])[0]);
    assert!((0.49..0.51).contains(&grey), "{grey}");
    for view in [ViewTransform::Neutral, ViewTransform::Srgb, ViewTransform::Agx] {
        let mut last = [-1.0; 3];
        for stop in -20..=20 {
            let shown = view.display(stop as f32, [0.2, 0.5, 0.9]);
            assert!(shown.iter().all(|v| (0.0..=1.0).contains(v)), "{view:?} {stop} {shown:?}");
            let sum = |c: [f32; 3]| c.iter().sum::<f32>();
            assert!(sum(shown) >= sum(last) - 1e-4, "{view:?} darkens at {stop}");
            last = shown;
        }
        assert_eq!(view.display(0.0, [0.0; 3]).map(|v| (v * 255.0).round()), [0.0; 3], "{view:?}");
    }
}
