//! Memory that is free, given back to the system.
//!
//! The allocator of Linux (glibc) keeps what was freed for each thread that had used it: half a gigabyte after some
//! scenes, of which ten megabytes were in use. Elsewhere nothing needs to be done.

/// Has the allocator of the whole process keep little: two pools for all threads in place of eight a core, which work
/// without waiting for one another as nothing allocates where work is done pixel by pixel, and at most 32 MB at the end
/// of each. Programs call it before they start threads.
pub fn keep_little() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        let limits = [(libc::M_ARENA_MAX, 2), (libc::M_MMAP_THRESHOLD, 32 << 20), (libc::M_TRIM_THRESHOLD, 32 << 20)];
        for (name, value) in limits {
            // SAFETY: these parameters take any number, at any time; what the allocator does not know it leaves alone.
            #[allow(unsafe_code, reason = "the library of the system is asked")]
            let _ = unsafe { libc::mallopt(name, value) };
        }
    }
}

/// Gives back what the last scene has left free.
pub(crate) fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the function has no conditions; it may be called by any thread at any time.
    #[allow(unsafe_code, reason = "the library of the system is asked")]
    unsafe {
        libc::malloc_trim(0);
    }
}
