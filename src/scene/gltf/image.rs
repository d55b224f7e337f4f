//! Textures and images: which ones the materials use, and decoding those.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use gltf::json::texture::{MagFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use rayon::prelude::*;
use serde::Deserialize;

use super::buffers::Buffers;
use super::document::{Document, at, extension};
use super::faults::Faults;
#[cfg(feature = "compressed")]
use super::ktx2;
use super::unsupported::unsupported;
use super::{LoadOptions, uri};
use crate::scene::SceneError;
use crate::scene::texture::{Filter, Image, Texture, Wrap};

/// Collects the textures that materials ask for; each texture and each image is kept once.
#[derive(Debug)]
pub struct TextureTable<'a> {
    document: &'a Document,
    /// What each entry of `textures` is, by glTF's index of the texture.
    texture_sources: Vec<Source>,
    /// What each image is, by glTF's index of the image.
    image_sources: Vec<Source>,
    pub textures: Vec<Texture>,
}

/// What a texture or an image of the scene is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// It stands in for faulty ones.
    StandIn,
    /// One of the file.
    File(usize),
    /// One of the file, of which the alpha times this factor, as bits of an `f32`, is glossiness: its roughness.
    Gloss(usize, u32),
}

#[derive(Deserialize)]
struct AlternativeSource {
    source: Option<Index<json::Image>>,
}

/// What `gltf::json` has for a texture without a source.
const NO_SOURCE: usize = u32::MAX as usize;

impl<'a> TextureTable<'a> {
    pub fn new(document: &'a Document) -> Self {
        Self { document, texture_sources: Vec::new(), image_sources: Vec::new(), textures: Vec::new() }
    }

    /// The scene's index of glTF texture `index`, or of the roughness that its alpha times `gloss` stands for; `from`
    /// names the reference.
    ///
    /// # Errors
    /// Dangling references, textures only in a format that is not supported; where strict, unknown sampler modes.
    pub fn register(
        &mut self,
        index: Index<json::Texture>,
        gloss: Option<f32>,
        from: &str,
        faults: &mut Faults,
    ) -> Result<u32, SceneError> {
        let source_of = |index: usize| match gloss {
            Some(factor) => Source::Gloss(index, factor.to_bits()),
            None => Source::File(index),
        };
        let key = source_of(index.value());
        if let Some(known) = self.texture_sources.iter().position(|source| *source == key) {
            return Ok(known as u32);
        }
        let texture = self.document.get(index, from)?;
        let place = format!("textures[{}]", index.value());
        let extensions = texture.extensions.as_ref().map(|extensions| &extensions.others);
        let mut source = None;
        for name in ALTERNATIVES {
            let alternative: Option<AlternativeSource> = extension(extensions, name, &place)?;
            source = source.or(alternative.and_then(|alternative| alternative.source));
        }
        let plain = Some(texture.source).filter(|source| source.value() != NO_SOURCE);
        let Some(source) = source.or(plain) else {
            let names: Vec<&str> =
                extensions.into_iter().flat_map(|others| others.keys()).map(String::as_str).collect();
            return Err(if names.is_empty() {
                SceneError::invalid(place, "UNDEFINED_PROPERTY", "the texture has no source")
            } else {
                unsupported(&names)
            });
        };
        at(&self.document.images, source, &place)?;
        let (wrap, filter) = match texture.sampler {
            Some(sampler) => faults
                .or_without(&place, self.sampler(sampler, &place), "it repeats and is filtered")?
                .unwrap_or_default(),
            None => Default::default(),
        };
        if gloss.is_some() {
            // The picture itself is decoded once, and is there as the specular colour.
            self.image(Source::File(source.value()));
        }
        Ok(self.add(key, source_of(source.value()), wrap, filter))
    }

    /// The scene's index of the texture that stands in for those that are faulty: magenta all over.
    pub fn stand_in(&mut self) -> u32 {
        match self.texture_sources.iter().position(|source| *source == Source::StandIn) {
            Some(known) => known as u32,
            None => self.add(Source::StandIn, Source::StandIn, Default::default(), Filter::default()),
        }
    }

    fn add(&mut self, texture: Source, image: Source, wrap: [Wrap; 2], filter: Filter) -> u32 {
        let image = self.image(image) as u32;
        self.texture_sources.push(texture);
        self.textures.push(Texture { image, wrap, filter });
        (self.textures.len() - 1) as u32
    }

    /// The scene's index of an image.
    fn image(&mut self, source: Source) -> usize {
        self.image_sources.iter().position(|known| *known == source).unwrap_or_else(|| {
            self.image_sources.push(source);
            self.image_sources.len() - 1
        })
    }

