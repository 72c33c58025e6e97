#!/usr/bin/env python3
"""How the errors of photon mapping fall over growing numbers of passes, on scenes of a corpus.

    python3 benches/photon-slopes.py target/release/halflight FOLDER [--every 3] [--passes 4,16,64]

FOLDER/manifest.json lists scenes, film widths, parameters and references. Every third scene is rendered with each algorithm and
number of passes; errors are relative squared errors without the worst thousandth of the pixels, less the reference's variance,
slopes those of least squares in logarithms. Theory: -2/3 for a bias that falls as the variance does, -1 where variance rules.
"""

import argparse
import json
import os
import subprocess
import tempfile

from photons import slope

ALGORITHMS = ["sppm", "appm", "vcm"]


def error_of(options, entry, algorithm, passes):
    """Error of one image, nothing if the scene cannot be rendered so."""
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "image.exr")
        command = [options.halflight, "render", os.path.join(options.folder, entry["scene"]), "-q", "--no-png", "-o", image]
        command += ["--width", str(entry["width"]), "--integrator", algorithm, "--threads", str(options.threads)]
        for name, value in entry["params"].items():
            command += ["-D", f"{name}={value}"]
        # After the parameters of the scene, whose number of samples is not this.
        if subprocess.run(command + ["--spp", str(passes)], stderr=subprocess.DEVNULL).returncode != 0:
            return None
        reference = os.path.join(options.folder, entry["reference"])
        compared = subprocess.run([options.halflight, "compare", image, reference, "--json"], capture_output=True, text=True)
        metrics = json.loads(compared.stdout)["metrics"]
        return metrics["trimmed-relative-mse"] - (metrics.get("reference-variance") or 0.0)


def slope_above_noise(passes, errors):
    """Slope of the errors; nothing where one is lost in the reference's variance."""
    if any(e is None or e <= 0.0 for e in errors):
        return None
    return slope(passes, errors)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("folder")
    parser.add_argument("--every", type=int, default=3)
    parser.add_argument("--passes", default="4,16,64")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    options = parser.parse_args()
    passes = [int(n) for n in options.passes.split(",")]
    with open(os.path.join(options.folder, "manifest.json")) as file:
        entries = json.load(file)[:: options.every]
    print("| scene | " + " | ".join(f"{a}: first and last error, slope" for a in ALGORITHMS) + " |")
    print("|---" * (1 + len(ALGORITHMS)) + "|")
    slopes = {algorithm: [] for algorithm in ALGORITHMS}
    for entry in entries:
        cells = []
        for algorithm in ALGORITHMS:
            errors = [error_of(options, entry, algorithm, n) for n in passes]
            if errors[0] is None or errors[-1] is None:
                cells.append("no image")
                continue
            found = slope_above_noise(passes, errors)
            if found is not None:
                slopes[algorithm].append(found)
            text = "within the reference's noise" if found is None else f"{found:.2f}"
            cells.append(f"{errors[0]:.2g} {errors[-1]:.2g} {text}")
        print(f"| {entry['name']} | " + " | ".join(cells) + " |", flush=True)
    for algorithm, found in slopes.items():
        found.sort()
        if found:
            print(f"{algorithm}: slopes {found[0]:.2f} to {found[-1]:.2f}, median {found[len(found) // 2]:.2f}, of {len(found)} scenes")


if __name__ == "__main__":
    main()
