//! Path tracing and direct illumination on a device: which stages run when, over which paths.
//!
//! What each stage does is said in [`halflight_kernel::transport::staged`], their order in
//! [`halflight_kernel::transport::bounce`]. The host keeps the list of the paths that have
//! not ended, which gets shorter from bounce to bounce, and submits the stages of one bounce together.

use crate::interface::{Dispatch, WORKGROUP, WorkItem};
use crate::vulkan::{Buffer, Device, Pipeline, VulkanError, dispatch_in_order};
use halflight_kernel::transport::bounce::{Branches, Rays, Shading, bounce, illuminate, shade};
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};
use std::ffi::CStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time after which a submission counts as hung.
pub const TIME_LIMIT: Duration = Duration::from_secs(120);

/// The entry points of the stages.
const ENTRIES: [&CStr; 12] = [
    c"paths::begin",
    c"paths::trace",
    c"paths::arrive",
    c"paths::sample_emitter",
    c"paths::evaluate_emitter",
    c"paths::sample_bsdf",
    c"paths::mix_lobes",
    c"paths::scatter",
    c"paths::trace_shadow_ray",
    c"paths::branch",
    c"paths::follow_branch",
    c"paths::continue_through_masks",
];
const BEGIN: usize = 0;
const TRACE: usize = 1;
const ARRIVE: usize = 2;
const SAMPLE_EMITTER: usize = 3;
const EVALUATE_EMITTER: usize = 4;
const SAMPLE_BSDF: usize = 5;
const MIX_LOBES: usize = 6;
const SCATTER: usize = 7;
const TRACE_SHADOW_RAY: usize = 8;
const BRANCH: usize = 9;
const FOLLOW_BRANCH: usize = 10;
const CONTINUE_THROUGH_MASKS: usize = 11;

/// The pipelines of an integrator that works in stages.
pub struct Stages {
    /// By their number; what the integrator does not need is missing.
    pipelines: Vec<Option<Pipeline>>,
    settings: IntegratorSettings,
    /// Buffers for so many paths, and behind them for as many branches.
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

    /// Paths that the buffer must hold, when there are `capacity` work items.
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
                BRANCH | FOLLOW_BRANCH | CONTINUE_THROUGH_MASKS => is_direct,
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
            let settings = self.settings;
            let mut driver = DeviceBounce {
                stages: self,
                dispatch,
                alive: &alive,
                branches: Vec::new(),
                items,
                results,
                radiance,
                waiting: Vec::new(),
                failure: None,
            };
            if settings.kind == integrator_kind::DIRECT {
                illuminate(&mut driver, &settings.direct);
            } else {
                bounce(&mut driver, shade);
            }
            driver.submit();
            if let Some(failure) = driver.failure {
                return Err(failure);
            }
            results.read(radiance);
            alive.retain(|item| goes_on(radiance, item));
        }
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

/// A bounce of all listed paths: stages wait until the host needs their results, and are submitted together.
struct DeviceBounce<'a> {
    stages: &'a mut Stages,
    dispatch: Dispatch,
    alive: &'a [WorkItem],
    /// The paths whose branches go on.
    branches: Vec<WorkItem>,
    items: &'a mut Buffer,
    results: &'a Buffer,
    radiance: &'a mut [[f32; 4]],
    waiting: Vec<usize>,
    /// What went wrong; nothing is submitted any more then.
    failure: Option<VulkanError>,
}

impl DeviceBounce<'_> {
    /// Runs the stages that wait over all paths.
    fn submit(&mut self) {
        let stages = std::mem::take(&mut self.waiting);
        let alive = self.alive;
        self.run(alive, &stages, 0);
    }

    fn run(&mut self, list: &[WorkItem], stages: &[usize], first: u32) {
        if self.failure.is_none() && !stages.is_empty() {
            self.failure = self.stages.run(self.dispatch, list, stages, first).err();
        }
    }

    /// Runs stages over the branches, and keeps those that go on.
    fn run_branches(&mut self, stages: &[usize]) {
        let list = std::mem::take(&mut self.branches);
        self.run(&list, stages, self.stages.capacity);
        if self.failure.is_none() {
            self.results.read(self.radiance);
            let goes_on = |item: &WorkItem| goes_on(self.radiance, item);
            self.branches = list.into_iter().filter(goes_on).collect();
        }
        // The list of the next stages.
        let next = if self.branches.is_empty() {
            self.alive
        } else {
            &self.branches
        };
        self.items.write(next);
    }
}

impl Shading for DeviceBounce<'_> {
    fn arrive(&mut self) {
        self.waiting.push(ARRIVE);
    }

    fn sample_emitter(&mut self) {
        self.waiting.push(SAMPLE_EMITTER);
    }

    fn evaluate_emitter(&mut self) {
        self.waiting.push(EVALUATE_EMITTER);
    }

    fn sample_bsdf(&mut self) {
        self.waiting.push(SAMPLE_BSDF);
    }

    fn mix_lobes(&mut self) {
        self.waiting.push(MIX_LOBES);
    }

    fn scatter(&mut self) {
        self.waiting.push(SCATTER);
    }
}

impl Rays for DeviceBounce<'_> {
    fn trace(&mut self) {
        self.waiting.push(TRACE);
    }

    fn trace_shadow_rays(&mut self) {
        self.waiting.push(TRACE_SHADOW_RAY);
    }
}

impl Branches for DeviceBounce<'_> {
    fn branch(&mut self) {
        self.submit();
        self.branches = self.alive.to_vec();
        self.run_branches(&[BRANCH]);
    }

    fn follow_branch(&mut self) -> bool {
        if self.branches.is_empty() {
            return false;
        }
        self.run_branches(&[TRACE, FOLLOW_BRANCH]);
        !self.branches.is_empty()
    }

    fn continue_through_masks(&mut self) {
        self.waiting.push(CONTINUE_THROUGH_MASKS);
    }
}

/// Whether the stage that wrote the result says that there is more to come.
fn goes_on(radiance: &[[f32; 4]], item: &WorkItem) -> bool {
    radiance[item.slot as usize][3] != 0.0
}
