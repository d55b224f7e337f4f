//! What is used of Open Image Denoise's C interface (`OpenImageDenoise/oidn.h`, 2.x), opened at run time. All that is
//! unsafe of the film stands here.
//!
//! A device and what is made on it are used by one thread at a time, as the library wants it; images are copied into its
//! own buffers, so that devices which cannot read the host's memory work as well.
#![allow(
    unsafe_code,
    reason = "a C library that is opened at run time: nothing but its header says what its functions take"
)]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;

use super::crash;

/// `OIDN_FORMAT_FLOAT3`
const FLOAT3: c_int = 3;
const PIXEL_BYTES: usize = 12;
/// The part of the interface that is used came with 2.0, and stays through 2.x.
const MAJOR_VERSION: c_int = 2;

macro_rules! functions {
    ($($name:ident: $symbol:literal, ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Functions {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            /// The library is Open Image Denoise 2.x.
            unsafe fn of(library: &libloading::Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of the header.
                unsafe { Ok(Self { $($name: *library.get($symbol)?,)* }) }
            }
        }
    };
}

functions! {
    new_device: b"oidnNewDevice\0", (c_int) -> *mut c_void;
    commit_device: b"oidnCommitDevice\0", (*mut c_void);
    device_int: b"oidnGetDeviceInt\0", (*mut c_void, *const c_char) -> c_int;
    device_error: b"oidnGetDeviceError\0", (*mut c_void, *mut *const c_char) -> c_int;
    release_device: b"oidnReleaseDevice\0", (*mut c_void);
    new_buffer: b"oidnNewBuffer\0", (*mut c_void, usize) -> *mut c_void;
    write_buffer: b"oidnWriteBuffer\0", (*mut c_void, usize, usize, *const c_void);
    read_buffer: b"oidnReadBuffer\0", (*mut c_void, usize, usize, *mut c_void);
    release_buffer: b"oidnReleaseBuffer\0", (*mut c_void);
    new_filter: b"oidnNewFilter\0", (*mut c_void, *const c_char) -> *mut c_void;
    set_image: b"oidnSetFilterImage\0",
        (*mut c_void, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_bool: b"oidnSetFilterBool\0", (*mut c_void, *const c_char, bool);
    set_float: b"oidnSetFilterFloat\0", (*mut c_void, *const c_char, f32);
    commit_filter: b"oidnCommitFilter\0", (*mut c_void);
    execute_filter: b"oidnExecuteFilter\0", (*mut c_void);
    release_filter: b"oidnReleaseFilter\0", (*mut c_void);
}

/// The opened library. It stays open until the program ends: its threads may outlive what they worked on.
pub(super) struct Library {
    functions: &'static Functions,
}

/// What computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DeviceKind {
    /// A GPU that the library can use, else the CPU.
    Fastest = 0,
    Cpu = 1,
}

/// One run of the filter `RT` over `width * height` pixels.
pub(super) struct Job<'a> {
    pub width: usize,
    pub height: usize,
    /// By their names, each with as many pixels: colours without limits, and what is taken as free of noise beside them.
    pub images: &'a [(&'static CStr, &'a [[f32; 3]])],
    /// What colours are multiplied by before the filter looks at them, as if by an exposure.
    pub input_scale: f32,
}

impl Library {
    /// Opens the library at a path, or by a name that the system looks for.
    ///
    /// # Errors
    /// The loader's reason.
    pub fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: the file was named by the user, the set-up or the system as this library; its initialisers have no
        // conditions of their own.
        let library = unsafe { libloading::Library::new(path) }.map_err(|error| error.to_string())?;
        // SAFETY: as above; a file without these functions is refused.
        let functions = unsafe { Functions::of(&library) }
            .map_err(|error| format!("it is no Open Image Denoise {MAJOR_VERSION}.x: {error}"))?;
        std::mem::forget(library);
        Ok(Self { functions: Box::leak(Box::new(functions)) })
    }

    /// Makes a device.
    ///
    /// # Errors
    /// The library's reason, such as a processor that it does not support.
    pub fn device(&self, kind: DeviceKind) -> Result<Device, String> {
        let _guard = crash::Guard::new();
        let functions = self.functions;
        // SAFETY: a null device is refused before it is used, and its error is the calling thread's.
        let device = unsafe {
            let device = Device { functions, handle: (functions.new_device)(kind as c_int) };
            if !device.handle.is_null() {
                (functions.commit_device)(device.handle);
            }
            device
        };
        device.check()?;
        match device.version() / 10_000 {
            MAJOR_VERSION => Ok(device),
            _ => Err(format!("its version is {}, {MAJOR_VERSION}.x is needed", device.version_text())),
        }
    }
}

