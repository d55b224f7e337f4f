//! While the library works, a crash in it ends the program with a reason and exit code 1, as any other failure of an output
//! does. What was to be lost is saved before.
#![allow(unsafe_code, reason = "handlers of signals are set by the system's C interface")]

/// Sets the handlers until it is dropped.
#[cfg(unix)]
pub(super) struct Guard {
    before: Vec<(libc::c_int, libc::sigaction)>,
}

#[cfg(unix)]
const SIGNALS: [libc::c_int; 5] = [libc::SIGSEGV, libc::SIGABRT, libc::SIGBUS, libc::SIGILL, libc::SIGFPE];

#[cfg(unix)]
const MESSAGE: &[u8] =
    b"error: the denoiser (Open Image Denoise) crashed; what was rendered has been saved without it. \
    Render without --denoise, or name another copy of the library by HALFWAY_OIDN\n";

#[cfg(unix)]
extern "C" fn crashed(_: libc::c_int) {
    // SAFETY: both may be called in a handler; the message is static.
    unsafe {
        libc::write(2, MESSAGE.as_ptr().cast(), MESSAGE.len());
        libc::_exit(1);
    }
}

#[cfg(unix)]
impl Guard {
    pub fn new() -> Self {
        let handler = crashed as extern "C" fn(libc::c_int) as libc::sighandler_t;
        let set = |signal: libc::c_int| {
            // SAFETY: both structs are plain data that the calls fill or read.
            unsafe {
                let mut action: libc::sigaction = std::mem::zeroed();
                let mut before: libc::sigaction = std::mem::zeroed();
                action.sa_sigaction = handler;
                action.sa_flags = libc::SA_ONSTACK;
                libc::sigaction(signal, &action, &mut before);
                (signal, before)
            }
        };
        Self { before: SIGNALS.map(set).into() }
    }
}

#[cfg(unix)]
impl Drop for Guard {
    fn drop(&mut self) {
        for (signal, before) in &self.before {
            // SAFETY: what stood there before.
            unsafe { libc::sigaction(*signal, before, std::ptr::null_mut()) };
        }
    }
}

/// Elsewhere a crash ends the program by itself.
#[cfg(not(unix))]
pub(super) struct Guard;

#[cfg(not(unix))]
impl Guard {
    pub fn new() -> Self {
        Self
    }
}
