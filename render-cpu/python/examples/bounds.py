"""Plots the bounds of regularised microfacet models against the largest values that brute force finds.

    pip install matplotlib
    python bounds.py [bounds.png]

For each roughness, f = D G1(wi) G1(wo) / (4 cos_i cos_o) is evaluated over a grid of pairs of directions, down to elevations
of 1e-6 and around the mirror direction, with the BSDF itself rather than with its formula. Equation 8 of Jendersie and
Grosch 2019 holds for GGX up to alpha 1 and for Beckmann up to 1/sqrt(2), and is tight there; beyond, the grid finds
larger values.
"""

import sys

import numpy as np

from halflight import Bsdf, regularize

ALPHA = np.linspace(0.05, 1.0, 20)


def grid() -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions: cosines from grazing to the normal, azimuths of wo from opposite to 1 radian off."""
    cosine = np.concatenate([np.geomspace(1e-6, 0.1, 50), np.linspace(0.1, 1.0, 50)])
    sine = np.sqrt((1 - cosine) * (1 + cosine))
    azimuth = np.concatenate([[0.0], np.geomspace(1e-6, 1.0, 60)])[:, None]
    wi = np.stack([sine, np.zeros_like(sine), cosine], axis=-1)[:, None, None]
    across, along = np.sin(azimuth) * sine, -np.cos(azimuth) * sine
    wo = np.stack([along, across, np.broadcast_to(cosine, along.shape)], axis=-1)
    return wi, wo


def largest(distribution: str, alpha: float) -> float:
    """The largest value that the grid finds, for a reflectance of one."""
    bsdf = Bsdf("roughconductor", material="none", distribution=distribution, alpha=float(alpha))
    return float(bsdf.eval(*grid()).max())


def main() -> None:
    rows = {}
    for distribution in ("ggx", "beckmann"):
        bound = regularize.reflection_bound(ALPHA, distribution=distribution)
        found = np.array([largest(distribution, alpha) for alpha in ALPHA])
        rows[distribution] = (bound, found)
        print(f"{distribution}: largest value over bound {np.round(found / bound, 3)}")

    try:
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        print("no picture: matplotlib is not installed")
        return
    figure, axes = pyplot.subplots()
    for distribution, (bound, found) in rows.items():
        (line,) = axes.semilogy(ALPHA, bound, label=f"bound, {distribution}")
        axes.semilogy(ALPHA, found, "x", color=line.get_color(), label=f"brute force, {distribution}")
    axes.set_xlabel("alpha")
    axes.set_ylabel("largest value per steradian")
    axes.legend()
    path = sys.argv[1] if len(sys.argv) > 1 else "bounds.png"
    figure.savefig(path)
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
