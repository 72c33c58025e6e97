"""Arguments of any broadcastable shapes to the flat, contiguous arrays that the compiled half takes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float32 = NDArray[np.float32]


def flatten(
    vectors: Sequence[tuple[str, ArrayLike, int]], numbers: Sequence[ArrayLike] = ()
) -> tuple[list[Float32], list[Float32], tuple[int, ...]]:
    """Vectors as (n, size) arrays, numbers as (n,) arrays, and the shape that all of them broadcast to.

    Each vector comes with its name and the size that its last axis must have. Raises ValueError otherwise, or where
    shapes do not broadcast.
    """
    arrays = []
    for name, value, size in vectors:
        array = np.asarray(value, dtype=np.float32)
        if array.ndim == 0 or array.shape[-1] != size:
            raise ValueError(f"{name} has the shape {array.shape}; its last axis must be {size}")
        arrays.append(array)
    scalars = [np.asarray(value, dtype=np.float32) for value in numbers]
    shape = np.broadcast_shapes(*(a.shape[:-1] for a in arrays), *(s.shape for s in scalars))
    count = math.prod(shape)
    flat_arrays = [
        np.ascontiguousarray(np.broadcast_to(a, (*shape, a.shape[-1]))).reshape(count, a.shape[-1])
        for a in arrays
    ]
    flat_scalars = [np.ascontiguousarray(np.broadcast_to(s, shape)).reshape(count) for s in scalars]
    return flat_arrays, flat_scalars, shape