/// A device of the library.
pub(super) struct Device {
    functions: &'static Functions,
    handle: *mut c_void,
}

// SAFETY: the library allows its objects to be used from any thread, one at a time; `Device` is not `Sync`.
unsafe impl Send for Device {}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: made by this library, and released once.
            unsafe { (self.functions.release_device)(self.handle) }
        }
    }
}

impl Device {
    fn int(&self, name: &CStr) -> c_int {
        // SAFETY: the device was checked when it was made.
        unsafe { (self.functions.device_int)(self.handle, name.as_ptr()) }
    }

    fn version(&self) -> c_int {
        self.int(c"version")
    }

    /// As `2.5.1`.
    pub fn version_text(&self) -> String {
        let version = self.version();
        format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    /// It is the CPU.
    pub fn is_cpu(&self) -> bool {
        self.int(c"type") == DeviceKind::Cpu as c_int
    }

    /// What has gone wrong since this was asked last.
    fn check(&self) -> Result<(), String> {
        let mut message: *const c_char = std::ptr::null();
        // SAFETY: a null device is allowed here; the message is valid until the next call, and copied at once.
        unsafe {
            let code = (self.functions.device_error)(self.handle, &mut message);
            if code == 0 && !self.handle.is_null() {
                return Ok(());
            }
            let reason = if message.is_null() {
                format!("error {code} without a reason")
            } else {
                CStr::from_ptr(message).to_string_lossy().into_owned()
            };
            Err(reason)
        }
    }

    /// Runs the filter.
    ///
    /// # Errors
    /// The library's reason: mostly no memory.
    pub fn run(&self, job: &Job) -> Result<Vec<[f32; 3]>, String> {
        let _guard = crash::Guard::new();
        let pixels = job.width * job.height;
        let mut result = vec![[0.0f32; 3]; pixels];
        let mut objects = Objects { device: self, buffers: Vec::new(), filter: std::ptr::null_mut() };
        let f = self.functions;
        // SAFETY: every object is checked before it is used, and freed by `objects`. Sizes in bytes are those of the slices,
        // which hold `pixels` pixels each.
        unsafe {
            objects.filter = (f.new_filter)(self.handle, c"RT".as_ptr());
            if objects.filter.is_null() {
                return Err(self.reason());
            }
            let filter = objects.filter;
            let image = |name: &CStr, buffer: *mut c_void| {
                (f.set_image)(filter, name.as_ptr(), buffer, FLOAT3, job.width, job.height, 0, 0, 0);
            };
            let bytes = pixels * PIXEL_BYTES;
            for (name, values) in job.images {
                assert_eq!(values.len(), pixels, "an image of another size");
                let buffer = self.buffer(bytes)?;
                objects.buffers.push(buffer);
                (f.write_buffer)(buffer, 0, bytes, values.as_ptr().cast());
                image(name, buffer);
            }
            let output = self.buffer(bytes)?;
            objects.buffers.push(output);
            image(c"output", output);
            (f.set_bool)(filter, c"hdr".as_ptr(), true);
            (f.set_bool)(filter, c"cleanAux".as_ptr(), job.images.len() > 1);
            (f.set_float)(filter, c"inputScale".as_ptr(), job.input_scale);
            (f.commit_filter)(filter);
            (f.execute_filter)(filter);
            self.check()?;
            (f.read_buffer)(output, 0, bytes, result.as_mut_ptr().cast());
        }
        self.check()?;
        Ok(result)
    }

    fn buffer(&self, bytes: usize) -> Result<*mut c_void, String> {
        // SAFETY: the device was checked when it was made.
        let buffer = unsafe { (self.functions.new_buffer)(self.handle, bytes) };
        if buffer.is_null() { Err(self.reason()) } else { Ok(buffer) }
    }

    /// Why there is a null where there should be an object.
    fn reason(&self) -> String {
        self.check().err().unwrap_or_else(|| "it made nothing, and gave no reason".into())
    }
}

/// What a run has made, freed when it ends, however it ends.
struct Objects<'a> {
    device: &'a Device,
    buffers: Vec<*mut c_void>,
    filter: *mut c_void,
}

impl Drop for Objects<'_> {
    fn drop(&mut self) {
        let f = self.device.functions;
        // SAFETY: made by this library, and released once; the filter first, which refers to the buffers.
        unsafe {
            if !self.filter.is_null() {
                (f.release_filter)(self.filter);
            }
            self.buffers.iter().for_each(|&buffer| (f.release_buffer)(buffer));
        }
    }
}
