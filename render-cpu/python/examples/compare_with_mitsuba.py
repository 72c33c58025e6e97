"""Renders one scene with Halflight and with Mitsuba 3 and tests whether both estimate the same radiance.

    pip install mitsuba
    python compare_with_mitsuba.py ../../scenes/cornell-box.xml [samples per pixel]

Mitsuba has no variance per pixel, so it renders several independent images with different seeds; their mean is the
reference, and their spread its variance. The z-test then compares pixel by pixel.
"""

import sys

import numpy as np

import halflight

WIDTH = 64
RUNS = 16


def reference(path: str, size: tuple[int, int], spp: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean of Mitsuba's images, and the variance of that mean."""
    import mitsuba

    # The variant that needs no just-in-time compiler; others are faster where they work.
    mitsuba.set_variant("scalar_rgb")
    scene = mitsuba.load_file(path)
    film = mitsuba.traverse(scene.sensors()[0])
    film["film.size"] = list(size)
    film.update()
    images = [np.array(mitsuba.render(scene, spp=spp, seed=seed))[..., :3] for seed in range(RUNS)]
    return np.mean(images, axis=0), np.var(images, axis=0, ddof=1) / RUNS


def main() -> None:
    path = sys.argv[1]
    spp = int(sys.argv[2]) if len(sys.argv) > 2 else 16
    scene = halflight.load(path, width=WIDTH)
    ours = scene.render(spp=spp * RUNS)
    mean, variance = reference(path, scene.size, spp)

    # An image with the variance of the reference: the arrays of a render, filled.
    theirs = scene.render(spp=1)
    theirs.radiance[...] = mean
    theirs.variance[...] = variance
    result = halflight.compare(ours, theirs, reference_spp=spp * RUNS, reference_runs=RUNS)
    for name, value in result.metrics.items():
        print(f"{name:>14} {value:.6g}")
    print("the same radiance" if result.passes else "not the same radiance", f"(mean z {result.mean_z:+.3f})")


if __name__ == "__main__":
    main()
