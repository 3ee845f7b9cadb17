//! Where windows come from: the display, and the surface that Vulkan presents on.

use crate::error::Context;
use crate::lab::LabError;
use crate::lab::device::Present;
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::Window;

/// Variables of which one names the display.
#[cfg(all(unix, not(target_os = "macos")))]
const DISPLAYS: [&str; 3] = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"];

/// Fails where no display is named.
pub(super) fn display() -> Result<(), LabError> {
    #[cfg(all(unix, not(target_os = "macos")))]
    if DISPLAYS.iter().all(|name| std::env::var_os(name).is_none_or(|value| value.is_empty())) {
        return Err(refused("neither WAYLAND_DISPLAY nor DISPLAY names a display"));
    }
    Ok(())
}

/// No window: `why` as the window system says it, without the place in its source that it begins with.
pub(super) fn refused(why: &str) -> LabError {
    let after_place = |(_, rest): (&'_ str, &'_ str)| rest.split_once(": ").map(|(_, why)| why.to_owned());
    let why = why.rsplit_once(".rs:").and_then(after_place).unwrap_or_else(|| why.to_owned());
    LabError::Refused(format!("no window can be opened: {why}; `umbrage render` needs none"))
}

/// What a panic said, without its full stop.
pub(super) fn text_of(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("unknown cause").trim_end_matches('.').to_owned()
}

/// Gives `open` what a device needs to present on a window.
pub(super) fn present_on<R>(
    window: &Window,
    open: impl FnOnce(&Present<'_>) -> Result<R, LabError>,
) -> Result<R, LabError> {
    let gone = |error: &dyn std::fmt::Display| refused(&error.to_string());
    let display = window.display_handle().map_err(|error| gone(&error))?.as_raw();
    let handle = window.window_handle().map_err(|error| gone(&error))?.as_raw();
    let extensions = ash_window::enumerate_required_extensions(display).context("vkCreateInstance")?;
    let surface = |entry: &ash::Entry, instance: &ash::Instance| {
        // SAFETY: the instance has the extensions for this display, and the window outlives its surface
        let made = unsafe { ash_window::create_surface(entry, instance, display, handle, None) };
        Ok(made.context("creating the window's surface")?)
    };
    open(&Present { extensions, surface: &surface })
}

#[cfg(test)]
mod tests {
    use super::refused;

    #[test]
    fn places_in_sources_are_left_out() {
        let text = |why| refused(why).to_string();
        let long = text("os error at /home/x/winit-0.30/src/linux/mod.rs:743: cannot open it: no server");
        assert!(long.starts_with("no window can be opened: cannot open it: no server;"), "{long}");
        assert!(text("plain cause").contains("opened: plain cause;"));
    }

    #[test]
    fn panics_keep_their_text() {
        let text = |panic: Box<dyn std::any::Any + Send>| super::text_of(panic.as_ref());
        assert_eq!(text(Box::new("cannot be loaded.")), "cannot be loaded");
        assert_eq!(text(Box::new(String::from("neither"))), "neither");
        assert_eq!(text(Box::new(7)), "unknown cause");
    }
}