    fn sampler(&self, index: Index<Sampler>, from: &str) -> Result<([Wrap; 2], Filter), SceneError> {
        let sampler = self.document.get(index, from)?;
        let fault = |detail: &str| {
            SceneError::invalid(format!("samplers[{}]", index.value()), "VALUE_NOT_IN_LIST", detail)
        };
        let wrap = |mode: &Checked<WrappingMode>| match mode {
            Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
            Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::Mirror),
            Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::Clamp),
            Checked::Invalid => Err(fault("a wrap mode is none of 10497, 33648 and 33071")),
        };
        let filter = match sampler.mag_filter {
            None | Some(Checked::Valid(MagFilter::Linear)) => Filter::Linear,
            Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
            Some(Checked::Invalid) => return Err(fault("its magFilter is neither 9728 nor 9729")),
        };
        Ok(([wrap(&sampler.wrap_s)?, wrap(&sampler.wrap_t)?], filter))
    }

    /// Reads and decodes the images in use, on all threads; images of the same bytes once, and `textures` then share that
    /// one. `None` for those that cannot be read, and for the one that stands in for faulty textures.
    ///
    /// # Errors
    /// More pixels than the limit; where strict, those of [`uri::fetch`] and [`decode`].
    pub fn decode_images(
        &mut self,
        buffers: &Buffers<'_>,
        base_dir: Option<&Path>,
        options: &LoadOptions,
        faults: &mut Faults,
    ) -> Result<Vec<Option<Image>>, SceneError> {
        let files = self.image_sources.par_iter().map(|source| match source {
            Source::File(index) => Some(self.read_image(*index, buffers, base_dir, options)),
            Source::StandIn | Source::Gloss(..) => None,
        });
        let files: Vec<Option<Result<Cow<'_, [u8]>, SceneError>>> = files.collect();
        let mut first_of: HashMap<&[u8], usize> = HashMap::new();
        let twins: Vec<Option<usize>> = (0..files.len())
            .map(|place| {
                let Some(Ok(bytes)) = &files[place] else { return None };
                Some(*first_of.entry(&**bytes).or_insert(place)).filter(|&first| first != place)
            })
            .collect();
        let decoded = files.into_par_iter().enumerate().map(|(place, bytes)| {
            let (bytes, Source::File(index)) = (bytes?, self.image_sources[place]) else { return None };
            if twins[place].is_some() {
                return None;
            }
            let name = self.image_name(index).map_or_else(|| format!("images[{index}]"), str::to_string);
            Some(bytes.and_then(|bytes| decode(name, &bytes, options)))
        });
        let decoded: Vec<_> = decoded.collect();

        let mut images: Vec<Option<Image>> = Vec::with_capacity(decoded.len());
        // Where each source's image is.
        let mut places: Vec<usize> = Vec::with_capacity(decoded.len());
        for (place, (decoded, &source)) in decoded.into_iter().zip(&self.image_sources).enumerate() {
            if let (Some(first), Source::File(index)) = (twins[place], source) {
                places.push(places[first]);
                if images[places[first]].is_none() {
                    let problem = "it is the same as an image before it, which cannot be read";
                    faults.note(self.image_place(index), problem, "save it again as PNG, JPEG or WebP");
                }
                continue;
            }
            places.push(images.len());
            let (Some(decoded), Source::File(index)) = (decoded, source) else {
                images.push(None);
                continue;
            };
            let part = self.image_place(index);
            let advice = match &decoded {
                Err(SceneError::Image { .. }) => "; save it again as PNG, JPEG or WebP",
                _ => "",
            };
            let remedy = format!("colours are magenta in its place, other slots do without it{advice}");
            let image = faults.or_without(&part, decoded, &remedy)?;
            if let Some((_, true)) = image {
                faults.note(part, "it has more than 8 bits per channel", "it is reduced to 8 bits");
            }
            images.push(image.map(|(image, _)| image));
        }
        for (place, &source) in self.image_sources.iter().enumerate() {
            let Source::Gloss(index, factor) = source else { continue };
            let picture = self.image_sources.iter().position(|known| *known == Source::File(index));
            let picture = picture.and_then(|picture| images[places[picture]].as_ref());
            images[places[place]] = picture.map(|picture| roughness(picture, f32::from_bits(factor)));
        }
        self.textures.iter_mut().for_each(|texture| texture.image = places[texture.image as usize] as u32);
        Ok(images)
    }

    /// The file of an image.
    fn read_image<'b>(
        &self,
        index: usize,
        buffers: &'b Buffers<'_>,
        base_dir: Option<&Path>,
        options: &LoadOptions,
    ) -> Result<Cow<'b, [u8]>, SceneError> {
        let place = format!("images[{index}]");
        let source = self.document.get(Index::<json::Image>::new(index as u32), &place)?;
        match (&source.uri, source.buffer_view) {
            (Some(uri), None) => uri::fetch(uri, base_dir, options).map(Cow::Owned),
            (None, Some(view)) => Ok(Cow::Borrowed(buffers.view(view, &place)?.bytes)),
            _ => {
                let detail = "an image needs either a uri or a bufferView";
                Err(SceneError::invalid(place, "ONE_OF_MISMATCH", detail))
            }
        }
    }

    /// What the file calls an image.
    fn image_name(&self, index: usize) -> Option<&str> {
        let source = self.document.images.get(index)?;
        let uri = source.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        source.name.as_deref().or(uri)
    }

    fn image_place(&self, index: usize) -> String {
        match self.image_name(index) {
            Some(name) => format!("images[{index}] \"{name}\""),
            None => format!("images[{index}]"),
        }
    }
}

