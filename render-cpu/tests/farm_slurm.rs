//! A farm on a real Slurm: `slurmctld`, `slurmd` and `munged` on the loopback address, started and stopped here.
//!
//! Skipped, with the reason, where they are not installed (Debian: `apt-get install slurm-wlm munge`) or this is not the
//! superuser, whom slurmd needs to be; an error instead where `HALFLIGHT_REQUIRE_SLURM` is set.

#![cfg(unix)]

#[path = "common/room.rs"]
mod room;
#[path = "common/skip.rs"]
mod skip;

use halflight::farm::folder::Folder;
use halflight::farm::record::Record;
use room::room;
use std::fs;
use std::io::Read;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The scene: some seconds of work for a task, in pieces that end often.
const SCENE: &str = room!(
    settings: r#"<integrator type="path"><integer name="max_depth" value="6"/></integrator>"#,
    sensor: "",
    width: "96",
    height: "64",
    ball: "dielectric"
);

const SPP: &str = "9600";

/// A program of Slurm's; daemons are often not on the path of users.
fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(["/usr/sbin".into(), "/sbin".into()]);
    folders
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}

fn output(command: &mut Command) -> Output {
    command.output().expect("a program that starts")
}

fn text(output: &Output) -> String {
    let both = [&output.stdout[..], &output.stderr[..]].concat();
    String::from_utf8_lossy(&both).into_owned()
}

