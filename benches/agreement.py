#!/usr/bin/env python3
"""Whether Markov chains agree with independent samples, block by block of the image, from the scatter of independent seeds alone.

    python3 benches/agreement.py target/release/halflight FOLDER SCENE:TRUTH:SPP ... [--integrators hslt,memlt] [--seeds 16] [--width 48]
        [--spp 64] [--work WORK]

For each of FOLDER/SCENE/scene.xml, TRUTH (path or bdpt) with SPP samples per pixel and every integrator are rendered once for each seed. Of the luminance of
each block of pixels the difference of means over its standard error, both from the seeds (Welch), becomes a score of the normal distribution
(Wallace 1959). Over all blocks that are not black: the root mean square of the scores, which is one if means agree, the largest, and the
probability of one that large in any block. Blocks that few seeds light have skewed sums, by which the largest scores are too large. The last number is
the median over blocks of the ratio of the integrator's median over seeds to the truth: below one where noise is skewed.
A row `less` has the scores of differences between two integrators whose chains start from the same candidates, seed by seed.
A row `reference` tells by how much FOLDER/reference/SCENE.exr is away from the truth, in the truth's own standard errors, and in which block most.
Images stay in WORK, and are not rendered again.
"""

import argparse
import array
import math
import pathlib
import statistics
import subprocess
import sys


def luminance(path):
    """Rows of luminance of a PFM, from the top."""
    data = path.read_bytes()
    kind, size, scale, pixels = data.split(b"\n", 3)
    width, height = map(int, size.split())
    if kind != b"PF" or len(pixels) != 12 * width * height:
        raise SystemExit(f"{path}: not a PFM of three channels")
    values = array.array("f", pixels)
    if (float(scale) < 0) != (sys.byteorder == "little"):
        values.byteswap()
    rows = []
    for y in reversed(range(height)):
        row = values[3 * y * width : 3 * (y + 1) * width]
        rows.append([0.2126 * r + 0.7152 * g + 0.0722 * b for r, g, b in zip(row[0::3], row[1::3], row[2::3])])
    return rows


def blocks(rows, size):
    """Means of square blocks, those of a row one after the other."""
    tall, wide = len(rows) // size, len(rows[0]) // size
    inside = lambda x, y: (rows[size * y + j][size * x + i] for j in range(size) for i in range(size))
    return [math.fsum(inside(x, y)) / size**2 for y in range(tall) for x in range(wide)]


def render(options, scene, integrator, spp, seed):
    image = pathlib.Path(options.work) / scene / f"{integrator}-{spp}-{options.width}-{seed}.pfm"
    if not image.exists():
        image.parent.mkdir(parents=True, exist_ok=True)
        command = [options.halflight, "render", f"{options.folder}/{scene}/scene.xml", "--integrator", integrator, "--width", str(options.width)]
        command += ["--spp", str(spp), "--seed", str(seed), "--threads", "1", "-q", "--no-png", "-o", str(image)]
        subprocess.run(command, check=True)
    return luminance(image)


def moments(images):
    """Mean and squared standard error of each block."""
    columns = list(zip(*images))
    return [(statistics.fmean(c), statistics.variance(c) / len(c)) for c in columns]


def scores(truth, found, counts):
    """Normal scores of the differences of blocks that are lit."""
    out = []
    for (a, va), (b, vb) in zip(truth, found):
        if not va + vb > 0.0:
            continue
        freedom = (va + vb) ** 2 / (va**2 / (counts[0] - 1) + vb**2 / (counts[1] - 1))
        t = (b - a) / math.sqrt(va + vb)
        # Student's t as a score of the normal distribution.
        score = math.sqrt(freedom * math.log1p(t * t / freedom)) * (8 * freedom + 1) / (8 * freedom + 3)
        out.append(math.copysign(score, t))
    return out


def root_mean_square(values):
    return math.sqrt(statistics.fmean(v * v for v in values))


