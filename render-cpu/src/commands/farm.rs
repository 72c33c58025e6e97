//! `halflight farm`: one image on many machines.

use super::estimator_args::EstimatorArgs;
use super::interrupt;
use super::look_args::LookArgs;
use super::output_file;
use super::render_values::{parse_aov, parse_duration};
use super::scene_args::SceneArgs;
use crate::farm::FarmError;
use crate::farm::folder::Folder;
use crate::farm::merge::{merge_all, merge_node};
use crate::farm::plan::{
    Division, FAN_IN, Plan, PlannedLook, PlannedScene, Request, settings_words,
};
use crate::farm::ranges::ranges;
use crate::farm::slurm::{self, EXIT_AGAIN, SlurmOptions};
use crate::farm::status::{Status, TaskState};
use crate::farm::task::{TaskOutcome, run_task};
use crate::film::aov::AovSet;
use crate::processor::set_threads;
use crate::say::print_line;
use clap::{Args, Subcommand};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Exit code of `farm status` for a farm that is not done.
const EXIT_OPEN: u8 = 2;

/// Render one image as many tasks that share a folder.
#[derive(Args, Clone, Debug)]
pub struct FarmArgs {
    #[command(subcommand)]
    command: FarmCommand,
}

#[derive(Subcommand, Clone, Debug)]
enum FarmCommand {
    /// Divide an image into tasks
    Plan(PlanArgs),
    /// Divide an image into tasks, and write the scripts that run them with Slurm
    Slurm(SlurmArgs),
    /// Render one task, or go on with it
    Task(TaskArgs),
    /// Merge the tasks to the image
    Merge(MergeArgs),
    /// Say what is done, missing or torn
    Status(StatusArgs),
    /// Write the scripts for what is not done yet
    Resume(ResumeArgs),
}

/// What is rendered.
#[derive(Args, Clone, Debug)]
struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    look: LookArgs,
    /// Image to write.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Number of tasks.
    #[arg(long, value_name = "N")]
    tasks: u32,
    /// Samples per pixel of the image. Default: what the scene asks for.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Seed of the random numbers. Default: the scene's, or 0.
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Give each task samples of all pixels, all samples of some pixels, or a seed of its own.
    #[arg(long, value_enum, default_value_t)]
    divide: Division,
    /// Layers to write beside the image: albedo, normal, depth, position, uv, alpha, variance, samples, or all.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_aov)]
    aov: Vec<AovSet>,
    /// Films that a merge takes in.
    #[arg(long, value_name = "N", default_value_t = FAN_IN)]
    fan_in: u32,
    /// Folder of the farm. Default: the image's name with .farm.
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

#[derive(Args, Clone, Debug)]
struct SlurmArgs {
    #[command(flatten)]
    plan: PlanArgs,
    /// Processors of each task.
    #[arg(long, value_name = "N")]
    cpus_per_task: Option<u32>,
    /// Time limit of each task, as Slurm writes it; a task that does not end in time is requeued and goes on.
    #[arg(long, value_name = "TIME")]
    time_limit: Option<String>,
    /// Time between two checkpoints of a task. Default: 30s.
    #[arg(long, value_name = "TIME", value_parser = checked_duration)]
    checkpoint_interval: Option<String>,
    /// Another option of sbatch for all jobs, as in --slurm=--partition=long; may be given several times.
    #[arg(long = "slurm", value_name = "OPTION", allow_hyphen_values = true)]
    options: Vec<String>,
    /// Submit the jobs.
    #[arg(long)]
    submit: bool,
}

#[derive(Args, Clone, Debug)]
struct TaskArgs {
    /// Folder of the farm.
    folder: PathBuf,
    /// Which task, from 0.
    task: u32,
    /// Number of threads; 0 for one per processor.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Time between two checkpoints.
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = parse_duration)]
    checkpoint_interval: Duration,
}

