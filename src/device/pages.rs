//! Buffers of a scene that may be longer than what a device binds at once: they lie in pages, a binding each.
//!
//! A shader declares such a buffer as one array on a line of its own, and reads `name[index]`. As long as one page holds all
//! of it, the text stays as it is. Where it takes more, the stitcher puts an array for each page beside the declaration, and
//! a call of a function that chooses among them in place of each reading: [`paged`].

use wgpu::BufferUsages;

use super::buffer::{BufferTable, read_back};
use super::context::Context;
use crate::device::DeviceError;

/// The most pages of one buffer.
pub const MOST_PAGES: u64 = 64;
/// Group 0 has its other bindings below this one.
const FIRST_BINDING: u32 = 32;
/// What is written between two waits: the driver keeps a copy of it until then.
const WRITTEN_AT_ONCE: u64 = 64 << 20;

macro_rules! paged_buffers {
    ($($variant:ident $name:literal $element:literal,)*) => {
        /// A buffer that may have pages.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum PagedBuffer { $($variant,)* }

        impl PagedBuffer {
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// As the shaders call it, and [`BufferTable`] its first page.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Bytes of an element.
            pub fn element(self) -> u64 {
                match self { $(Self::$variant => $element,)* }
            }

            /// The `override` constant that says how many bits of an index are those within a page.
            fn bits_name(self) -> &'static str {
                match self { $(Self::$variant => concat!($name, "_page_bits"),)* }
            }
        }
    };
}

paged_buffers! {
    Nodes "nodes" 80,
    Triangles "triangles" 48,
    Covers "covers" 4,
    CornerVertices "corner_vertices" 4,
    VertexAttributes "vertex_attributes" 4,
    Texels "texels" 4,
    EnvironmentTexels "environment_texels" 8,
    EnvironmentAlias "environment_alias" 8,
    Instances "instances" 128,
    InstanceBlocks "instance_blocks" 4,
}

const KINDS: usize = PagedBuffer::ALL.len();

/// How many pages each buffer has beyond its first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Pages([u8; KINDS]);

impl Pages {
    /// Pages of a buffer, at least one.
    pub fn of(self, buffer: PagedBuffer) -> u32 {
        u32::from(self.0[buffer as usize]) + 1
    }

    /// Bindings beyond those of a scene with one page each.
    pub fn extra(self) -> u32 {
        self.0.iter().map(|&more| u32::from(more)).sum()
    }

    /// `count`: at least 1, at most [`MOST_PAGES`].
    pub fn set(&mut self, buffer: PagedBuffer, count: u64) {
        self.0[buffer as usize] = count.clamp(1, MOST_PAGES) as u8 - 1;
    }
}

impl PagedBuffer {
    /// Bits of an index within a page, for pages of at most `page_bytes` bytes.
    pub fn page_bits(self, page_bytes: u64) -> u32 {
        (page_bytes / self.element()).max(1).ilog2()
    }

    /// Pages that so many elements take; at least one.
    pub fn pages(self, elements: u64, page_bytes: u64) -> u64 {
        // All of it in one page that is not a power of two, where that is what fits.
        if elements * self.element() <= page_bytes {
            return 1;
        }
        elements.div_ceil(1 << self.page_bits(page_bytes))
    }

    /// The name of a page.
    fn page_name(self, page: u64) -> String {
        if page == 0 { self.name().into() } else { format!("{}_{page}", self.name()) }
    }

    /// Its pages, in order.
    pub fn buffers(self, buffers: &BufferTable) -> impl Iterator<Item = &wgpu::Buffer> {
        (0..MOST_PAGES).map_while(move |page| buffers.get(&self.page_name(page)).ok())
    }

    /// Gives its pages back.
    pub fn remove(self, buffers: &mut BufferTable) {
        (0..MOST_PAGES).for_each(|page| buffers.unshare(&self.page_name(page)));
    }

    /// What a device with ray queries does with it beside binding it.
    fn usage(self, context: &Context) -> BufferUsages {
        match self == Self::Triangles && context.ray_queries() {
            true => BufferUsages::STORAGE | BufferUsages::BLAS_INPUT,
            false => BufferUsages::STORAGE,
        }
    }

    fn binding(self, page: u32) -> u32 {
        FIRST_BINDING + self as u32 * MOST_PAGES as u32 + page
    }

    /// Reads all pages back.
    ///
    /// # Errors
    /// A lost device, no such buffer.
    pub fn read<T: bytemuck::Pod>(
        self,
        context: &Context,
        buffers: &BufferTable,
    ) -> Result<Vec<T>, DeviceError> {
        let mut all = buffers.read_all(context, self.name())?;
        for page in self.buffers(buffers).skip(1) {
            let bytes = read_back(context, page, page.size())?;
            all.extend(bytemuck::pod_collect_to_vec::<u8, T>(&bytes));
        }
        Ok(all)
    }
}

/// Fills a buffer from its beginning to its end, in as many pages as it takes.
pub struct PageWriter<'a> {
    context: &'a Context,
    buffers: &'a mut BufferTable,
    buffer: PagedBuffer,
    page_size: u64,
    pages: u64,
    /// Bytes so far, and those that the driver may still have a copy of.
    written: u64,
    pending: u64,
}

