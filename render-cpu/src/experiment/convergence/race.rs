//! Algorithms that render the same scene in turn, each for the same processor time or the same number of samples.
//!
//! Processor time is that of all threads of the program, user and system, so that the comparison is fair on a busy machine as
//! well. The budget is spent in shares 2^-7, 2^-6 ... 1; within a share the algorithms take turns with slices of at most a
//! sixteenth of the budget. The number of samples in a slice follows from the time of earlier ones, so that the budget is kept
//! to about one sample per pixel. With a budget of samples the images depend on the seed alone.

use crate::accel::Accel;
use crate::film::{Film, FilmError};
use crate::render::{
    Goal, MutationsPerPixel, NoObserver, PassError, RenderOptions, RunState, own_layers, render,
};
use crate::scene::build::Scene;
use cpu_time::ProcessTime;
use halflight_kernel::transport::IntegratorSettings;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Shares of the budget after which images are measured: each is twice the one before.
pub const SHARES: u32 = 8;

/// Slices that the budget has at least.
const SLICES: f64 = 16.0;

/// What each algorithm may spend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Processor time.
    Time(Duration),
    /// Samples per pixel.
    Samples(u32),
}

/// An algorithm and its image so far.
pub struct Runner {
    /// The algorithm's name.
    pub name: String,
    /// The image.
    pub film: Film,
    /// How far it is.
    pub state: RunState,
    /// Processor time that it took.
    pub seconds: f64,
    settings: IntegratorSettings,
    seed: u32,
}

impl Runner {
    /// At the start.
    ///
    /// # Errors
    /// If the film cannot be made.
    pub fn new(
        name: &str,
        scene: &Scene,
        settings: IntegratorSettings,
        seed: u32,
    ) -> Result<Runner, FilmError> {
        let camera = &scene.tables.camera;
        let [width, height] = camera.crop_size;
        Ok(Runner {
            name: name.to_owned(),
            film: Film::new(width, height, camera.crop_offset, own_layers(settings.kind))?,
            state: RunState::default(),
            seconds: 0.0,
            settings,
            seed,
        })
    }

    /// Mutations per pixel that each sample stands for.
    fn unit(&self) -> u32 {
        let size = [self.film.width(), self.film.height()];
        MutationsPerPixel::of_settings(&self.settings, size).0
    }

    /// Samples per pixel so far, mutations where there are chains.
    pub fn samples(&self) -> u32 {
        self.state.samples.saturating_mul(self.unit())
    }

    /// Samples per pixel of the next slice; zero when the share of the budget is spent.
    fn next_samples(&self, budget: Budget, share: f64) -> u32 {
        let samples = self.state.samples;
        match budget {
            Budget::Samples(all) => {
                let target = (f64::from(all.div_ceil(self.unit())) * share).ceil() as u32;
                target.saturating_sub(samples)
            }
            Budget::Time(_) if samples == 0 => 1,
            Budget::Time(all) => {
                let all = all.as_secs_f64();
                let cost = self.seconds / f64::from(samples);
                let left = all * share - self.seconds;
                if left < 0.5 * cost {
                    0
                } else {
                    // A clock that does not move yet makes the quotient large; a slice is not much more than all before.
                    let wanted = (left.min(all / SLICES) / cost.max(1e-9)).round();
                    (wanted.max(1.0) as u32).min(4 * samples)
                }
            }
        }
    }

    /// Renders a slice.
    fn advance(&mut self, scene: &mut Scene, accel: &Accel, samples: u32) -> Result<(), PassError> {
        scene.settings = self.settings;
        let options = RenderOptions {
            goal: Goal::Samples(self.state.samples + samples),
            seed: self.seed,
            first_sample: 0,
            adaptive: false,
        };
        let never = AtomicBool::new(false);
        let start = ProcessTime::try_now()?;
        render(
            scene,
            accel,
            &options,
            &mut self.film,
            &mut self.state,
            &never,
            &mut NoObserver,
        )?;
        self.seconds += start.try_elapsed()?.as_secs_f64();
        Ok(())
    }
}

/// Runs all algorithms until the budget is spent; `at_share` is called with their images after each share of it.
///
/// # Errors
/// If a pass fails.
pub fn race(
    runners: &mut [Runner],
    scene: &mut Scene,
    accel: &Accel,
    budget: Budget,
    mut at_share: impl FnMut(&[Runner], f64),
) -> Result<(), PassError> {
    for doubling in (0..SHARES).rev() {
        let share = (-f64::from(doubling)).exp2();
        let mut is_spent = false;
        while !is_spent {
            is_spent = true;
            for runner in runners.iter_mut() {
                let samples = runner.next_samples(budget, share);
                if samples > 0 {
                    runner.advance(scene, accel, samples)?;
                    is_spent = false;
                }
            }
        }
        at_share(runners, share);
    }
    Ok(())
}