#[derive(Args, Clone, Debug)]
struct MergeArgs {
    /// Folder of the farm.
    folder: PathBuf,
    /// One level of the tree only, from 1; with --node.
    #[arg(long, value_name = "L", requires = "node")]
    level: Option<usize>,
    /// One node of the level only, from 0.
    #[arg(long, value_name = "N", requires = "level")]
    node: Option<u32>,
}

#[derive(Args, Clone, Debug)]
struct StatusArgs {
    /// Folder of the farm.
    folder: PathBuf,
    /// Read all finished films and compare their digests, not their lengths alone.
    #[arg(long)]
    verify: bool,
}

#[derive(Args, Clone, Debug)]
struct ResumeArgs {
    /// Folder of the farm.
    folder: PathBuf,
    /// Submit the jobs.
    #[arg(long)]
    submit: bool,
}

/// Runs the command.
///
/// # Errors
/// What keeps it from being done, in one sentence.
pub fn run(args: &FarmArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match &args.command {
        FarmCommand::Plan(args) => {
            let (folder, plan) = args.plan()?;
            let say = |text: String| if quiet { Ok(()) } else { print_line(text) };
            say(format!(
                "{}: {} tasks from 0 on; run `halflight farm task {0} N` for each, then `halflight farm merge {0}`",
                folder.0.display(),
                plan.tasks
            ))?;
            Ok(ExitCode::SUCCESS)
        }
        FarmCommand::Slurm(args) => args.run(quiet),
        FarmCommand::Task(args) => args.run(quiet),
        FarmCommand::Merge(args) => args.run(quiet),
        FarmCommand::Status(args) => args.run(),
        FarmCommand::Resume(args) => args.run(quiet),
    }
}

/// A time, as it was written.
fn checked_duration(text: &str) -> Result<String, String> {
    parse_duration(text).map(|_| text.to_owned())
}

/// A path that means the same in other folders.
fn absolute(path: &Path) -> Result<PathBuf, FarmError> {
    std::path::absolute(path).map_err(|source| FarmError::Io {
        file: path.to_owned(),
        source,
    })
}

impl PlanArgs {
    /// Makes the plan and its folder.
    fn plan(&self) -> Result<(Folder, Plan), FarmError> {
        let is_exr = self.output.extension();
        if is_exr.is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
            return Err(FarmError::Request(format!(
                "{}: the image is an OpenEXR file; its name ends in .exr",
                self.output.display()
            )));
        }
        let scene = &self.scene;
        let look = &self.look;
        let mut planned = PlannedScene {
            file: absolute(&scene.scene)?,
            defines: scene.defines.clone(),
            size: scene.size,
            width: scene.width,
            crop: scene.crop.map(|crop| {
                let ([x, y], [w, h]) = (crop.offset, crop.size);
                [x, y, w, h]
            }),
            integrator: scene.integrator.clone(),
            sampler: scene.sampler.clone(),
            sensor: scene.sensor,
            strict: scene.strict,
            parts: self.estimator.expressions.request(),
            edit: scene.edit.as_deref().map(absolute).transpose()?,
            edit_time: scene.edit_time,
            settings: None,
            look: PlannedLook {
                clamp: look.clamp,
                half: look.half,
                no_png: look.no_png,
                exposure: look.exposure,
                owner: look.owner.clone(),
            },
        };
        output_file::check(&self.output, &["exr"], [self.scene.scene.as_path()])
            .map_err(FarmError::Request)?;
        let output = absolute(&self.output)?;
        let mut built = planned.load()?;
        let before = settings_words(&built.settings);
        self.estimator
            .apply(&mut built)
            .map_err(FarmError::Request)?;
        let after = settings_words(&built.settings);
        planned.settings = (before != after).then_some(after);
        let plan = Plan::of(
            planned,
            &built,
            &Request {
                output: output.clone(),
                tasks: self.tasks,
                spp: self.spp,
                seed: self.seed,
                division: self.divide,
                layers: self.aov.iter().copied().fold(AovSet::NONE, AovSet::union),
                fan_in: self.fan_in,
            },
        )?;
        let folder = match &self.folder {
            Some(folder) => Folder(absolute(folder)?),
            None => Folder::of_output(&output),
        };
        folder.create(&plan)?;
        Ok((folder, plan))
    }
}

