#!/usr/bin/env python3
"""Samples per second of processor time of several integrators on the same scenes, and their ratios to the first.

    python3 benches/samples-per-second.py target/release/halflight SCENE.xml ... [--integrators path,bdpt] [--spp 64,32]

Each integrator renders each scene with its number of samples and with one, in turn; the difference of processor times (user
and system, all threads together) leaves start-up, reading and tree building out.
"""

import argparse
import os
import re
import subprocess
import tempfile


def run(binary, scene, integrator, spp, image):
    """Processor seconds of a render."""
    command = [binary, "render", scene, "-o", image, "--integrator", integrator, "--spp", str(spp)]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    message = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed: {message}")
    return usage.ru_utime + usage.ru_stime


def pixels(binary, scene):
    """Number of pixels of the film."""
    text = subprocess.run([binary, "info", scene], capture_output=True, text=True, check=True).stdout
    width, height = re.search(r"(\d+) x (\d+)", text).groups()
    return int(width) * int(height)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("scene", nargs="+")
    parser.add_argument("--integrators", default="path,bdpt")
    parser.add_argument("--spp", default="64,32", help="samples of each integrator; the last holds for the rest")
    options = parser.parse_args()
    integrators = options.integrators.split(",")
    samples = [int(n) for n in options.spp.split(",")]
    samples += samples[-1:] * (len(integrators) - len(samples))
    image = os.path.join(tempfile.mkdtemp(), "image.exr")
    print("| scene | " + " | ".join(integrators) + " | over the first |")
    print("|---" * (len(integrators) + 2) + "|")
    for scene in options.scene:
        count = pixels(options.halflight, scene)
        rates = []
        for integrator, spp in zip(integrators, samples):
            one, many = (run(options.halflight, scene, integrator, n, image) for n in (1, spp))
            rates.append(count * (spp - 1) / (many - one) / 1e6)
        name = os.path.basename(os.path.dirname(os.path.abspath(scene)))
        ratios = ", ".join(f"{rate / rates[0]:.3f}" for rate in rates[1:])
        print(f"| {name} | " + " | ".join(f"{rate:.3f}" for rate in rates) + f" | {ratios} |", flush=True)


if __name__ == "__main__":
    main()
