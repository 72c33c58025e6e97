"""Scenes: loading, parameters, rendering, walks on the specular manifold."""

from __future__ import annotations

import enum
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._broadcast import Float32, flatten


@dataclass(frozen=True)
class Progress:
    """How far a render is."""

    fraction: float
    """Share of the goal that is reached, 0 to 1."""
    samples: int
    """Samples per pixel so far."""
    seconds: float
    """Seconds spent."""
    noise: float
    """Standard deviation of the mean luminance over that luminance, averaged over the pixels (each at most 1)."""


class WalkStatus(enum.IntEnum):
    """How a walk ended."""

    CONVERGED = 0
    """The path was found."""
    SINGULAR = 1
    """The Jacobian had no inverse, or a constraint did not exist."""
    STALLED = 2
    """No step, however small, came nearer."""
    TOO_LONG = 3
    """The iterations were used up."""
    BLOCKED = 4
    """The path was found, but its last edge is blocked."""
    NO_START = 5
    """The first chain could not be traced: a ray met nothing, or a material that does not transmit."""


@dataclass(frozen=True)
class Walks:
    """Chains that were walked; the leading axes are those of the arguments."""

    status: NDArray[np.uint32]
    """One of :class:`WalkStatus` each: shape (...)."""
    iterations: NDArray[np.uint32]
    """Projections that were tried: shape (...)."""
    positions: Float32
    """Scattering vertices in world space, the last ones reached where a walk failed: shape (..., k, 3)."""
    half_vectors: Float32
    """Slopes of the half vectors there, h_pp: shape (..., k, 2)."""
    geometry_term: Float32
    """Generalised geometry term G(x_0 <-> x_{k+1}), 1 / area; zero where singular: shape (...)."""

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Where a path was found: shape (...)."""
        return np.equal(self.status, int(WalkStatus.CONVERGED))


class Parameters(Mapping[str, Any]):
    """The values of a scene by name, as ``glass.int_ior`` or ``sensor.fov``.

    Assigning to one changes it for the renders that begin afterwards; files are not read again. Booleans, integers,
    floats and strings are themselves; points, vectors and colours (linear sRGB) are tuples of three floats, where one
    number stands for a grey; transforms are arrays of the shape (4, 4) that multiply column vectors.

    Raises KeyError for a name that the scene does not have, TypeError for a value of another kind. What a plugin does
    not take is a :class:`halflight.SceneError` at the next use of the scene.
    """

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    def _values(self) -> dict[str, Any]:
        return dict(self._native.values())

    def __getitem__(self, name: str) -> Any:
        return self._values()[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self._native.change([(name, value)])

    def update(self, values: Mapping[str, Any]) -> None:
        """Changes several values, all or none."""
        self._native.change(list(values.items()))

    def __iter__(self) -> Iterator[str]:
        return iter(self._values())

    def __len__(self) -> int:
        return len(self._values())

    def __repr__(self) -> str:
        rows = (f"  {name} = {value!r}" for name, value in self._values().items())
        return "\n".join(["<halflight.Parameters", *rows, ">"])


class Scene:
    """A scene, from :func:`halflight.load`.

    Scenes may be used by several threads at once: a render keeps the parameters that it began with.
    """

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @property
    def path(self) -> os.PathLike[str]:
        """Path that the scene was read from."""
        return self._native.path

    @property
    def parameters(self) -> Parameters:
        """Values of the scene by name, to be listed and changed."""
        return Parameters(self._native)

    @property
    def warnings(self) -> list[str]:
        """What was read but could not be used as written, with file, line and element."""
        return self._native.warnings

    @property
    def plugins(self) -> dict[str, int]:
        """How often each plugin occurs, by kind and name."""
        return dict(self._native.plugins)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image in pixels, of the crop if there is one."""
        return self._native.size

    @property
    def spp(self) -> int:
        """Samples per pixel that the scene asks for."""
        return self._native.spp

    @property
    def seed(self) -> int:
        """Seed that the scene asks for."""
        return self._native.seed

    @property
    def integrator(self) -> str:
        """Name of the integrator that the scene asks for."""
        return self._native.integrator

    @property
    def sampler(self) -> str:
        """Name of the sampler, ``independent`` or ``sobol``."""
        return self._native.sampler

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return self._native.triangles

    def render(
        self,
        integrator: str | None = None,
        spp: int | None = None,
        time: float | None = None,
        seed: int | None = None,
        samples: tuple[int, int] | None = None,
        layers: Sequence[str] = (),
        progress: Callable[[Progress], object] | None = None,
    ) -> _native.Image:
        """Renders the scene on all threads, without the interpreter's lock.

        The image depends on the scene, the integrator, the seed and the samples alone, and is that of the command
        ``halflight render`` to the last bit. It carries the layers ``radiance``, ``variance`` (of each pixel's mean) and
        ``samples``, and those of ``layers``.

        integrator: an algorithm instead of the scene's.
        spp: samples per pixel; without it, ``time`` or ``samples``, what the scene asks for.
        time: seconds to render for.
        seed: seed of the random numbers; without it the scene's.
        samples: (first, end) of the samples of every pixel, so that several renders share one image.
        layers: albedo, normal, depth, position, uv.
        progress: called with a :class:`Progress` every two seconds or so. An exception that it raises ends the render
            and is passed on.

        Ctrl-C (KeyboardInterrupt, in the main thread) ends the render as soon as the samples under way are complete and
        returns what is there, with :attr:`Image.interrupted` set.

        Raises ValueError for arguments that contradict each other or name what is not known, SceneError where a changed
        parameter makes the scene unusable.
        """
        if sum(x is not None for x in (spp, time, samples)) > 1:
            raise ValueError("only one of spp, time and samples says how long to render")
        if spp is not None and spp < 1:
            raise ValueError(f"spp is {spp}; it must be at least 1")
        if samples is not None and not 0 <= samples[0] < samples[1]:
            raise ValueError(f"samples is {samples}; expected (first, end) with first < end")
        if time is not None and not time > 0.0:
            raise ValueError(f"time is {time}; it must be more than 0 seconds")
        report = None
        if progress is not None:

            def report(fraction: float, done: int, seconds: float, noise: float) -> None:
                progress(Progress(fraction, done, seconds, noise))

        return self._native.render(
            integrator, spp, time, seed, samples, [str(layer) for layer in layers], report
        )

    def walk(
        self,
        start: ArrayLike,
        via: ArrayLike,
        end: ArrayLike,
        events: str,
        half_vectors: ArrayLike = 0.0,
        max_iterations: int = 20,
    ) -> Walks:
        """Connects two points by chains of reflections and refractions: Newton's method in half-vector space.

        A chain is traced from ``start`` through the points ``via`` and then walks until its half vectors have the wanted
        slopes, zero for a specular path (manifold next event estimation), and both ends are still where they were.

        start, end: points in world space, shape (..., 3).
        via: for each of the k events a point to aim at, from the vertex before: shape (..., k, 3).
        events: k letters, ``R`` for reflection and ``T`` for transmission, from start to end.
        half_vectors: wanted slopes of the half vectors, shape (..., k, 2) or what broadcasts to it.
        max_iterations: the most projections.

        Raises ValueError for other letters, for chains of more than 8 events and for shapes that do not fit.
        """
        letters = events.upper()
        if not letters or set(letters) - {"R", "T"}:
            raise ValueError(f"events is {events!r}; expected letters R and T")
        k = len(letters)
        via = np.asarray(via, dtype=np.float32)
        if via.shape[-2:] != (k, 3):
            raise ValueError(f"via has the shape {via.shape}; its last axes must be ({k}, 3)")
        wanted = np.asarray(half_vectors, dtype=np.float32)
        wanted = np.broadcast_to(wanted, np.broadcast_shapes(wanted.shape, (k, 2)))
        flat, _, shape = flatten(
            [
                ("start", start, 3),
                ("via", via.reshape(*via.shape[:-2], 3 * k), 3 * k),
                ("end", end, 3),
                ("half_vectors", wanted.reshape(*wanted.shape[:-2], 2 * k), 2 * k),
            ]
        )
        status, iterations, positions, slopes, geometry_term = self._native.walk(
            flat[0],
            flat[1].reshape(-1, 3),
            flat[2],
            flat[3].reshape(-1, 2),
            [letter == "T" for letter in letters],
            max_iterations,
        )
        return Walks(
            status.reshape(shape),
            iterations.reshape(shape),
            positions.reshape(*shape, k, 3),
            slopes.reshape(*shape, k, 2),
            geometry_term.reshape(shape),
        )

    def __repr__(self) -> str:
        width, height = self.size
        return f"<halflight.Scene {os.fspath(self.path)!r}, {width} x {height}, {self.triangles} triangles>"


