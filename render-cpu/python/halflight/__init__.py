"""Halflight: renders the light that other renderers lose, and lends its mathematics.

>>> import halflight
>>> scene = halflight.load("cornell-box.xml")
>>> image = scene.render(spp=64)
>>> image.radiance.shape
(512, 512, 3)

Radiance is in W/(m^2 sr), linear sRGB; lengths are in scene units, angles in radians; directions point away from the
surface. Arrays are ``float32``, as the kernel computes.

Modules: :mod:`halflight.half_vector` and :mod:`halflight.regularize` are the kernel's functions over arrays.
"""

from . import half_vector, regularize
from ._native import Comparison, Image, SceneError, __version__, compare, read
from .bsdf import Bsdf, BsdfSample, Event
from .scene import Parameters, Progress, Scene, Walks, WalkStatus, load

__all__ = [
    "Bsdf",
    "BsdfSample",
    "Comparison",
    "Event",
    "Image",
    "Parameters",
    "Progress",
    "Scene",
    "SceneError",
    "WalkStatus",
    "Walks",
    "__version__",
    "compare",
    "half_vector",
    "load",
    "read",
    "regularize",
]
