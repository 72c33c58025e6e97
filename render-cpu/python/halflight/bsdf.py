"""Scattering models over arrays of directions."""

from __future__ import annotations

import enum
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._broadcast import Float32, flatten


class Event(enum.IntFlag):
    """What kind of interaction a sample is."""

    REFLECTION = 1
    """wo on the side of wi."""
    TRANSMISSION = 2
    """wo on the other side."""
    DELTA = 4
    """A single direction: ``pdf`` is a discrete probability, ``eval`` is zero there."""
    GLOSSY = 8
    """Rough but peaked."""
    DIFFUSE = 16
    """Broad."""
    NULL = 32
    """Straight through, as if nothing were there."""


@dataclass(frozen=True)
class BsdfSample:
    """Sampled directions; the leading axes are those of the arguments."""

    wo: Float32
    """Directions, undefined where ``pdf`` is zero: shape (..., 3)."""
    weight: Float32
    """f |cos| / pdf, linear sRGB: shape (..., 3)."""
    pdf: Float32
    """Density per solid angle, a discrete probability for ``Event.DELTA``, zero for no sample: shape (...)."""
    eta: Float32
    """Index on the side of wo over the index on the side of wi, 1 for reflection: shape (...)."""
    event: NDArray[np.uint32]
    """Bits of :class:`Event`: shape (...)."""


def _element(kind: str, name: str | None, value: Mapping[str, Any]) -> str:
    """An object of a scene file: {"type": plugin, property: value, ...}."""
    value = dict(value)
    plugin = value.pop("type", None)
    if not isinstance(plugin, str):
        raise ValueError(f'{name or kind}: a dict needs the name of a plugin under "type"')
    kind = value.pop("kind", kind)
    attributes = f" type={quoteattr(plugin)}" + (f" name={quoteattr(name)}" if name else "")
    inner = "".join(_property(key, item) for key, item in value.items())
    return f"<{kind}{attributes}>{inner}</{kind}>"


def _property(name: str, value: Any) -> str:
    """A property of a scene file."""
    if isinstance(value, Mapping):
        # What a plugin is, its parameter says: BSDFs within BSDFs have no name that matters, textures do.
        nested = "bsdf" if name.startswith("bsdf") else "texture"
        return _element(nested, None if nested == "bsdf" else name, value)
    if isinstance(value, (bool, np.bool_)):
        tag, text = "boolean", str(bool(value)).lower()
    elif isinstance(value, (int, np.integer)):
        tag, text = "integer", str(int(value))
    elif isinstance(value, (float, np.floating)):
        tag, text = "float", repr(float(value))
    elif isinstance(value, (str, os.PathLike)):
        tag, text = "string", os.fspath(value)
    else:
        numbers = np.asarray(value, dtype=np.float64)
        if numbers.shape != (3,):
            raise ValueError(f"{name}: expected a number, a text, a dict or three numbers, found {value!r}")
        tag, text = "rgb", ", ".join(repr(float(x)) for x in numbers)
    return f"<{tag} name={quoteattr(name)} value={quoteattr(text)}/>"


