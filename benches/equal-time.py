#!/usr/bin/env python3
"""Errors of algorithms at equal processor time.

    python3 benches/equal-time.py target/release/halflight FOLDER --integrators bdpt,mlt [--scenes torus,ring] [--seconds 30]
        [--seeds 1] [-- further arguments of render]

FOLDER/SCENE/scene.xml are rendered by one thread until the process has had the seconds of processor time (user and system, reading the scene in
it), then asked to end, which keeps what there is. Errors against FOLDER/reference/SCENE.exr are relative squared errors less the
reference's own variance, of all pixels and without the worst one of a thousand; brightness is the image's mean over that of the
reference. What other programs do on the machine costs time of the clock, and little of this.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

SCENES = "torus,glass-sphere-lamp,veach-bidir,ring,glossy-chain"
TICKS = os.sysconf("SC_CLK_TCK")


def processor_seconds(pid):
    """User and system time of a process; nothing when it has ended."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
    except (OSError, IndexError):
        return None
    return (int(fields[11]) + int(fields[12])) / TICKS


def mean(halflight, image):
    """Mean of the three channels of an image."""
    found = subprocess.run([halflight, "image", "statistics", image, "--json"], capture_output=True, text=True, check=True)
    values = json.loads(found.stdout)["values"]
    return sum(values[c]["mean"] for c in ("red", "green", "blue")) / 3


def race(options, scene, integrator, seed, image):
    """Renders for the time; processor seconds, error, error without the worst, and brightness."""
    command = [options.halflight, "render", f"{options.folder}/{scene}/scene.xml", "--integrator", integrator, "--seed", str(seed)]
    command += ["--threads", "1", "--time", "10h", "-q", "--no-png", "-o", image] + options.arguments
    child = subprocess.Popen(command)
    while (spent := processor_seconds(child.pid)) is not None and spent < options.seconds:
        if os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            break
        time.sleep(0.05)
    child.send_signal(signal.SIGTERM)
    _, _, usage = os.wait4(child.pid, 0)
    if not os.path.exists(image):
        raise SystemExit(f"{' '.join(command)} left no image")
    reference = f"{options.folder}/reference/{scene}.exr"
    compared = subprocess.run([options.halflight, "compare", image, reference, "--json"], capture_output=True, text=True, check=True)
    metrics = json.loads(compared.stdout)["metrics"]
    brightness = mean(options.halflight, image) / mean(options.halflight, reference)
    os.remove(image)
    own = metrics.get("reference-variance", 0.0)
    seconds = usage.ru_utime + usage.ru_stime
    return seconds, metrics["relative-mse"] - own, metrics["trimmed-relative-mse"] - own, brightness


def main():
    arguments = sys.argv[1:]
    rest = arguments.index("--") if "--" in arguments else len(arguments)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("folder")
    parser.add_argument("--integrators", required=True)
    parser.add_argument("--scenes", default=SCENES)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--seeds", type=int, default=1)
    options = parser.parse_args(arguments[:rest])
    options.arguments = arguments[rest + 1 :]
    print("| integrator | scene | seconds | error | without the worst | brightness |")
    print("|---" * 6 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for integrator in options.integrators.split(","):
            for scene in options.scenes.split(","):
                image = os.path.join(folder, "image.exr")
                runs = [race(options, scene, integrator, seed, image) for seed in range(1, options.seeds + 1)]
                seconds, error, trimmed, brightness = (sum(values) / len(runs) for values in zip(*runs))
                print(f"| {integrator} | {scene} | {seconds:.1f} | {error:.4g} | {trimmed:.4g} | {brightness:.4f} |", flush=True)


if __name__ == "__main__":
    main()
