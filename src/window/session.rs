//! What is looked at and how: scene, camera, methods and their settings, from frame to frame.

use super::canvas::{Canvas, Lit};
use super::choice::Choice;
use super::fly::{self, Fly};
use super::keys::{Command, HELP, Held};
use super::overlay::{Corner, Line, Overlay};
use super::show::Show;
use super::status::Status;
use super::swapchain::Swapchain;
use super::{screenshot, settings};
use crate::lab::{Lab, LabError, View};
use crate::methods::{FrameTimes, MethodSpec, Statistics};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How long a message stays.
const MESSAGE: Duration = Duration::from_secs(4);
/// How often numbers change.
const NUMBERS: Duration = Duration::from_millis(250);
/// Longest step of camera, sun and animation, in seconds.
const LONGEST_STEP_S: f64 = 0.25;

/// What the overlay shows of a frame.
#[derive(Default)]
struct Numbers {
    times: FrameTimes,
    statistics: Statistics,
    frame_ms: f64,
    at: Option<Instant>,
}

pub(super) struct Session {
    choice: Choice,
    canvas: Canvas,
    fly: Fly,
    first: View,
    show: Show,
    moves: bool,
    playing: bool,
    frozen: bool,
    help: bool,
    overlay: bool,
    shoot: bool,
    numbers: Numbers,
    message: Option<(String, Instant)>,
    /// What a method on the CPU has traced.
    traced: Option<View>,
    last: Instant,
    out: PathBuf,
    report: fn(&str),
    lab: Lab,
}

impl Session {
    /// `moves`: whether the lab's scene does.
    pub(super) fn new(
        lab: Lab,
        specs: &[MethodSpec],
        moves: bool,
        out: PathBuf,
        report: fn(&str),
    ) -> Result<Self, LabError> {
        Ok(Self {
            choice: Choice::new(specs, &lab)?,
            canvas: Canvas::new(&lab)?,
            fly: Fly::new(lab.view().camera, lab.scene().diagonal()),
            first: lab.view().clone(),
            show: Show::Shaded,
            moves,
            playing: moves,
            frozen: false,
            help: false,
            overlay: true,
            shoot: false,
            numbers: Numbers::default(),
            message: None,
            traced: None,
            last: Instant::now(),
            out,
            report,
            lab,
        })
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.lab.view().size
    }

    /// Another size of the window: everything that has one is made again.
    pub(super) fn resize(&mut self, size: [u32; 2]) -> Result<(), LabError> {
        self.choice.drop_all();
        (self.frozen, self.traced) = (false, None);
        self.lab.resize(size)?;
        self.canvas = Canvas::new(&self.lab)?;
        self.choice.make(&self.lab)
    }

    fn say(&mut self, text: impl Into<String>) {
        self.message = Some((text.into(), Instant::now()));
    }

    /// Changes to another method.
    fn switch(&mut self, to: usize) {
        match self.choice.switch(to, &self.lab) {
            Ok(()) => self.begin(),
            Err(error) => self.say(error.to_string()),
        }
    }

    /// Another method is shown from now on.
    fn begin(&mut self) {
        (self.frozen, self.traced) = (false, None);
        self.numbers = Numbers::default();
        self.canvas.forget();
        if self.show.of_pages() && !self.choice.paged() {
            self.show = Show::Shaded;
        }
        self.say(self.choice.spec().text.clone());
    }

    /// Asks for changed keys of the current method, where it has them.
    fn change(&mut self, what: &str, changed: Option<MethodSpec>) {
        let name = &self.choice.spec().name;
        let none = format!("{name} has no {what}");
        match changed.map(|spec| self.choice.want(spec)) {
            Some(Ok(())) => (),
            Some(Err(error)) => self.say(error.to_string()),
            None => self.say(none),
        }
    }

    /// Brings the current method to what was asked for.
    fn replace(&mut self) {
        match self.choice.replace(&self.lab) {
            Ok(true) => self.begin(),
            Ok(false) => (),
            Err(error) => self.say(error.to_string()),
        }
    }

