//! The program `catoptric`.

use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_device_selection();
    catoptric_cli::run(std::env::args_os())
}

/// Switches off a layer of Mesa's Vulkan drivers that asks the window system for its device: without a session of one
/// that writes lines on standard error, and adapters are sorted here anyway.
fn quiet_device_selection() {
    let is_set = |name: &str| std::env::var_os(name).is_some();
    if !["XDG_RUNTIME_DIR", "MESA_VK_DEVICE_SELECT", "NODEVICE_SELECT"].into_iter().any(is_set) {
        #[allow(unsafe_code, reason = "no other thread runs yet that could read the environment meanwhile")]
        // SAFETY: this is the first thing that the program does, on its only thread.
        unsafe {
            std::env::set_var("NODEVICE_SELECT", "1");
        }
    }
}
