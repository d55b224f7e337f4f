//! Many small pictures with captions on one page, as PNG.

use std::path::Path;

use super::png::{to_byte, write_bytes};
use super::tonemap::{ViewTransform, srgb_encode};
use super::{Picture, tonemap};
use crate::film::FilmError;

/// Pixels between pictures.
const GAP: usize = 6;
/// Height of a caption: a row of glyphs at double size, and room.
const CAPTION: usize = 2 * GLYPH_HEIGHT + 4;
const BACKGROUND: [u8; 3] = [24, 24, 27];
const INK: [u8; 3] = [225, 225, 220];

/// A picture on the page, at a column and a row, with the exposure (stops) that it is shown at.
pub struct Frame<'a> {
    pub column: usize,
    pub row: usize,
    pub caption: String,
    pub picture: &'a Picture,
    pub exposure: f32,
}

/// Draws the frames, which all have one size, on a page under a title, and writes it.
///
/// # Errors
/// [`FilmError::NonFinite`], [`FilmError::Write`].
pub fn write(path: &Path, title: &str, frames: &[Frame], view: ViewTransform) -> Result<(), FilmError> {
    let [width, height] =
        frames.first().map_or([0, 0], |frame| [frame.picture.width as usize, frame.picture.height as usize]);
    let cell = [width + GAP, height + CAPTION + GAP];
    let columns = frames.iter().map(|frame| frame.column + 1).max().unwrap_or(1);
    let rows = frames.iter().map(|frame| frame.row + 1).max().unwrap_or(1);
    let page_width = (columns * cell[0] + GAP).max(text_width(title) + 2 * GAP);
    let mut page = Page::new(page_width, CAPTION + rows * cell[1] + GAP);
    page.text([GAP, GAP], title);
    for frame in frames {
        if let Some(count) = non_finite(frame.picture) {
            return Err(FilmError::NonFinite { path: path.to_owned(), count });
        }
        let corner = [GAP + frame.column * cell[0], CAPTION + GAP + frame.row * cell[1]];
        page.text(corner, &frame.caption);
        page.picture([corner[0], corner[1] + CAPTION - 2], frame, view);
    }
    write_bytes(path, page.width as u32, (page.pixels.len() / page.width) as u32, &page.pixels)
}

fn non_finite(picture: &Picture) -> Option<usize> {
    let count = picture.non_finite_values();
    (count > 0).then_some(count)
}

struct Page {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Page {
    fn new(width: usize, height: usize) -> Self {
        Self { width, pixels: vec![BACKGROUND; width * height] }
    }

    fn set(&mut self, x: usize, y: usize, color: [u8; 3]) {
        if x < self.width
            && let Some(pixel) = self.pixels.get_mut(y * self.width + x)
        {
            *pixel = color;
        }
    }

    fn picture(&mut self, [x, y]: [usize; 2], frame: &Frame, view: tonemap::ViewTransform) {
        for (index, &radiance) in frame.picture.rgb.iter().enumerate() {
            let (column, row) = (index % frame.picture.width as usize, index / frame.picture.width as usize);
            let shown = view.display(frame.exposure, radiance).map(|linear| to_byte(srgb_encode(linear)));
            self.set(x + column, y + row, shown);
        }
    }

    /// Text at double size.
    fn text(&mut self, [x, y]: [usize; 2], text: &str) {
        for (place, character) in text.chars().enumerate() {
            for (row, bits) in glyph(character).into_iter().enumerate() {
                for column in (0..GLYPH_WIDTH).filter(|column| bits >> (GLYPH_WIDTH - 1 - column) & 1 == 1) {
                    let at = [x + 2 * (place * (GLYPH_WIDTH + 1) + column), y + 2 * row];
                    for [dx, dy] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                        self.set(at[0] + dx, at[1] + dy, INK);
                    }
                }
            }
        }
    }
}

fn text_width(text: &str) -> usize {
    2 * (GLYPH_WIDTH + 1) * text.chars().count()
}

const GLYPH_WIDTH: usize = 3;
const GLYPH_HEIGHT: usize = 5;

/// Rows of three bits, from the top. What has no glyph is blank.
fn glyph(character: char) -> [u8; GLYPH_HEIGHT] {
    match character.to_ascii_lowercase() {
        '0' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '2' => [7, 1, 7, 4, 7],
        '3' => [7, 1, 3, 1, 7],
        '4' => [5, 5, 7, 1, 1],
        '5' => [7, 4, 7, 1, 7],
        '6' => [7, 4, 7, 5, 7],
        '7' => [7, 1, 2, 2, 2],
        '8' => [7, 5, 7, 5, 7],
        '9' => [7, 5, 7, 1, 7],
        'a' => [2, 5, 7, 5, 5],
        'b' => [6, 5, 6, 5, 6],
        'c' => [3, 4, 4, 4, 3],
        'd' => [6, 5, 5, 5, 6],
        'e' => [7, 4, 6, 4, 7],
        'f' => [7, 4, 6, 4, 4],
        'g' => [3, 4, 5, 5, 3],
        'h' => [5, 5, 7, 5, 5],
        'i' => [7, 2, 2, 2, 7],
        'j' => [1, 1, 1, 5, 2],
        'k' => [5, 5, 6, 5, 5],
        'l' => [4, 4, 4, 4, 7],
        'm' => [5, 7, 7, 5, 5],
        'n' => [6, 5, 5, 5, 5],
        'o' => [2, 5, 5, 5, 2],
        'p' => [6, 5, 6, 4, 4],
        'q' => [2, 5, 5, 6, 3],
        'r' => [6, 5, 6, 5, 5],
        's' => [3, 4, 2, 1, 6],
        't' => [7, 2, 2, 2, 2],
        'u' => [5, 5, 5, 5, 7],
        'v' => [5, 5, 5, 5, 2],
        'w' => [5, 5, 7, 7, 5],
        'x' => [5, 5, 2, 5, 5],
        'y' => [5, 5, 2, 2, 2],
        'z' => [7, 1, 2, 4, 7],
        '=' => [0, 7, 0, 7, 0],
        '+' => [0, 2, 7, 2, 0],
        '-' => [0, 0, 7, 0, 0],
        '.' => [0, 0, 0, 0, 2],
        ',' => [0, 0, 0, 2, 4],
        ':' => [0, 2, 0, 2, 0],
        '%' => [5, 1, 2, 4, 5],
        '/' => [1, 1, 2, 4, 4],
        '(' => [1, 2, 2, 2, 1],
        ')' => [4, 2, 2, 2, 4],
        _ => [0; GLYPH_HEIGHT],
    }
}
