//! The window's events.

use super::keys::{self, Command, Held};
use super::session::Session;
use super::surface::{present_on, refused};
use super::swapchain::Swapchain;
use super::{Content, WindowOptions};
use crate::lab::device::{OwnedInstance, open_presenting};
use crate::lab::{Lab, LabError};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

/// How long the window must keep a size before everything is made for it; until then the picture is stretched.
const SETTLED: Duration = Duration::from_millis(150);
/// Degrees by which the sun turns for a pixel.
const SUN_DEG_PER_PX: f64 = 0.25;
/// Pixels of a touchpad that count as a step of the wheel.
const STEP_PX: f64 = 40.0;

/// From start to end of the event loop.
pub(super) struct App {
    options: WindowOptions,
    content: Option<Content>,
    open: Option<Open>,
    result: Result<Vec<String>, LabError>,
}

/// The window and what it shows. Vulkan's objects go before the window.
struct Open {
    swapchain: Swapchain,
    session: Session,
    instance: Arc<OwnedInstance>,
    held: Held,
    /// Pressed since the last picture, if only for a moment.
    tapped: Held,
    drag: Option<MouseButton>,
    mouse: Option<PhysicalPosition<f64>>,
    resized: Option<Instant>,
    occluded: bool,
    window: Arc<Window>,
}

impl App {
    pub(super) fn new(options: WindowOptions, content: Content) -> Self {
        Self { options, content: Some(content), open: None, result: Ok(Vec::new()) }
    }

    pub(super) fn result(self) -> Result<Vec<String>, LabError> {
        self.result
    }

    fn start(&self, events: &ActiveEventLoop, content: Content) -> Result<Open, LabError> {
        let Content { scene, mut view, motion } = content;
        let [width, height] = view.size;
        let attributes = Window::default_attributes()
            .with_title(format!("umbrage: {}", scene.name))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes).map_err(|error| refused(&error.to_string()))?);
        // the window manager may have chosen another size
        view.size = area(&window).unwrap_or(view.size);
        let (device, gpu, surface) = present_on(&window, |present| open_presenting(&self.options.lab, present))?;
        let instance = device.instance().clone();
        let swapchain = Swapchain::new(&device, surface, &window, self.options.pace)?;
        let mut lab = Lab::on(device, gpu, scene, view)?;
        let moves = motion.is_some();
        if let Some(motion) = motion {
            lab.set_motion(motion);
        }
        let WindowOptions { methods, out, report, .. } = &self.options;
        let session = Session::new(lab, methods, moves, out.clone(), *report)?;
        Ok(Open {
            swapchain,
            session,
            instance,
            held: Held::default(),
            tapped: Held::default(),
            drag: None,
            mouse: None,
            resized: None,
            occluded: false,
            window,
        })
    }

    /// Stops with a failure.
    fn check(&mut self, events: &ActiveEventLoop, done: Result<(), LabError>) {
        if let Err(error) = done {
            self.result = Err(error);
            events.exit();
        }
    }
}

/// The window's size in pixels, where it has any.
fn area(window: &Window) -> Option<[u32; 2]> {
    let size: [u32; 2] = window.inner_size().into();
    (size[0] > 0 && size[1] > 0).then_some(size)
}

impl Open {
    fn draws(&self) -> bool {
        !self.occluded && area(&self.window).is_some()
    }

    fn frame(&mut self) -> Result<(), LabError> {
        if !self.draws() {
            return Ok(());
        }
        if self.resized.is_some_and(|at| at.elapsed() > SETTLED) {
            self.resized = None;
            if let Some(size) = area(&self.window).filter(|&size| size != self.session.size()) {
                self.session.resize(size)?;
            }
        }
        let held = self.held.and(std::mem::take(&mut self.tapped));
        self.session.frame(held, &mut self.swapchain)
    }

    /// `false` when the window is to be closed.
    fn key(&mut self, event: &KeyEvent) -> bool {
        let down = event.state == ElementState::Pressed;
        if let Some(key) = Held::of(&event.logical_key, event.physical_key) {
            self.held.set(key, down);
            self.tapped.set(key, down || self.tapped.has(key));
        }
        if !down || event.repeat {
            return true;
        }
        match keys::command(&event.logical_key, self.held.has(Held::FAST)) {
            Some(Command::Close) => return false,
            Some(command) => self.session.obey(command),
            None => (),
        }
        true
    }

    fn moved(&mut self, to: PhysicalPosition<f64>) -> Result<(), LabError> {
        let by = self.mouse.replace(to).map_or([0.0; 2], |from| [to.x - from.x, to.y - from.y]);
        match self.drag {
            Some(MouseButton::Right) => self.session.look(by),
            Some(MouseButton::Left) => {
                self.session.turn_sun([by[0] * SUN_DEG_PER_PX, -by[1] * SUN_DEG_PER_PX])?;
            }
            _ => (),
        }
        Ok(())
    }

    /// Lets go of everything that was held.
    fn release(&mut self) {
        (self.held, self.tapped) = (Held::default(), Held::default());
        (self.drag, self.mouse) = (None, None);
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(content) = self.content.take() else { return };
        match self.start(events, content) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.check(events, Err(error)),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let mut done = Ok(());
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => done = open.frame(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                open.swapchain.outdated();
                open.resized = Some(Instant::now());
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if !open.key(&event) => events.exit(),
            WindowEvent::MouseInput { state, button, .. } => {
                open.drag = (state == ElementState::Pressed).then_some(button);
            }
            WindowEvent::CursorMoved { position, .. } => done = open.moved(position),
            WindowEvent::MouseWheel { delta, .. } => open.session.wheel(match delta {
                MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                MouseScrollDelta::PixelDelta(pixels) => pixels.y / STEP_PX,
            }),
            WindowEvent::Focused(false) => open.release(),
            WindowEvent::Occluded(occluded) => open.occluded = occluded,
            _ => (),
        }
        self.check(events, done);
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &self.open else { return };
        // a window without area or out of sight waits for what changes that
        if open.draws() {
            open.window.request_redraw();
            events.set_control_flow(ControlFlow::Poll);
        } else {
            events.set_control_flow(ControlFlow::Wait);
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // before the connection to the display ends; what is destroyed wrongly is reported too
        let Some(open) = self.open.take() else { return };
        let instance = open.instance.clone();
        drop(open);
        if let Ok(messages) = &mut self.result {
            *messages = instance.messages();
        }
    }
}