    /// Does what a key asks for; [`Command::Close`] is not for it.
    pub(super) fn obey(&mut self, command: Command) {
        let [current, count] = self.choice.place();
        let spec = self.choice.wanted();
        match command {
            Command::Help => self.help = !self.help,
            Command::Overlay => self.overlay = !self.overlay,
            Command::Turn { forward } => self.switch((current + if forward { 1 } else { count - 1 }) % count),
            Command::Method(place) => self.switch(place),
            Command::Exact => self.change("exact mode", settings::exact(spec)),
            Command::Filter => self.change("filter", settings::filter(spec)),
            Command::Bias { finer } => self.change("bias", settings::bias(spec, finer)),
            Command::Atlas { larger } => self.change("atlas and no map", settings::atlas(spec, larger)),
            Command::Freeze if !self.choice.paged() => self.change("pages to freeze", None),
            Command::Freeze => {
                self.frozen = !self.frozen;
                self.say(if self.frozen { "frozen" } else { "pages follow the camera again" });
            }
            Command::Show { forward } => {
                self.show = self.show.step(forward, self.choice.paged());
                self.say(self.show.name());
            }
            Command::Play if !self.moves => self.say("nothing moves here; --animate and --movers change that"),
            Command::Play => {
                self.playing = !self.playing;
                self.say(if self.playing { "plays" } else { "paused" });
            }
            Command::Reset => {
                self.fly = Fly::new(self.first.camera, self.lab.scene().diagonal());
                let view = View { lights: self.first.lights.clone(), ..self.lab.view().clone() };
                if !self.frozen
                    && let Err(error) = self.lab.look(view)
                {
                    self.say(error.to_string());
                }
            }
            Command::Screenshot => self.shoot = true,
            Command::Close => (),
        }
    }

    pub(super) fn look(&mut self, pixels: [f64; 2]) {
        self.fly.look(pixels, self.size()[1]);
    }

    pub(super) fn wheel(&mut self, steps: f64) {
        self.fly.wheel(steps);
        let speed = self.fly.speed;
        self.say(format!("speed {speed:.3} a second"));
    }

    /// Turns the sun by degrees to the right and up.
    pub(super) fn turn_sun(&mut self, degrees: [f64; 2]) -> Result<(), LabError> {
        if self.frozen {
            self.say("frozen: the sun stands still");
            return Ok(());
        }
        let mut view = self.lab.view().clone();
        let up = self.fly.camera().up;
        match fly::sun(&mut view.lights) {
            Some(direction) => *direction = fly::turn_sun(*direction, up, degrees),
            None => self.say("this view has no sun"),
        }
        self.lab.look(view)
    }

    /// Runs a frame of the current method and shows it.
    pub(super) fn frame(&mut self, held: Held, swapchain: &mut Swapchain) -> Result<(), LabError> {
        let now = Instant::now();
        let passed = now.duration_since(self.last);
        self.last = now;
        self.replace();
        self.advance(held, passed.as_secs_f64().min(LONGEST_STEP_S))?;
        self.run(passed)?;
        self.draw(swapchain)
    }

    /// Moves camera, sun and scene.
    fn advance(&mut self, held: Held, dt_s: f64) -> Result<(), LabError> {
        self.fly.advance(held, dt_s);
        if let Some(degrees) = fly::sun_step(held, dt_s) {
            self.turn_sun(degrees)?;
        }
        if self.moves && self.playing && !self.frozen {
            let time_s = self.lab.view().time_s + dt_s;
            self.lab.animate(time_s)?;
        }
        let view = View { camera: self.fly.camera(), ..self.lab.view().clone() };
        if view != *self.lab.view() {
            self.lab.look(view)?;
        }
        Ok(())
    }

