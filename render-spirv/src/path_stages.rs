//! Path tracing and direct illumination on a device: which stages run when, over which paths.
//!
//! What each stage does is said in [`halflight_kernel::transport::staged`]. The host keeps the list of the paths that have
//! not ended, which gets shorter from bounce to bounce, and submits the stages of one bounce together.

use crate::interface::{Dispatch, WORKGROUP, WorkItem};
use crate::vulkan::{Buffer, Device, Pipeline, VulkanError, dispatch_in_order};
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};
use std::ffi::CStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time after which a submission counts as hung.
pub const TIME_LIMIT: Duration = Duration::from_secs(120);

/// The stages, in the order in which they are numbered.
const ENTRIES: [&CStr; 12] = [
    c"paths::begin",
    c"paths::trace",
    c"paths::arrive",
    c"paths::light",
    c"paths::evaluate",
    c"paths::shadow",
    c"paths::sample",
    c"paths::mix",
    c"paths::scatter",
    c"paths::branch",
    c"paths::follow",
    c"paths::look_through",
];
const BEGIN: usize = 0;
const TRACE: usize = 1;
const ARRIVE: usize = 2;
const LIGHT: usize = 3;
const EVALUATE: usize = 4;
const SHADOW: usize = 5;
const SAMPLE: usize = 6;
const MIX: usize = 7;
const SCATTER: usize = 8;
const BRANCH: usize = 9;
const FOLLOW: usize = 10;
const LOOK_THROUGH: usize = 11;

/// One bounce of path tracing.
const BOUNCE: [usize; 8] = [TRACE, ARRIVE, LIGHT, EVALUATE, SHADOW, SAMPLE, MIX, SCATTER];

/// The pipelines of an integrator that works in stages.
pub struct Stages {
    /// By their number; what the integrator does not need is missing.
    pipelines: Vec<Option<Pipeline>>,
    settings: IntegratorSettings,
    /// Room for so many paths, and behind them for as many branches.
    capacity: u32,
    device: Arc<Device>,
    /// The longest submission of the last call.
    longest: Duration,
}

impl Stages {
    /// Whether the integrator works in stages.
    pub fn serve(kind: u32) -> bool {
        kind == integrator_kind::PATH || kind == integrator_kind::DIRECT
    }

    /// Paths that the buffer must have room for, when there are `capacity` work items.
    pub fn paths(settings: &IntegratorSettings, capacity: u32) -> u64 {
        let with_branches = settings.kind == integrator_kind::DIRECT;
        u64::from(capacity) * if with_branches { 2 } else { 1 }
    }

    /// Compiles the stages that the integrator needs with `compile`.
    ///
    /// # Errors
    /// Those of `compile`.
    pub fn new<E>(
        device: &Arc<Device>,
        settings: IntegratorSettings,
        capacity: u32,
        mut compile: impl FnMut(&CStr) -> Result<Pipeline, E>,
    ) -> Result<Stages, E> {
        let is_direct = settings.kind == integrator_kind::DIRECT;
        let mut pipelines = Vec::new();
        for (stage, entry) in ENTRIES.into_iter().enumerate() {
            let needed = match stage {
                SCATTER => !is_direct,
                BRANCH | FOLLOW | LOOK_THROUGH => is_direct,
                _ => true,
            };
            pipelines.push(if needed { Some(compile(entry)?) } else { None });
        }
        Ok(Stages {
            pipelines,
            settings,
            capacity,
            device: device.clone(),
            longest: Duration::ZERO,
        })
    }

    /// The longest submission of the last call of [`Stages::take`].
    pub fn longest_submission(&self) -> Duration {
        self.longest
    }

    /// Takes the listed samples; `radiance` receives them in the order of the list.
    ///
    /// # Errors
    /// If the device is lost or hangs.
    pub fn take(
        &mut self,
        dispatch: Dispatch,
        list: &[WorkItem],
        items: &mut Buffer,
        results: &Buffer,
        radiance: &mut [[f32; 4]],
    ) -> Result<(), VulkanError> {
        self.longest = Duration::ZERO;
        let mut alive = list.to_vec();
        items.write(&alive);
        self.run(dispatch, &alive, &[BEGIN], 0)?;
        results.read(radiance);
        alive.retain(|item| goes_on(radiance, item));
        while !alive.is_empty() {
            items.write(&alive);
            if self.settings.kind == integrator_kind::DIRECT {
                self.run(dispatch, &alive, &[TRACE, ARRIVE], 0)?;
                for _ in 0..self.settings.direct.emitter_samples {
                    self.run(dispatch, &alive, &[LIGHT, EVALUATE, SHADOW], 0)?;
                }
                for _ in 0..self.settings.direct.bsdf_samples {
                    self.run(dispatch, &alive, &[SAMPLE, MIX], 0)?;
                    self.branch(dispatch, &alive, items, results, radiance)?;
                }
                self.run(dispatch, &alive, &[LOOK_THROUGH], 0)?;
            } else {
                self.run(dispatch, &alive, &BOUNCE, 0)?;
            }
            results.read(radiance);
            alive.retain(|item| goes_on(radiance, item));
        }
        Ok(())
    }

    /// Follows one branch of each listed path to its end.
    fn branch(
        &mut self,
        dispatch: Dispatch,
        list: &[WorkItem],
        items: &mut Buffer,
        results: &Buffer,
        radiance: &mut [[f32; 4]],
    ) -> Result<(), VulkanError> {
        let first = self.capacity;
        self.run(dispatch, list, &[BRANCH], first)?;
        let mut alive = list.to_vec();
        loop {
            results.read(radiance);
            alive.retain(|item| goes_on(radiance, item));
            if alive.is_empty() {
                break;
            }
            items.write(&alive);
            self.run(dispatch, &alive, &[TRACE, FOLLOW], first)?;
        }
        items.write(list);
        Ok(())
    }

    /// Submits stages over the list, which the buffer of work items holds already.
    fn run(
        &mut self,
        dispatch: Dispatch,
        list: &[WorkItem],
        stages: &[usize],
        first: u32,
    ) -> Result<(), VulkanError> {
        let dispatch = Dispatch {
            count: list.len() as u32,
            first,
            ..dispatch
        };
        let pipelines: Vec<&Pipeline> = stages
            .iter()
            .filter_map(|stage| self.pipelines[*stage].as_ref())
            .collect();
        let groups = dispatch.count.div_ceil(WORKGROUP);
        let start = Instant::now();
        dispatch_in_order(
            &self.device,
            "a slice of paths",
            &pipelines,
            &dispatch,
            groups,
            TIME_LIMIT,
        )?;
        self.longest = self.longest.max(start.elapsed());
        Ok(())
    }
}

/// Whether the stage that wrote the result says that there is more to come.
fn goes_on(radiance: &[[f32; 4]], item: &WorkItem) -> bool {
    radiance[item.slot as usize][3] != 0.0
}
