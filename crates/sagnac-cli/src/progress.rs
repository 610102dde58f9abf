//! Progress on standard error: after one second, at most ten times a second, erased when done.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use sagnac::report::text::{Document, Style};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Instant;

/// A bar (total known) or a counter (not known) of one piece of work.
pub(crate) struct Progress {
    bar: ProgressBar,
    shown: bool,
    wanted: bool,
    started: Instant,
    label: String,
    /// What is counted, where the rate is shown beside a known total.
    counted: Option<&'static str>,
    /// What redraws the time while work goes on that does not say how far it is.
    clock: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    pub(crate) fn new(label: &str, total: Option<u64>, wanted: bool, utf8: bool) -> Self {
        let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::hidden());
        let template = if total.is_some() {
            "{msg:36!} {percent:>3} %  {bar:26}  {eta} left"
        } else {
            "{msg:36!} {human_pos}, {per_sec}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars(if utf8 { "━━─" } else { "##-" }));
        }
        bar.set_message(label.to_owned());
        Self {
            bar,
            shown: false,
            wanted,
            started: Instant::now(),
            label: label.to_owned(),
            counted: None,
            clock: None,
        }
    }

    /// From now on work goes on that does not say how far it is: its name and the time since it began.
    pub(crate) fn work(&mut self, label: &str) {
        if !self.wanted || self.clock.is_some() {
            return;
        }
        let (stop, stopped) = channel();
        let (bar, label) = (self.bar.clone(), label.to_owned());
        let thread = std::thread::spawn(move || {
            let began = Instant::now();
            while stopped.recv_timeout(Duration::from_secs(1)) == Err(RecvTimeoutError::Timeout) {
                if let Ok(style) = ProgressStyle::with_template("{msg}") {
                    bar.set_style(style);
                }
                bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
                bar.set_message(format!("{label}  {} s", began.elapsed().as_secs()));
                bar.tick();
            }
        });
        self.clock = Some((stop, thread));
    }

    /// The same with the rate after the label: `simulating  12 M samples/s`.
    pub(crate) fn with_rate(mut self, counted: &'static str) -> Self {
        self.counted = Some(counted);
        self
    }

    /// Says how far the work is, in the unit of `total`.
    pub(crate) fn set(&mut self, done: u64) {
        if self.wanted && !self.shown && self.started.elapsed() > Duration::from_secs(1) {
            self.bar
                .set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
            self.shown = true;
        }
        if let Some(counted) = self.counted
            && self.shown
        {
            let rate = done as f64 / self.started.elapsed().as_secs_f64();
            self.bar
                .set_message(format!("{}  {} {counted}/s", self.label, short(rate)));
        }
        self.bar.set_position(done);
    }
}

/// A text of several lines that is drawn over its predecessor and erased when done.
pub(crate) struct Redrawn {
    bar: ProgressBar,
    style: Style,
}

impl Redrawn {
    pub(crate) fn new(style: Style) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        if let Ok(message) = ProgressStyle::with_template("{msg}") {
            bar.set_style(message);
        }
        Self { bar, style }
    }

    pub(crate) fn draw(&self, document: &Document) {
        self.bar
            .set_message(document.render(self.style).trim_end().to_owned());
    }
}

impl Drop for Redrawn {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// `12.3 M`, `950 k`.
fn short(rate: f64) -> String {
    match rate {
        r if r >= 1e6 => format!("{:.1} M", r / 1e6),
        r if r >= 1e3 => format!("{:.0} k", r / 1e3),
        r => format!("{r:.0}"),
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.clock.take() {
            drop(stop);
            // A thread that panicked has nothing left to draw.
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}