    /// A frame of the current method.
    fn run(&mut self, passed: Duration) -> Result<(), LabError> {
        let Some((method, ran)) = self.choice.method() else { return Ok(()) };
        let still = method.masks().is_none() && self.traced.as_ref() == Some(self.lab.view());
        if still {
            return Ok(());
        }
        // what has no pages yet gets them first
        let frozen = if self.frozen && *ran { method.frozen_frame(&self.lab)? } else { None };
        let times = match frozen {
            Some(times) => times,
            None => method.frame(&self.lab)?,
        };
        *ran = true;
        if self.show.of_pages() && !method.update_pages(&self.lab)? {
            self.show = Show::Shaded;
        }
        if method.masks().is_none() {
            self.traced = Some(self.lab.view().clone());
        }
        let numbers = &mut self.numbers;
        if numbers.at.is_none_or(|at| at.elapsed() > NUMBERS) {
            let statistics = if self.overlay { method.statistics(&self.lab)? } else { Statistics::default() };
            let frame_ms = passed.as_secs_f64() * 1e3;
            *numbers = Numbers { times, statistics, frame_ms, at: Some(Instant::now()) };
        }
        Ok(())
    }

    /// Draws the last frame's picture and shows it.
    fn draw(&mut self, swapchain: &mut Swapchain) -> Result<(), LabError> {
        let mut overlay = Overlay::new(self.size());
        self.text(&mut overlay);
        self.canvas.write(&overlay);
        let Some((method, _)) = self.choice.method() else { return Ok(()) };
        let on_cpu = if method.masks().is_none() {
            let lights = 0..self.lab.view().lights.len();
            lights.map(|light| method.visibility(&self.lab, light)).collect::<Result<_, _>>()?
        } else {
            Vec::new()
        };
        let lit = method.masks().map_or(Lit::Values(on_cpu), Lit::Masks);
        let pages = if self.show.of_pages() { method.page_views() } else { None };
        self.canvas.prepare(&self.lab, &lit, pages.as_ref())?;
        let shown = swapchain.show(|cmd, target| {
            self.canvas.record(&self.lab, cmd, &lit, self.show);
            self.canvas.present(&self.lab, cmd, target);
        })?;
        if shown && std::mem::take(&mut self.shoot) {
            let picture = self.canvas.read(&self.lab)?;
            match screenshot::save(&self.out, &picture, self.lab.view()) {
                Ok(name) => {
                    (self.report)(&format!("wrote {}", self.out.join(&name).display()));
                    self.say(format!("wrote {name}"));
                }
                Err(error) => self.say(error.to_string()),
            }
        }
        Ok(())
    }

    fn text(&mut self, overlay: &mut Overlay) {
        let plain = |text: String| -> Line { (text, None) };
        if self.overlay {
            let (numbers, [place, count]) = (&self.numbers, self.choice.place());
            let status = Status {
                method: &self.choice.spec().text,
                place: [place + 1, count],
                device: &self.lab.device_name(),
                cpu: self.lab.device_is_cpu(),
                frame_ms: numbers.frame_ms,
                times: &numbers.times,
                statistics: &numbers.statistics,
                slow: self.choice.slow(),
                frozen: self.frozen,
                paged: self.choice.paged(),
                shows: self.show.name(),
            };
            overlay.panel(Corner::TopLeft, &status.lines());
            self.message = self.message.take().filter(|(_, at)| at.elapsed() < MESSAGE);
            let levels: Vec<_> =
                numbers.statistics.levels.iter().filter(|level| level.resident > 0).map(|level| level.level).collect();
            let legend = self.show.legend(&levels).into_iter().map(|(name, color)| (name, Some(color)));
            let message = self.message.iter().map(|(text, _)| plain(text.clone()));
            overlay.panel(Corner::BottomLeft, &legend.chain(message).collect::<Vec<_>>());
        }
        if self.help {
            let widest = HELP.iter().map(|(keys, _)| keys.len()).max().unwrap_or(0);
            let lines: Vec<_> = HELP.iter().map(|(keys, what)| plain(format!("{keys:widest$}  {what}"))).collect();
            overlay.panel(Corner::Middle, &lines);
        }
    }
}
