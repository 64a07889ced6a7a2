"""Opens whatever a scene may come from."""

from collections.abc import Sequence
from pathlib import Path

from reflet.errors import RefletError
from reflet.files.environment import read_environment
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.readers.gltf import read_gltf
from reflet.scene.readers.obj import read_obj
from reflet.scene.scene import Scene

BUILT_IN = "teapot-room"


def load_scene(source: str | Path, *, environment: str | Path | None = None, reflect: Sequence[str] = ()) -> Scene:
    """The scene in a .glb, .gltf, .obj or Mitsuba .xml file, or the built-in ``teapot-room``.

    ``environment`` is a lat-long .hdr or .exr picture that lights the scene from infinity; ``reflect`` names parts that
    reflect whatever their material (case does not count, ``*`` matches anything). Raises RefletError for anything that
    cannot be read or baked.
    """
    if str(source) == BUILT_IN:
        from reflet.scene.builtin.teapot_room import teapot_room

        if environment is not None or reflect:
            raise RefletError(f"The built-in {BUILT_IN} brings its own light and mirrors; give its name alone.")
        return teapot_room()
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix not in (".glb", ".gltf", ".obj", ".xml"):
        raise RefletError(f"A scene is a .glb, .gltf, .obj or .xml file, or the built-in {BUILT_IN}, not {source}.")
    if not path.is_file():
        raise RefletError(f"There is no file {path}; check the name.")
    light = EnvironmentLight(read_environment(environment)) if environment is not None else None
    if suffix == ".xml":
        from reflet.trace.mitsuba_files.mitsuba_xml import read_mitsuba_xml

        return read_mitsuba_xml(path, environment=light, reflect=reflect)
    parts = read_obj(path) if suffix == ".obj" else read_gltf(path)
    return assemble(parts, environment=light, reflect=reflect)
