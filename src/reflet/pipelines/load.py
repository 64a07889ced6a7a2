"""Opens whatever a scene may come from."""

from collections.abc import Sequence
from pathlib import Path

from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT
from reflet.errors import RefletError
from reflet.files.environment import read_environment
from reflet.files.unreadable import check_is_file
from reflet.progress import ProgressCallback, silent
from reflet.scene.assemble import assemble
from reflet.scene.floor import with_floor
from reflet.scene.floor_kinds import Floor
from reflet.scene.material import EnvironmentLight
from reflet.scene.readers.gltf.read import GltfScene, read_gltf_scene
from reflet.scene.readers.obj.read import read_obj
from reflet.scene.scene import Scene
from reflet.scene.upright import upright, upright_lights

BUILT_IN = "teapot-room"


def load_scene(
    source: str | Path,
    *,
    environment: str | Path | None = None,
    reflect: Sequence[str] = (),
    source_is: Parameterization | None = None,
    layer: str | None = None,
    up: str | None = None,
    floor: Floor | None = None,
    progress: ProgressCallback = silent,
) -> Scene:
    """The scene in a .glb, .gltf, .obj or Mitsuba .xml file, or the built-in ``teapot-room``.

    ``environment`` is a file of an environment map, as `read_env_image` takes it, that lights the scene from infinity;
    ``source_is`` is its parameterization where it does not tell, ``layer`` that of an .exr. ``reflect`` names parts
    that reflect whatever their material (case does not count, ``*`` matches anything). ``up`` is the axis of the scene
    that points up, "y" or "z": +z becomes +y, and +y becomes -z, of a Mitsuba file's own environment too; by default y,
    or what a Mitsuba camera says. ``floor`` sets the scene on one that shows its environment, mirrors it too, or shows
    its shadow alone. ``progress`` hears of the three steps of reading: the environment, the file, and what is made of
    it. Raises RefletError for anything that cannot be read or baked.
    """
    progress("read", 0, 3)
    if floor is not None and str(source) == BUILT_IN:
        raise RefletError(f"The built-in {BUILT_IN} stands on a floor of its own; give its name without --floor.")
    scene = _load(source, environment, reflect, source_is, layer, up, progress)
    if floor is not None:
        from reflet.trace.light.floor_shadow import floor_shadow

        scene = with_floor(scene, floor, floor_shadow)
    progress("read", 3, 3)
    return scene


def _load(
    source: str | Path,
    environment: str | Path | None,
    reflect: Sequence[str],
    source_is: Parameterization | None,
    layer: str | None,
    up: str | None,
    progress: ProgressCallback,
) -> Scene:
    if str(source) == BUILT_IN:
        from reflet.scene.builtin.teapot_room import teapot_room

        if environment is not None or reflect or up is not None:
            raise RefletError(f"The built-in {BUILT_IN} brings its own light, mirrors and axes; give its name alone.")
        return teapot_room()
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix not in (".glb", ".gltf", ".obj", ".xml"):
        raise RefletError(f"A scene is a .glb, .gltf, .obj or .xml file, or the built-in {BUILT_IN}, not {source}.")
    check_is_file(path)
    if environment is None and (source_is is not None or layer is not None):
        raise RefletError("What the environment's file holds is told, but none came; add --environment FILE.")
    if up not in (None, *SOURCE_FROM_UPRIGHT):
        raise RefletError(f"What points up is one of {' '.join(SOURCE_FROM_UPRIGHT)}, not {up!r}.")
    light = None if environment is None else EnvironmentLight(read_environment(environment, source_is, layer))
    progress("read", 1, 3)
    if suffix == ".xml":
        from reflet.trace.mitsuba_files.mitsuba_xml import read_mitsuba_xml

        return read_mitsuba_xml(path, environment=light, reflect=reflect, up=up)
    read = GltfScene(read_obj(path), []) if suffix == ".obj" else read_gltf_scene(path)
    progress("read", 2, 3)
    parts, lights = upright(read.parts, up or "y"), upright_lights(read.lights, up or "y")
    return assemble(parts, environment=light, reflect=reflect, lights=lights)
