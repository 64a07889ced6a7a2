"""The file of a PEM's environment, coded or as it is, and what scene.gltf says of it."""

from pathlib import Path
from typing import Any

from reflet.pem import layout
from reflet.pem.arrays import BufferWriter, read_array
from reflet.pem.coding.coded_map import environment_fits, read_coded_environment, write_coded_environment
from reflet.scene.material import EnvironmentLight


def write_environment(folder: Path, environment: EnvironmentLight, codec: layout.Codec) -> dict[str, Any]:
    """Write it, as float32 where it is too large for a codec; the description that `read_environment` takes."""
    rows, columns, _ = environment.radiance.shape
    if codec == "av1" and environment_fits(rows, columns):
        write_coded_environment(folder / layout.CODED_ENVIRONMENT, environment.radiance)
        return {"uri": layout.CODED_ENVIRONMENT, "shape": [rows, columns, 3]}
    buffer = BufferWriter(layout.ENVIRONMENT_BUFFER)
    description = buffer.add(environment.radiance)
    buffer.write(folder)
    return description


def read_environment(folder: Path, description: dict[str, Any]) -> EnvironmentLight:
    """Read what `write_environment` wrote. Raises RefletError where its file is missing or damaged."""
    if "componentType" in description:
        return EnvironmentLight(read_array(folder, description))
    rows, columns, _ = description["shape"]
    return EnvironmentLight(read_coded_environment(folder / description["uri"], rows, columns))
