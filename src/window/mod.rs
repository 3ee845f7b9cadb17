//! A window to look through: a camera that flies, methods side by side, and what goes on inside them.

mod app;
mod canvas;
mod choice;
mod fly;
mod keys;
mod overlay;
mod palette;
mod screenshot;
mod session;
mod settings;
mod show;
mod status;
mod surface;
mod swapchain;

use crate::lab::{LabError, LabOptions, View};
use crate::methods::MethodSpec;
use crate::scene::{Motion, Scene};
use std::path::PathBuf;
use winit::event_loop::EventLoop;

/// When a picture reaches the screen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Pace {
    /// With the screen's refresh, one after the other.
    #[default]
    Fifo,
    /// With the refresh, the newest.
    Mailbox,
    /// At once; pictures may tear.
    Immediate,
}

/// How the window is opened.
#[derive(Debug, Clone)]
pub struct WindowOptions {
    /// The device.
    pub lab: LabOptions,
    /// The methods to switch between; the first is shown first.
    pub methods: Vec<MethodSpec>,
    /// When a picture reaches the screen.
    pub pace: Pace,
    /// An existing folder for screenshots.
    pub out: PathBuf,
    /// Is told one sentence about each file written.
    pub report: fn(&str),
}

/// What is looked at.
pub struct Content {
    /// The scene.
    pub scene: Scene,
    /// The first view; its size is that of the window.
    pub view: View,
    /// What moves the scene, if anything does.
    pub motion: Option<Motion>,
}

/// Opens the window and returns when it is closed; the messages of the validation layer, where that is on. Must be called on
/// the main thread, once in a process.
///
/// # Errors
/// [`LabError::Usage`] for a view that is not allowed, [`LabError::Refused`] without a display or a device that can present on
/// it; otherwise as [`crate::lab::Lab::new`] and
/// [`crate::methods::create`].
pub fn run(options: WindowOptions, content: Content) -> Result<Vec<String>, LabError> {
    content.view.check().map_err(LabError::Usage)?;
    surface::display()?;
    // winit panics where libxkbcommon-x11 is missing
    let events = match std::panic::catch_unwind(EventLoop::new) {
        Ok(events) => events.map_err(|error| surface::refused(&error.to_string()))?,
        Err(panic) => return Err(surface::refused(&surface::text_of(panic.as_ref()))),
    };
    let mut app = app::App::new(options, content);
    events.run_app(&mut app).map_err(|error| surface::refused(&error.to_string()))?;
    app.result()
}
