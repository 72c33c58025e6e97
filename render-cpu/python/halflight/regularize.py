"""Regularisation of BSDFs over arrays: bounds, the roughness for a bound, schedules of bandwidths, mollifiers.

Bounds and tau are per steradian; eta is the transmitted over the incident index. Sources: Jendersie and Grosch 2019
("Microfacet Model Regularization for Robust Light Transport"), Kaplanyan 2017, chapters 5 and 6. Shapes broadcast.

distribution: ``beckmann``, ``ggx``, or ``phong`` (a power of the cosine).
masking: ``smith`` (separable), or ``v-cavity``, for which the bounds hold at normal incidence only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._broadcast import Float32, flatten

TAU_MAX: float = _native.TAU_MAX
"""Largest threshold, which means "not regularised"."""

_DISTRIBUTIONS = {"beckmann": 0, "ggx": 1, "phong": 2}
_MASKINGS = {"v-cavity": 0, "smith": 1}
_MOLLIFIERS = {"constant": 0, "parabolic": 1, "quartic": 2, "perlin": 3}


def _choice(what: str, name: str, known: dict[str, int]) -> int:
    if name not in known:
        raise ValueError(f"no {what} {name!r}; there are {', '.join(known)}")
    return known[name]


def _bound(
    kind: str, alpha: ArrayLike, alpha_v: ArrayLike | None, eta: ArrayLike, distribution: str, masking: str
) -> Float32:
    other = alpha if alpha_v is None else alpha_v
    _, (u, v, eta), shape = flatten([], [alpha, other, eta])
    masking_kind = _choice("masking", masking, _MASKINGS)
    distribution_kind = _choice("distribution", distribution, _DISTRIBUTIONS)
    return _native.bound(kind, masking_kind, distribution_kind, u, v, eta).reshape(shape)


def reflection_bound(
    alpha: ArrayLike,
    alpha_v: ArrayLike | None = None,
    *,
    distribution: str = "ggx",
    masking: str = "smith",
) -> Float32:
    """Largest value of a reflecting microfacet BSDF of roughness alpha (and alpha_v across), 1/sr: shape (...).

    Equation 8. Tight for GGX up to alpha 1 and Beckmann up to 1/sqrt(2) with Smith's masking.
    """
    return _bound("reflection", alpha, alpha_v, 1.0, distribution, masking)


def refraction_bound(
    alpha: ArrayLike,
    eta: ArrayLike,
    alpha_v: ArrayLike | None = None,
    *,
    distribution: str = "ggx",
    masking: str = "smith",
) -> Float32:
    """Upper bound of a refracting microfacet BSDF, 1/sr, for radiance and for importance: shape (...). Equation 9."""
    return _bound("refraction", alpha, alpha_v, eta, distribution, masking)


def tight_refraction_bound(alpha: ArrayLike, eta: ArrayLike, *, distribution: str = "ggx") -> Float32:
    """Upper bound of an isotropic refracting BSDF with Smith's masking, without the looseness of equation 9: shape (...).

    For alpha up to 1."""
    return _bound("tight refraction", alpha, None, eta, distribution, "smith")


def alpha_hat(
    tau: ArrayLike,
    eta: ArrayLike | None = None,
    *,
    distribution: str = "ggx",
    masking: str = "smith",
    tight: bool = True,
) -> Float32:
    """The smallest isotropic roughness whose bound is at most tau, at most 1: shape (...).

    Of reflection without ``eta``, of refraction with it; ``tight`` takes :func:`tight_refraction_bound` where masking is
    Smith's.
    """
    kind = "reflection"
    if eta is not None:
        kind = "tight refraction" if tight and masking == "smith" else "refraction"
    _, (tau, index), shape = flatten([], [tau, 1.0 if eta is None else eta])
    masking_kind = _choice("masking", masking, _MASKINGS)
    distribution_kind = _choice("distribution", distribution, _DISTRIBUTIONS)
    return _native.alpha_hat(kind, masking_kind, distribution_kind, tau, index).reshape(shape)


def _schedule(kind: str, initial: ArrayLike, n: ArrayLike, rate: float) -> Float32:
    n = np.asarray(n)
    if n.dtype.kind not in "ui" or (n.size and (n.min() < 0 or n.max() > 0xFFFFFFFF)):
        raise ValueError("n counts samples or iterations: whole numbers from 1 to 2^32 - 1")
    initial = np.asarray(initial, dtype=np.float32)
    shape = np.broadcast_shapes(initial.shape, n.shape)
    flat = np.ascontiguousarray(np.broadcast_to(initial, shape)).reshape(-1)
    count = np.ascontiguousarray(np.broadcast_to(n, shape), dtype=np.uint32).reshape(-1)
    return _native.schedule(kind, flat, count, rate).reshape(shape)


def tau(tau_0: ArrayLike, n: ArrayLike, exponent: float = 1.0 / 6.0) -> Float32:
    """tau_N, the largest value that a regularised BSDF may have in iteration N = 1, 2, ..., 1/sr: shape (...).

    Equation 16: the value of the constant cone whose tangent falls as N^-exponent, from tau_0 at N = 1.
    """
    return _schedule("tau", tau_0, n, exponent)


def power_law(r_0: ArrayLike, n: ArrayLike, exponent: float) -> Float32:
    """Bandwidths r_0 n^-exponent of sample n: shape (...). Consistent in d dimensions for an exponent below 1/d."""
    return _schedule("power law", r_0, n, exponent)


def geometric(r_0: ArrayLike, n: ArrayLike, one_minus_gamma: float = 1e-4) -> Float32:
    """Bandwidths r_0 gamma^n of mutation n of a Markov chain: shape (...)."""
    return _schedule("geometric", r_0, n, one_minus_gamma)


def mollifier(t: ArrayLike, kind: str = "quartic", dimensions: int = 2) -> Float32:
    """Value K(t) of a mollifier of bandwidth 1 and mass 1 at the distances t >= 0: shape (...).

    kind: ``constant``, ``parabolic``, ``quartic`` or ``perlin``; zero from t = 1 on.
    """
    _, (t,), shape = flatten([], [t])
    return _native.mollifier_eval(_choice("mollifier", kind, _MOLLIFIERS), _dimensions(dimensions), t).reshape(shape)


def mollifier_moments(kind: str = "quartic", dimensions: int = 2) -> tuple[float, float]:
    """Second moment per axis, which makes the bias, and square norm, which makes the variance."""
    return _native.mollifier_moments(_choice("mollifier", kind, _MOLLIFIERS), _dimensions(dimensions))


def _dimensions(dimensions: int) -> int:
    if dimensions not in (1, 2, 3):
        raise ValueError(f"dimensions is {dimensions}; there are mollifiers in 1, 2 and 3")
    return dimensions


def microfacet_distribution(cosine: ArrayLike, alpha: ArrayLike, *, distribution: str = "ggx") -> Float32:
    """D of an isotropic distribution at normals with the given cosine, 1/sr: shape (...)."""
    _, (alpha, cosine), shape = flatten([], [alpha, cosine])
    kind = _choice("distribution", distribution, _DISTRIBUTIONS)
    return _native.microfacets(kind, alpha, cosine, False).reshape(shape)


def smith_g1(cosine: ArrayLike, alpha: ArrayLike, *, distribution: str = "ggx") -> Float32:
    """Smith's masking G1 of an isotropic distribution for directions with the given cosine: shape (...)."""
    _, (alpha, cosine), shape = flatten([], [alpha, cosine])
    kind = _choice("distribution", distribution, _DISTRIBUTIONS)
    return _native.microfacets(kind, alpha, cosine, True).reshape(shape)
