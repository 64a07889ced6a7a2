"""Whether the faces of a cube go on into each other, as those of one picture of all directions do."""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE

_DARK = 1e-4  # added to radiance of mean 1 before its logarithm is taken
_TELLING = 0.1  # edges along which the logarithm varies less (its standard deviation) say nothing
_JUMP = 0.75  # of that deviation: a larger difference across the edge is no continuation
_ROUGH = 3.0  # and larger than so many times the difference to the next texel on the same face
_SMALLEST = 32  # rows of a face: between texels of smaller ones light changes too much
_MOST_SAMPLES = 256  # along an edge


def broken_edges(image: EnvImage) -> tuple[int, int]:
    """Of a cube's twelve edges, how many break and how many tell at all.

    An edge tells if light varies along it on both sides; it breaks if the two sides differ from each other about as
    much as unrelated pictures would. Maps of fewer than 32 rows a face tell nothing.
    """
    size = image.size
    if size < _SMALLEST:
        return 0, 0
    along = np.unique(np.linspace(0, size - 1, min(size, _MOST_SAMPLES)).astype(np.int64))
    sides = []  # light beside an edge on its face, one texel farther in, and across the edge
    for number in range(6):
        face = np.full(len(along), number)
        for row, column in ((-1, along), (size, along), (along, -1), (along, size)):
            row, column = (np.broadcast_to(np.asarray(at), along.shape) for at in (row, column))
            near = image.texels[face, np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)]
            inner = image.texels[face, np.clip(row, 1, size - 2), np.clip(column, 1, size - 2)]
            far = image.texels[CUBE.across_seams(face, row, column, size)]
            sides.append([colors[:, :3].mean(-1) for colors in (near, inner, far)])
    light = np.maximum(np.array(sides, np.float64), 0.0)
    light = np.log(light / max(light.mean(), 1e-30) + _DARK)
    broken = telling = 0
    for near, inner, far in light:
        varies = min(near.std(), far.std())
        if varies > _TELLING:
            telling += 1
            broken += int(_difference(near, far) > max(_JUMP * varies, _ROUGH * _difference(near, inner)))
    return broken // 2, telling // 2  # every edge was met from both sides


def _difference(a: Float[np.ndarray, "n"], b: Float[np.ndarray, "n"]) -> float:
    """Median, for small lamps may sit at an edge."""
    return float(np.median(np.abs(a - b)))
