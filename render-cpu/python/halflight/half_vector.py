"""Half vectors, their charts and Jacobians, over arrays.

H = wi + eta wo, h = +-H / \\|H\\| on the side of the normal; eta is the index on the side of wo over the index on the side
of wi, 1 for any reflection. Two charts of the hemisphere of h around the normal: *projected*, h_perp, the unit disk; and
*slope*, h_pp = h_perp / cos, the plane. Sources: Kaplanyan 2017, chapter 7; Walter et al. 2007. Shapes broadcast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._broadcast import Float32, flatten

GAMMA = 0.1
"""The thesis's factor on steps: a tenth of the optimum."""


def half_vector(
    wi: ArrayLike, wo: ArrayLike, eta: ArrayLike = 1.0, n: ArrayLike = (0.0, 0.0, 1.0)
) -> tuple[Float32, Float32]:
    """The half vector of unit directions wi, wo, shape (..., 3), turned to the side of n, and \\|wi + eta wo\\|, shape
    (...), zero where there is no half vector."""
    (wi, wo, n), (eta,), shape = flatten([("wi", wi, 3), ("wo", wo, 3), ("n", n, 3)], [eta])
    h, length = _native.half_vector(wi, wo, eta, n)
    return h.reshape(*shape, 3), length.reshape(shape)


def solid_angle_per_half_vector(wi: ArrayLike, wo: ArrayLike, eta: ArrayLike = 1.0) -> Float32:
    """\\|do / dh\\| = \\|H\\|^2 / (eta^2 \\|h.wo\\|) at fixed wi, 4 \\|h.wo\\| for reflection: shape (...). Zero where undefined."""
    (wi, wo), (eta,), shape = flatten([("wi", wi, 3), ("wo", wo, 3)], [eta])
    return _native.solid_angle_per_half_vector(wi, wo, eta).reshape(shape)


def reflect(wi: ArrayLike, m: ArrayLike) -> Float32:
    """wi mirrored at microfacets with the unit normals m: shape (..., 3)."""
    (wi, m), (eta,), shape = flatten([("wi", wi, 3), ("m", m, 3)], [1.0])
    return _native.scattered(wi, m, eta, False)[0].reshape(*shape, 3)


def refract(wi: ArrayLike, m: ArrayLike, eta: ArrayLike) -> tuple[Float32, NDArray[np.bool_]]:
    """wi refracted at microfacets with the unit normals m, shape (..., 3), and whether there is such a direction, shape
    (...): not at total internal reflection."""
    (wi, m), (eta,), shape = flatten([("wi", wi, 3), ("m", m, 3)], [eta])
    wo, valid = _native.scattered(wi, m, eta, True)
    return wo.reshape(*shape, 3), valid.reshape(shape)


def slope_of_projected(h: ArrayLike) -> Float32:
    """h_pp of h_perp, shape (..., 2); what is on the rim of the disk or outside is taken as just inside."""
    (h,), _, shape = flatten([("h", h, 2)])
    return _native.change_chart(h, True).reshape(*shape, 2)


def projected_of_slope(h: ArrayLike) -> Float32:
    """h_perp of h_pp, shape (..., 2)."""
    (h,), _, shape = flatten([("h", h, 2)])
    return _native.change_chart(h, False).reshape(*shape, 2)


def _function(name: str, x: ArrayLike, gamma: float = 0.0) -> Float32:
    _, (x,), shape = flatten([], [x])
    return _native.half_vector_function(name, x, gamma).reshape(shape)


def projected_per_half_vector(cosine: ArrayLike) -> Float32:
    """\\|dh_perp / dh\\| = cos for cosines h.n: shape (...)."""
    return _function("projected_per_half_vector", cosine)


def slope_per_half_vector(cosine: ArrayLike) -> Float32:
    """\\|dh_pp / dh\\| = 1 / cos^3 for cosines h.n: shape (...). Zero at the horizon, where it has its pole."""
    return _function("slope_per_half_vector", cosine)


def mean_step(alpha: ArrayLike, gamma: float = GAMMA) -> Float32:
    """Mean step of a half vector per axis, gamma alpha / sqrt(pi), in slope units for a Beckmann roughness: shape (...)."""
    return _function("mean_step", alpha, gamma)


def bsdf_deviation(alpha: ArrayLike, gamma: float = GAMMA) -> Float32:
    """Standard deviation of the Gaussian proposal with that mean step, gamma alpha / sqrt(2), at most 1.7: shape (...)."""
    return _function("bsdf_deviation", alpha, gamma)
