// What there is of every pixel lies in pages where one binding cannot hold it for the whole picture. A kernel sees one of
// them: that in which its batch lies, or each in turn.

#if film_pages
struct Page {
    /// First pixel of the page, and how many it has.
    first_pixel: u32,
    pixel_count: u32,
    pad0: u32,
    pad1: u32,
}

@group(2) @binding(4) var<uniform> page: Page;

/// A pixel's place in the page; not below `page.pixel_count` where it lies in another.
fn in_page(pixel: u32) -> u32 {
    return pixel - page.first_pixel;
}
#else
fn in_page(pixel: u32) -> u32 {
    return pixel;
}
#endif