class Bsdf:
    """A material at one point, evaluated, sampled and its density over arrays of directions.

    >>> gold = Bsdf("roughconductor", material="Au", alpha=0.1)
    >>> gold.eval([0, 0, 1], [0, 0.6, 0.8]).shape
    (3,)

    Plugins and parameters are those of scene files: numbers, texts, booleans, colours as three numbers (linear sRGB),
    textures as dicts, and BSDFs within others as dicts under names that begin with ``bsdf``:

    >>> coated = Bsdf("coating", int_ior=1.5, bsdf={"type": "diffuse", "reflectance": [0.8, 0.2, 0.2]})

    Directions are in the local frame (z is the shading normal, x and y run along the texture), of unit length, and point
    away from the surface. wi is the known direction, towards the sensor on camera paths. Shapes broadcast.

    uv: where textures are looked up.
    importance: whether transmission is left unscaled, as for importance; radiance is scaled by 1 / eta^2.

    Raises SceneError or ValueError for parameters that the plugin does not take.
    """

    def __init__(
        self,
        plugin: str,
        /,
        *,
        uv: tuple[float, float] = (0.5, 0.5),
        importance: bool = False,
        **parameters: Any,
    ) -> None:
        xml = _element("bsdf", None, {"type": plugin, **parameters})
        file = os.path.join(os.getcwd(), "bsdf.xml")
        self._native = _native.Bsdf.from_xml(xml, plugin, file, uv, importance)

    @classmethod
    def find(
        cls,
        name: str | os.PathLike[str],
        id: str | None = None,
        *,
        uv: tuple[float, float] = (0.5, 0.5),
        importance: bool = False,
    ) -> Bsdf:
        """A BSDF that is there: of a scene file (``id`` chooses among several), a measurement in MERL's format
        (``.binary``), an example of ``halflight material --list``, or a metal such as ``Au``.

        Raises ValueError when there is none, OSError when a file cannot be read.
        """
        bsdf = cls.__new__(cls)
        bsdf._native = _native.Bsdf.find(os.fspath(name), id, uv, importance)
        return bsdf

    def eval(self, wi: ArrayLike, wo: ArrayLike) -> Float32:
        """The BSDF f, without a cosine, in 1/sr and linear sRGB: shape (..., 3). Zero for discrete directions."""
        value, _ = self.eval_cosine_pdf(wi, wo)
        cosine = np.abs(np.asarray(wo, dtype=np.float32)[..., 2:])
        return np.divide(value, cosine, out=np.zeros_like(value), where=cosine > 0)

    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> Float32:
        """Density per solid angle with which :meth:`sample` chooses wo: shape (...). Zero for discrete directions."""
        return self.eval_cosine_pdf(wi, wo)[1]

    def eval_cosine_pdf(self, wi: ArrayLike, wo: ArrayLike) -> tuple[Float32, Float32]:
        """f |cos wo|, shape (..., 3), and the density, shape (...), at once."""
        (wi, wo), _, shape = flatten([("wi", wi, 3), ("wo", wo, 3)])
        value, pdf = self._native.eval_cosine_pdf(wi, wo)
        return value.reshape(*shape, 3), pdf.reshape(shape)

    def sample(self, wi: ArrayLike, u: ArrayLike) -> BsdfSample:
        """Directions wo for random numbers u in [0, 1), shape (..., 3): the first chooses the lobe."""
        (wi, u), _, shape = flatten([("wi", wi, 3), ("u", u, 3)])
        wo, weight, pdf, eta, event = self._native.sample(wi, u)
        return BsdfSample(
            wo.reshape(*shape, 3),
            weight.reshape(*shape, 3),
            pdf.reshape(shape),
            eta.reshape(shape),
            event.reshape(shape),
        )

    def regularized(self, wi: ArrayLike, wo: ArrayLike, tau: ArrayLike) -> tuple[Float32, Float32]:
        """f_hat |cos wo|, shape (..., 3), and its density for multiple importance sampling, shape (...), of the BSDF
        regularised to at most ``tau`` per steradian (Jendersie and Grosch 2019)."""
        (wi, wo), (tau,), shape = flatten([("wi", wi, 3), ("wo", wo, 3)], [tau])
        value, pdf = self._native.regularized_eval_cosine_pdf(wi, wo, tau)
        return value.reshape(*shape, 3), pdf.reshape(shape)

    def bound(self, wi: ArrayLike = (0.0, 0.0, 1.0), transmission: bool = False) -> Float32:
        """Upper bound of the BSDF per steradian for reflection or transmission, looked up for wi: shape (...).
        ``regularize.TAU_MAX`` where there is none."""
        (wi,), _, shape = flatten([("wi", wi, 3)])
        return self._native.bound(wi, transmission).reshape(shape)

    def local_roughness(self, wi: ArrayLike, wo: ArrayLike) -> Float32:
        """Local roughness at pairs of directions, as a Beckmann alpha (Holzschuch et al. 2016): shape (...). 1000 where
        nothing falls off, 0 for a material of discrete directions."""
        (wi, wo), _, shape = flatten([("wi", wi, 3), ("wo", wo, 3)])
        return self._native.local_roughness(wi, wo).reshape(shape)

    def __repr__(self) -> str:
        return f"<halflight.Bsdf {self._native.name}>"
