#!/usr/bin/env python3
"""Error and time of adaptive over progressive photon mapping with the same photons, and how their errors fall (thesis, table 5.2).

    python3 benches/photons.py target/release/halflight FOLDER [--scenes box-point,...] [--passes 19,38,76,152]

FOLDER/SCENE/scene.xml are rendered, FOLDER/reference/SCENE.exr are measured against. Both algorithms trace 65,536 light paths a pass, as the
thesis's; progressive photon mapping starts each pixel with the distance to its tenth nearest photon. 76 passes are five
million photons. Errors are relative squared errors, means over the seeds, with the reference's own variance in them; slopes are those of
least squares in logarithms over the passes.
"""

import argparse
import json
import math
import os
import subprocess
import tempfile

ALGORITHMS = {"sppm": ["--integrator", "sppm", "--nearest", "10"], "appm": ["--integrator", "appm"]}


def render(options, scene, algorithm, passes, seed):
    """Relative squared error and processor seconds of an image."""
    image = os.path.join(tempfile.mkdtemp(), "image.exr")
    command = [options.halflight, "render", f"{options.folder}/{scene}/scene.xml", "-q", "--no-png", "-o", image]
    command += ["--photons", "65536", "--spp", str(passes), "--seed", str(seed)] + ALGORITHMS[algorithm]
    child = subprocess.Popen(command)
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    reference = f"{options.folder}/reference/{scene}.exr"
    compared = subprocess.run([options.halflight, "compare", image, reference, "--json"], capture_output=True, text=True, check=True)
    os.remove(image)
    return json.loads(compared.stdout)["metrics"]["relative-mse"], usage.ru_utime + usage.ru_stime


def slope(passes, errors):
    """Exponent of the power law through the errors."""
    x, y = [math.log(n) for n in passes], [math.log(max(e, 1e-12)) for e in errors]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("folder")
    parser.add_argument("--scenes", default="box-point,torus-point,torus,glass-sphere-lamp,ring")
    parser.add_argument("--passes", default="19,38,76,152", help="the third is that of the table")
    parser.add_argument("--seeds", type=int, default=2)
    options = parser.parse_args()
    passes = [int(n) for n in options.passes.split(",")]
    at = min(2, len(passes) - 1)
    print("| scene | sppm | appm | appm over sppm | time | slope of sppm | slope of appm |")
    print("|---" * 7 + "|")
    for scene in options.scenes.split(","):
        errors, seconds = {}, {}
        for algorithm in ALGORITHMS:
            runs = [[render(options, scene, algorithm, n, seed) for seed in range(1, options.seeds + 1)] for n in passes]
            errors[algorithm] = [sum(e for e, _ in run) / len(run) for run in runs]
            seconds[algorithm] = sum(s for _, s in runs[at])
        sppm, appm = errors["sppm"][at], errors["appm"][at]
        slopes = [slope(passes, errors[a]) for a in ALGORITHMS]
        time = seconds["appm"] / seconds["sppm"]
        print(f"| {scene} | {sppm:.4f} | {appm:.4f} | {appm / sppm:.2f} | {time:.2f} | {slopes[0]:.2f} | {slopes[1]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
