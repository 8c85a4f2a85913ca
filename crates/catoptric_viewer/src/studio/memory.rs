//! Memory that is free, given back to the system.

/// Gives back what the last scene has left free. The allocator of Linux keeps such memory for each thread that has used
/// it, hundreds of megabytes after some scenes, of which no other program has anything.
pub(super) fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the function has no conditions; it may be called by any thread at any time.
    #[allow(unsafe_code, reason = "the library of the system is asked")]
    unsafe {
        libc::malloc_trim(0);
    }
}
