#!/usr/bin/env python3
"""Samples per second of Halflight and of Mitsuba 3 on the same scenes, cores, sizes and numbers of samples.

Run it with a Python that has the `mitsuba` package:

    python3 benches/against-mitsuba.py target/release/halflight SCENE.xml[,name=value...] ... [--width 400] [--spp 64]

Both programs run as processes of their own, in turn, `--runs` times, once with `--spp` samples and once with one. The
table holds million samples per second of processor time (user and system, all threads together) and of wall time, medians
over the runs, of whole processes; `render` is the difference of the two runs, which leaves start-up, reading and tree
building out. Processor time is the one to compare where the machine has other work.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time


def mitsuba_child(variant, path, width, spp, parameters):
    """Renders one scene with Mitsuba and writes the size of its film."""
    import mitsuba as mi

    mi.set_variant(variant)
    scene = mi.load_file(path, **dict(p.split("=", 1) for p in parameters))
    film = mi.traverse(scene)
    key = next(k for k in film.keys() if k.endswith("film.size"))
    full = film[key]
    film[key] = [width, round(full[1] * width / full[0])]
    film.update()
    image = mi.render(scene, spp=spp)
    mi.Bitmap(image).write(os.path.join(tempfile.mkdtemp(), "image.exr"))
    print("pixels", image.shape[0] * image.shape[1])


def timed(command):
    """Processor and wall seconds of a process and what it wrote."""
    start = time.time()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    output = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{command[0]} failed on {command}")
    return usage.ru_utime + usage.ru_stime, time.time() - start, output


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("scene", nargs="+", help="SCENE.xml or SCENE.xml,name=value,...")
    parser.add_argument("--width", type=int, default=400)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--variant", default="scalar_rgb")
    options = parser.parse_args()
    image = os.path.join(tempfile.mkdtemp(), "image.exr")
    print(f"| scene | Halflight | {options.variant} | ratio | ratio, wall | render: Halflight | {options.variant} | ratio |")
    print("|---|---|---|---|---|---|---|---|")
    for argument in options.scene:
        path, *parameters = argument.split(",")
        seconds = {(who, spp): [] for who in "hm" for spp in (options.spp, 1)}
        pixels = 0
        for _ in range(options.runs):
            for spp in (options.spp, 1):
                defines = [word for p in parameters for word in ("-D", p)]
                ours = [options.halflight, "render", path, "--quiet", "--no-png", "-o", image]
                ours += ["--width", str(options.width), "--spp", str(spp), *defines]
                seconds["h", spp].append(timed(ours)[:2])
                theirs = [sys.executable, __file__, "--child", options.variant, path]
                theirs += [str(options.width), str(spp), *parameters]
                cpu, wall, output = timed(theirs)
                seconds["m", spp].append((cpu, wall))
                pixels = int(output.split("pixels")[-1])

        def median(who, spp, column):
            return statistics.median(run[column] for run in seconds[who, spp])

        samples = pixels * options.spp * 1e-6
        whole = {who: samples / median(who, options.spp, 0) for who in "hm"}
        wall = {who: samples / median(who, options.spp, 1) for who in "hm"}
        extra = pixels * (options.spp - 1) * 1e-6
        only = {who: extra / (median(who, options.spp, 0) - median(who, 1, 0)) for who in "hm"}
        name = os.path.splitext(os.path.basename(path))[0]
        if name == "scene":
            name = os.path.basename(os.path.dirname(path))
        print(
            f"| {name} | {whole['h']:.2f} | {whole['m']:.2f} | {whole['h'] / whole['m']:.2f} "
            f"| {wall['h'] / wall['m']:.2f} | {only['h']:.2f} | {only['m']:.2f} | {only['h'] / only['m']:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        mitsuba_child(sys.argv[2], sys.argv[3], int(sys.argv[4]), int(sys.argv[5]), sys.argv[6:])
    else:
        main()