impl<'a> PageWriter<'a> {
    /// Makes room for so many elements.
    ///
    /// # Errors
    /// [`DeviceError::TooManyPages`], [`DeviceError::OutOfMemory`].
    pub fn new(
        context: &'a Context,
        buffers: &'a mut BufferTable,
        buffer: PagedBuffer,
        elements: u64,
    ) -> Result<Self, DeviceError> {
        let pages = buffer.pages(elements, context.page_bytes);
        let bytes = elements * buffer.element();
        if pages > MOST_PAGES {
            let limit = MOST_PAGES << buffer.page_bits(context.page_bytes);
            return Err(DeviceError::BufferTooLarge {
                name: buffer.name().into(),
                bytes,
                limit: limit * buffer.element(),
            });
        }
        let page_size =
            if pages == 1 { bytes } else { buffer.element() << buffer.page_bits(context.page_bytes) };
        for page in 0..pages {
            let rest = (bytes - page * page_size).min(page_size).max(buffer.element());
            buffers.create_with(context, &buffer.page_name(page), rest, buffer.usage(context))?;
        }
        Ok(Self { context, buffers, buffer, page_size, pages, written: 0, pending: 0 })
    }

    /// Appends whole elements.
    ///
    /// # Errors
    /// A lost device.
    pub fn push<T: bytemuck::Pod>(&mut self, data: &[T]) -> Result<(), DeviceError> {
        let mut bytes: &[u8] = bytemuck::cast_slice(data);
        while !bytes.is_empty() {
            let (page, offset) = (self.written / self.page_size, self.written % self.page_size);
            let count = (self.page_size - offset).min(WRITTEN_AT_ONCE / 4).min(bytes.len() as u64);
            let (now, later) = bytes.split_at(count as usize);
            let target = self.buffers.get(&self.buffer.page_name(page))?;
            self.context.queue.write_buffer(target, offset, now);
            self.written += count;
            self.pending += count;
            if self.pending >= WRITTEN_AT_ONCE {
                self.context.queue.submit([]);
                self.context.wait()?;
                self.pending = 0;
            }
            bytes = later;
        }
        Ok(())
    }

    /// Says how many pages there are, and what the kernels are told of them.
    pub fn finish(self, pages: &mut Pages, constants: &mut Vec<(&'static str, f64)>) {
        pages.set(self.buffer, self.pages);
        if self.pages > 1 {
            let bits = self.buffer.page_bits(self.context.page_bytes);
            constants.push((self.buffer.bits_name(), f64::from(bits)));
        }
    }
}

/// A line of a stitched text with the buffers that have more than one page read by page: the lines in its place.
///
/// # Errors
/// A reading that does not end on its line.
pub fn paged(line: &str, pages: Pages) -> Result<Option<String>, String> {
    // Readings have a bracket, declarations an angle; most lines have neither, and most scenes no pages.
    if pages.extra() == 0 || !line.contains(['[', '<']) {
        return Ok(None);
    }
    let several = || PagedBuffer::ALL.iter().copied().filter(|&buffer| pages.of(buffer) > 1);
    let (code, comment) = line.split_at(line.find("//").unwrap_or(line.len()));
    if code.contains("var<") {
        for buffer in several() {
            let declared = format!("var<storage, read> {}: array<", buffer.name());
            if let Some((_, element)) = code.split_once(&declared) {
                let element = element.trim_end().trim_end_matches(">;");
                return Ok(Some(format!("{line}\n{}", functions(buffer, element, pages.of(buffer)))));
            }
        }
    }
    let mut code = code.to_string();
    let mut is_changed = false;
    for buffer in several() {
        while let Some((start, end)) = reading(&code, buffer.name())? {
            let index = &code[start + buffer.name().len() + 1..end];
            code = format!("{}paged_{}({index}){}", &code[..start], buffer.name(), &code[end + 1..]);
            is_changed = true;
        }
    }
    Ok(is_changed.then(|| code + comment))
}

/// Where `name[...]` begins, and where its last bracket is.
fn reading(code: &str, name: &str) -> Result<Option<(usize, usize)>, String> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let found = code
        .match_indices(name)
        .find(|(start, _)| code[start + name.len()..].starts_with('[') && !code[..*start].ends_with(is_name));
    let Some((start, _)) = found else { return Ok(None) };
    let mut depth = 0;
    for (at, c) in code[start..].char_indices() {
        depth += i32::from(c == '[') - i32::from(c == ']');
        if c == ']' && depth == 0 {
            return Ok(Some((start, start + at)));
        }
    }
    Err(format!("a reading of '{name}' has to end on its line: it may be in pages"))
}

/// Declarations of the pages beyond the first, on lines of their own, and the function that reads them.
fn functions(buffer: PagedBuffer, element: &str, pages: u32) -> String {
    let (name, bits) = (buffer.name(), buffer.bits_name());
    let declared = |page: u32| {
        let binding = buffer.binding(page);
        format!("@group(0) @binding({binding}) var<storage, read> {name}_{page}: array<{element}>;\n")
    };
    let case = |page: u32| format!("        case {page}u: {{ return {name}_{page}[within]; }}\n");
    format!(
        "{}override {bits}: u32 = 16u;\nfn paged_{name}(index: u32) -> {element} {{\n    \
         let within = index & ((1u << {bits}) - 1u);\n    switch index >> {bits} {{\n{}        \
         default: {{ return {name}[within]; }}\n    }}\n}}",
        (1..pages).map(declared).collect::<String>(),
        (1..pages).map(case).collect::<String>(),
    )
}