/// Where the picture of a texture may be beside its plain source, the first one first.
const ALTERNATIVES: &[&str] = &[
    #[cfg(feature = "compressed")]
    "KHR_texture_basisu",
    "EXT_texture_webp",
];

/// The metallic-roughness picture of a surface whose glossiness is the alpha of `picture` times `factor`.
fn roughness(picture: &Image, factor: f32) -> Image {
    let largest = f32::from(u8::MAX);
    let rough = |texel: &[u8; 4]| [0, (largest - factor * f32::from(texel[3])).round() as u8, 0, u8::MAX];
    let name = format!("roughness of {}", picture.name);
    let (width, height) = (picture.width, picture.height);
    Image { name, width, height, texels: picture.texels.iter().map(rough).collect() }
}

/// What stands in for a picture that cannot be read: a colour that no scene has by intention.
pub fn magenta(name: &str) -> Image {
    Image { name: name.into(), width: 1, height: 1, texels: vec![[255, 0, 255, 255]] }
}

/// Decodes a PNG, JPEG, WebP or, in builds with the feature `compressed`, KTX 2.0 picture, recognised by its first bytes
/// as glTF asks. The flag is true where it had more than 8 bits per channel.
///
/// # Errors
/// [`SceneError::Image`] for anything undecodable, [`SceneError::Limit`] for too many pixels.
fn decode(name: String, bytes: &[u8], options: &LoadOptions) -> Result<(Image, bool), SceneError> {
    let fault = |detail: String| SceneError::Image { name: name.clone(), detail };
    #[cfg(feature = "compressed")]
    if bytes.starts_with(&ktx2::MAGIC) {
        let limit = options.limits.image_pixels;
        let picture = catch_unwind(AssertUnwindSafe(|| ktx2::decode(bytes, limit)))
            .map_err(|_| fault("the decoder failed".into()))?
            .map_err(|error| match error {
                ktx2::Fault::TooLarge(count) => {
                    SceneError::Limit { what: "pixels in one image", count, limit }
                }
                ktx2::Fault::Unreadable(detail) => fault(detail),
            })?;
        let ktx2::Picture { size: [width, height], texels } = picture;
        return Ok((Image { name, width, height, texels }, false));
    }
    let format = image::guess_format(bytes).map_err(|error| fault(error.to_string()))?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) {
        return Err(fault(format!("{format:?} is not a format that glTF allows")));
    }
    // The decoders meet hostile files here; should one of them panic, that is an undecodable image.
    let picture = catch_unwind(AssertUnwindSafe(|| decode_checked(bytes, format, options)))
        .map_err(|_| fault("the decoder failed".into()))?
        .map_err(|error| match error {
            DecodeFault::TooLarge(count) => {
                SceneError::Limit { what: "pixels in one image", count, limit: options.limits.image_pixels }
            }
            DecodeFault::Decoder(error) => fault(error.to_string()),
        })?;

    let eight_bits =
        matches!(picture.color(), ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8);
    let rgba = picture.into_rgba8();
    let (width, height) = rgba.dimensions();
    if width == 0 || height == 0 {
        return Err(fault(format!("it is {width} x {height} pixels")));
    }
    let texels = rgba.pixels().map(|pixel| pixel.0).collect();
    Ok((Image { name, width, height, texels }, !eight_bits))
}

enum DecodeFault {
    TooLarge(u64),
    Decoder(image::ImageError),
}

impl From<image::ImageError> for DecodeFault {
    fn from(error: image::ImageError) -> Self {
        Self::Decoder(error)
    }
}

fn decode_checked(
    bytes: &[u8],
    format: ImageFormat,
    options: &LoadOptions,
) -> Result<DynamicImage, DecodeFault> {
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder()?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels > options.limits.image_pixels {
        return Err(DecodeFault::TooLarge(pixels));
    }
    Ok(DynamicImage::from_decoder(decoder)?)
}