def load(
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] | None = None,
    width: int | None = None,
    crop: tuple[int, int, int, int] | None = None,
    sampler: str | None = None,
    sensor: int = 0,
    strict: bool = False,
    keep_files: bool = True,
    defines: Mapping[str, object] | None = None,
    **parameters: object,
) -> Scene:
    """Reads a Mitsuba scene file (XML of version 0.6, 2 or 3).

    Further keywords are values of the ``$name`` of the scene file, and so are those of ``defines``, where names of
    arguments can stand too.

    size: width and height of the image in pixels, instead of the scene's.
    width: width in pixels; the height follows in proportion.
    crop: part of the image to render: column, row, width, height.
    sampler: random numbers instead of the scene's, ``independent`` or ``sobol``.
    sensor: which of several sensors, from 0.
    strict: whether what would be a warning is an error.
    keep_files: whether contents of meshes and textures stay in memory, so that changed parameters need no file.

    Raises SceneError with file, line and element for what is wrong with the scene, ValueError for the arguments.
    """
    if size is not None and width is not None:
        raise ValueError("either size or width, not both")
    values = [(name, _text(value)) for name, value in {**(defines or {}), **parameters}.items()]
    return Scene(
        _native.load(
            path,
            values,
            size,
            width,
            crop,
            sampler,
            sensor,
            strict,
            keep_files,
        )
    )


def _text(value: object) -> str:
    """A value as scene files spell it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, int, float, os.PathLike)):
        return str(value)
    return " ".join(str(x) for x in np.asarray(value).ravel())
