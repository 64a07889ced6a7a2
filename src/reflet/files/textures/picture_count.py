"""How many pictures a KTX file holds, and what they are: its header read as it is meant, not by the letter."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from reflet.errors import RefletError


@dataclass(frozen=True)
class PictureCount:
    """``stored`` pictures a level lie in the file, the first ``used`` of which are read: a cube's faces or layers."""

    stored: int
    used: int
    is_cube: bool
    doubts: tuple[str, ...] = ()


def picture_count(path: Path, width: int, height: int, depth: int, layers: int, faces: int) -> PictureCount:
    """From the numbers of a header, where 0 means as little as 1. Raises RefletError for what is no 2D texture."""
    if depth > 1 or not width or not height or faces not in (0, 1, 6) or (faces == 6 and width != height):
        raise RefletError(
            f"{path} holds {width}×{height}×{depth} texels, {layers} layers and {faces} faces; expected one cube, a 2D "
            "texture or an array of them."
        )
    layers, faces = max(layers, 1), max(faces, 1)
    if faces == 6 and layers > 1:
        return PictureCount(6 * layers, 6, True, (f"{path} holds {layers} cubes; the first is read.",))
    return PictureCount(layers * faces, layers * faces, faces == 6)


def damaged_metadata(path: Path, read: Mapping[str, bytes]) -> str:
    """The sentence for key-value pairs of which only ``read`` make sense."""
    kept = f"all but {', '.join(read)}" if read else "all of it"
    return f"{path} has damaged metadata; {kept} is left out."