def summary(of_all):
    largest = max(map(abs, of_all))
    chance = -math.expm1(len(of_all) * math.log1p(-math.erfc(largest / math.sqrt(2.0))))
    return f"{root_mean_square(of_all):.2f}, {largest:.1f}, {chance:.2g}"


def compare(options, name, truth, found):
    totals = [[math.fsum(v for row in rows for v in row) for rows in images] for images in (truth, found)]
    means = [statistics.fmean(t) for t in totals]
    error = math.sqrt(sum(statistics.variance(t) / len(t) / m**2 for t, m in zip(totals, means)))
    cells = [name, f"{means[1] / means[0]:.4f} +- {error:.4f}"]
    for size in options.blocks:
        a, b = ([blocks(rows, size) for rows in images] for images in (truth, found))
        expected = moments(a)
        typical = [statistics.median(c) / m for c, (m, _) in zip(zip(*b), expected) if m > 0.0]
        cells.append(f"{summary(scores(expected, moments(b), (len(a), len(b))))}, {statistics.median(typical):.3f}")
    print("| " + " | ".join(cells) + " |", flush=True)


def compare_pairs(options, name, first, second):
    """Of chains that start from the same candidates, which those of the same seed do."""
    cells = [name, ""]
    for size in options.blocks:
        pairs = [zip(blocks(a, size), blocks(b, size)) for a, b in zip(first, second)]
        differences = moments([[b - a for a, b in pair] for pair in pairs])
        none = [(0.0, 0.0)] * len(differences)
        cells.append(summary(scores(none, differences, (2, len(pairs)))))
    print("| " + " | ".join(cells) + " |", flush=True)


def look_at_reference(options, scene, truth):
    """The blocks of the reference that are those of the smallest blocks here."""
    image = pathlib.Path(options.work) / scene / "reference.pfm"
    if not image.exists():
        subprocess.run([options.halflight, "image", "convert", "-q", f"{options.folder}/reference/{scene}.exr", "-o", str(image)], check=True)
    rows = luminance(image)
    size = options.blocks[0]
    reference = blocks(rows, size * len(rows[0]) // options.width)
    wide = options.width // size
    means = moments([blocks(r, size) for r in truth])
    away = [((r - m) / math.sqrt(v), r, m, i) for i, (r, (m, v)) in enumerate(zip(reference, means)) if v > 0.0]
    worst, r, m, i = max(away, key=lambda a: abs(a[0]))
    whole = statistics.fmean(reference) / statistics.fmean(m for m, _ in means)
    print(f"| {scene}, reference | {whole:.4f} | {root_mean_square([a[0] for a in away]):.1f}, {abs(worst):.0f} at {i % wide}, {i // wide}: {r:.3f} for {m:.3f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("folder")
    parser.add_argument("scenes", nargs="+", metavar="SCENE:TRUTH:SPP")
    parser.add_argument("--integrators", default="hslt,memlt")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--width", type=int, default=48)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--blocks", type=lambda text: [int(n) for n in text.split(",")], default=[2, 8])
    parser.add_argument("--work", default="agreement")
    options = parser.parse_args()
    print("| scene, integrator | mean over truth | " + " | ".join(f"{n} x {n} pixels" for n in options.blocks) + " |")
    print("|---" * (2 + len(options.blocks)) + "|")
    for entry in options.scenes:
        scene, kind, spp = entry.split(":")
        seeds = range(1, options.seeds + 1)
        truth = [render(options, scene, kind, int(spp), seed) for seed in seeds]
        look_at_reference(options, scene, truth)
        first = None
        for integrator in options.integrators.split(","):
            found = [render(options, scene, integrator, options.spp, seed) for seed in seeds]
            compare(options, f"{scene}, {integrator} over {kind}", truth, found)
            if first is None:
                first = integrator, found
            else:
                compare_pairs(options, f"{scene}, {integrator} less {first[0]}, by seeds", first[1], found)


if __name__ == "__main__":
    main()