/// Waits until something is there.
fn wait_for<T>(what: &str, mut find: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = find() {
            return found;
        }
        assert!(
            start.elapsed() < Duration::from_secs(240),
            "{what} never came"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// A cluster of one node with two processors.
struct Cluster {
    folder: tempfile::TempDir,
    daemons: Vec<Child>,
}

impl Drop for Cluster {
    fn drop(&mut self) {
        // The node first, so that it can say so to the others.
        while let Some(mut daemon) = self.daemons.pop() {
            // Asked first: slurmd has children of its own.
            let _ = Command::new("kill").arg(daemon.id().to_string()).status();
            let start = Instant::now();
            while matches!(daemon.try_wait(), Ok(None)) && start.elapsed() < Duration::from_secs(10)
            {
                std::thread::sleep(Duration::from_millis(50));
            }
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

impl Cluster {
    /// Starts the daemons; says why not where they are not there.
    fn start() -> Result<Cluster, String> {
        let need = |name: &str| program(name).ok_or_else(|| format!("{name} is not installed"));
        let (munged, slurmctld, slurmd) = (need("munged")?, need("slurmctld")?, need("slurmd")?);
        need("sbatch")?;
        if text(&output(Command::new("id").arg("-u"))).trim() != "0" {
            return Err("slurmd needs the superuser".to_owned());
        }
        let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
        let path = folder.path().display().to_string();
        // Munge demands that all may look for its socket.
        let open = fs::Permissions::from_mode(0o755);
        fs::set_permissions(folder.path(), open).map_err(|e| e.to_string())?;
        for name in ["state", "spool"] {
            fs::create_dir(folder.path().join(name)).map_err(|e| e.to_string())?;
        }
        let key = folder.path().join("munge.key");
        let mut random = vec![0; 1024];
        fs::File::open("/dev/urandom")
            .and_then(|mut file| file.read_exact(&mut random))
            .and_then(|()| fs::write(&key, random))
            .and_then(|()| fs::set_permissions(&key, fs::Permissions::from_mode(0o600)))
            .map_err(|e| e.to_string())?;
        let host = text(&output(Command::new("hostname").arg("-s")));
        let ports = free_ports();
        let configuration = format!(
            "ClusterName=test\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={}\nSlurmdPort={}\n\
             SlurmUser=root\nAuthType=auth/munge\nAuthInfo=socket={path}/munge.socket,cred_expire=5\n\
             CredType=cred/munge\nStateSaveLocation={path}/state\nSlurmdSpoolDir={path}/spool\n\
             SlurmctldPidFile={path}/slurmctld.pid\nSlurmdPidFile={path}/slurmd.pid\n\
             SlurmctldLogFile={path}/slurmctld.log\nSlurmdLogFile={path}/slurmd.log\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
             SelectTypeParameters=CR_Core\nJobAcctGatherType=jobacct_gather/none\n\
             AccountingStorageType=accounting_storage/none\nMpiDefault=none\nReturnToService=2\n\
             SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000,sched_interval=1\n\
             KillWait=5\nMinJobAge=600\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
             PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n",
            ports[0],
            ports[1],
            host = host.trim()
        );
        fs::write(folder.path().join("slurm.conf"), configuration).map_err(|e| e.to_string())?;
        let mut cluster = Cluster {
            folder,
            daemons: Vec::new(),
        };
        let file = |name: &str| cluster.folder.path().join(name);
        let (socket, conf) = (file("munge.socket"), file("slurm.conf"));
        let munge = Command::new(munged)
            .arg("--foreground")
            .args(["--num-threads", "2"])
            .arg(format!("--key-file={path}/munge.key"))
            .arg(format!("--socket={path}/munge.socket"))
            .arg(format!("--pid-file={path}/munged.pid"))
            .arg(format!("--seed-file={path}/munged.seed"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        cluster.daemons.push(munge.map_err(|e| e.to_string())?);
        wait_for("munge's socket", || socket.exists().then_some(()));
        for daemon in [&slurmctld, &slurmd] {
            let started = Command::new(daemon)
                .arg("-D")
                .arg("-f")
                .arg(&conf)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn();
            cluster.daemons.push(started.map_err(|e| e.to_string())?);
        }
        wait_for("an idle node", || {
            let states = text(&output(cluster.command("sinfo").args(["-h", "-o", "%T"])));
            (states.trim() == "idle").then_some(())
        });
        Ok(cluster)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A program that talks to the cluster, in its folder.
    fn command(&self, name: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(name);
        command
            .env("SLURM_CONF", self.path("slurm.conf"))
            .current_dir(self.folder.path());
        command
    }

    /// The command `halflight`.
    fn halflight(&self, arguments: &[&str]) -> Output {
        output(
            self.command(env!("CARGO_BIN_EXE_halflight"))
                .args(arguments),
        )
    }

    /// Elements of arrays in a state, as `job_index`.
    fn jobs(&self, state: &str) -> Vec<String> {
        let format = ["-h", "-r", "-o", "%F_%K", "-t", state];
        let listed = text(&output(self.command("squeue").args(format)));
        listed.lines().map(str::to_owned).collect()
    }

    /// All that the processes of the farm said.
    fn log(&self, farm: &Folder) -> String {
        let files = fs::read_dir(farm.log()).expect("the logs");
        files
            .filter_map(|file| fs::read_to_string(file.ok()?.path()).ok())
            .collect()
    }
}

/// Ports that nobody listens at.
fn free_ports() -> [u16; 2] {
    // Both are held until both are known.
    let listeners = [(), ()].map(|()| TcpListener::bind("127.0.0.1:0").expect("a free port"));
    listeners.map(|l| l.local_addr().expect("an address").port())
}

fn channels(path: &Path) -> Vec<(String, Vec<f32>)> {
    halflight::image::read_exr(path).expect("an image").channels
}

#[test]
fn eight_tasks_with_one_requeued_and_one_torn_make_the_image_of_one_run() {
    let Some(cluster) = skip::available(Cluster::start(), "HALFLIGHT_REQUIRE_SLURM") else {
        return;
    };
    fs::write(cluster.path("scene.xml"), SCENE).expect("a writable folder");
    let submitted = cluster.halflight(&[
        "farm",
        "slurm",
        "scene.xml",
        "-o",
        "out.exr",
        "--tasks",
        "8",
        "--spp",
        SPP,
        "--divide",
        "pixels",
        "--cpus-per-task",
        "1",
        "--checkpoint-interval",
        "0.1s",
        "--submit",
    ]);
    assert!(submitted.status.success(), "{}", text(&submitted));
    let farm = Folder(cluster.path("out.farm"));
    let control_last = |verb: &str| {
        let last = text(&output(
            cluster.command("squeue").args(["-h", "-r", "-o", "%F_%K"]),
        ));
        let last = last.lines().find(|job| job.ends_with("_7"));
        let last = last.expect("the last task in the queue");
        let held = output(cluster.command("scontrol").args([verb, last]));
        assert!(held.status.success(), "{}", text(&held));
    };
    // The last waits until one is torn, so that not all have ended before, however fast they are.
    control_last("hold");

    // One that has a checkpoint is killed, and put back into the queue.
    let number = |job: &str| -> u32 {
        let index = job.rsplit('_').next().and_then(|i| i.parse().ok());
        index.expect("the index of a job")
    };
    let running_beside = |other: Option<u32>| {
        wait_for("a running task", || {
            let running = cluster.jobs("RUNNING");
            let is_wanted = |i| Some(i) != other && farm.film(0, i).exists();
            let mut wanted = running.into_iter().filter(|job| is_wanted(number(job)));
            wanted.find(|job| !matches!(Record::read(&farm.film(0, number(job))), Ok(Some(_))))
        })
    };
    let killed = running_beside(None);
    let requeued = output(cluster.command("scontrol").args(["requeue", &killed]));
    assert!(requeued.status.success(), "{}", text(&requeued));
    let killed = number(&killed);

    // Another gets the signal that comes before the time limit: it saves what it has and requeues itself. One that was at its end
    // when the signal came does not, then the next gets it.
    let has_restarted = |task: u32| {
        let start = format!("task {task} on ");
        let log = cluster.log(&farm);
        log.lines()
            .any(|line| line.starts_with(&start) && line.ends_with("restart 1"))
    };
    let is_done = |task: u32| matches!(Record::read(&farm.film(0, task)), Ok(Some(_)));
    let warned = wait_for("a task that requeues itself", || {
        let job = running_beside(Some(killed));
        // Not waited for: where the controller is changing the state of the job, scancel tries again for up to a minute, and then says
        // that it failed though the signal came.
        let mut scancel = cluster
            .command("scancel")
            .args(["--batch", "--signal=TERM", &job])
            .spawn()
            .expect("a program that starts");
        let task = number(&job);
        let requeues = wait_for("what becomes of the signalled task", || {
            let restarted = has_restarted(task);
            (restarted || is_done(task)).then_some(restarted)
        });
        let _ = scancel.kill();
        let _ = scancel.wait();
        requeues.then_some(task)
    });

    // A finished one is torn, while others are still rendered.
    let torn = wait_for("a finished task", || {
        (0..8).find(|&i| i != killed && i != warned && is_done(i))
    });
    let film = farm.film(0, torn);
    let bytes = fs::read(&film).expect("a film");
    fs::write(&film, &bytes[..bytes.len() / 2]).expect("a writable film");
    control_last("release");

    // The merge finds it and says so.
    let all_ended = || {
        let listed = text(&output(cluster.command("squeue").arg("-h")));
        listed.trim().is_empty().then_some(())
    };
    wait_for("the end of all jobs", all_ended);
    let log = cluster.log(&farm);
    assert!(log.contains(&format!("torn: {}", film.display())), "{log}");
    assert!(!cluster.path("out.exr").exists());
    assert!(has_restarted(killed) && has_restarted(warned), "{log}");
    let status = cluster.halflight(&["farm", "status", "out.farm"]);
    let said = text(&status);
    assert_eq!(status.status.code(), Some(2), "{said}");
    assert!(said.contains("7 of 8 tasks done"), "{said}\n{log}");
    assert!(said.contains(&format!("torn: {torn}\n")), "{said}");

    // It alone is rendered again.
    let resumed = cluster.halflight(&["farm", "resume", "out.farm", "--submit"]);
    assert!(resumed.status.success(), "{}", text(&resumed));
    assert!(
        text(&resumed).contains(&format!("render {torn}: job")),
        "{}",
        text(&resumed)
    );
    wait_for("the end of all jobs", all_ended);
    let status = cluster.halflight(&["farm", "status", "--verify", "out.farm"]);
    assert!(
        status.status.success(),
        "{}\n{}",
        text(&status),
        cluster.log(&farm)
    );
    let again = cluster.halflight(&["farm", "resume", "out.farm"]);
    assert!(text(&again).contains("nothing to do"), "{}", text(&again));

    // One process with the same samples.
    let one = cluster.halflight(&[
        "render",
        "scene.xml",
        "--spp",
        SPP,
        "-o",
        "one.exr",
        "--no-png",
        "--quiet",
    ]);
    assert!(one.status.success(), "{}", text(&one));
    let (merged, one) = (cluster.path("out.exr"), cluster.path("one.exr"));
    assert!(channels(&merged) == channels(&one));
}