impl SlurmArgs {
    fn run(&self, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
        let (folder, plan) = self.plan.plan()?;
        let options = SlurmOptions {
            program: std::env::current_exe()?,
            cpus: self.cpus_per_task,
            time_limit: self.time_limit.clone(),
            checkpoint_interval: self.checkpoint_interval.clone(),
            options: self.options.clone(),
        };
        let tasks: Vec<u32> = (0..plan.tasks).collect();
        let script = slurm::write_scripts(&folder, &plan, &options, &tasks)?;
        submit(&script, self.submit, quiet)
    }
}

/// Submits a script, or says how to.
fn submit(script: &Path, now: bool, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    if now {
        slurm::submit(script)?;
    } else if !quiet {
        print_line(format_args!(
            "submit the jobs with: bash {}",
            script.display()
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

impl TaskArgs {
    fn run(&self, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
        let folder = Folder(absolute(&self.folder)?);
        let plan = folder.plan()?;
        set_threads(Some(self.threads))?;
        // SIGTERM counts as well: schedulers send it before they kill.
        let stop = interrupt::request(quiet);
        let interval = self.checkpoint_interval;
        Ok(
            match run_task(&folder, &plan, self.task, interval, &stop)? {
                TaskOutcome::Done => ExitCode::SUCCESS,
                TaskOutcome::AlreadyDone => {
                    tracing::info!("task {} had been rendered before", self.task);
                    ExitCode::SUCCESS
                }
                TaskOutcome::Interrupted => ExitCode::from(EXIT_AGAIN),
            },
        )
    }
}

impl MergeArgs {
    fn run(&self, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
        let folder = Folder(absolute(&self.folder)?);
        let plan = folder.plan()?;
        match (self.level, self.node) {
            (Some(level), Some(node)) => merge_node(&folder, &plan, level, node)?,
            _ => {
                merge_all(&folder, &plan)?;
                if !quiet {
                    print_line(plan.output.display())?;
                }
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

impl StatusArgs {
    fn run(&self) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
        let folder = Folder(absolute(&self.folder)?);
        let plan = folder.plan()?;
        let status = Status::of(&folder, &plan, self.verify)?;
        let open = status.open();
        let started = status.having(|t| matches!(t, TaskState::Started(_)));
        let done = plan.tasks as usize - open.len();
        print_line(format_args!(
            "{}: {done} of {} tasks done, {} started, {:.1} MB, {:.0} s",
            folder.0.display(),
            plan.tasks,
            started.len(),
            status.bytes as f64 / 1e6,
            status.seconds
        ))?;
        let lists = [
            ("started", started),
            ("missing", status.having(|t| *t == TaskState::Missing)),
            ("torn", status.having(|t| *t == TaskState::Torn)),
        ];
        for (what, tasks) in lists {
            if !tasks.is_empty() {
                print_line(format_args!("{what}: {}", ranges(&tasks)))?;
            }
        }
        let image = plan.output.display();
        match (open.is_empty(), status.is_merged) {
            (true, true) => print_line(format_args!("merged: {image}")),
            (true, false) => print_line(format_args!("not merged yet: {image}")),
            (false, _) => print_line("`halflight farm resume` has the rest rendered"),
        }?;
        Ok(if status.is_merged {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(EXIT_OPEN)
        })
    }
}

impl ResumeArgs {
    fn run(&self, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
        let folder = Folder(absolute(&self.folder)?);
        let plan = folder.plan()?;
        let options = slurm::read_options(&folder)?;
        // Read, not believed: a merge that found a torn film is why people come here.
        let status = Status::of(&folder, &plan, true)?;
        if status.is_merged {
            if !quiet {
                print_line(format_args!(
                    "nothing to do: {} is there",
                    plan.output.display()
                ))?;
            }
            return Ok(ExitCode::SUCCESS);
        }
        let script = slurm::write_scripts(&folder, &plan, &options, &status.open())?;
        submit(&script, self.submit, quiet)
    }
}
