"""Reading glTF 2.0 (.gltf, .glb) into parts in world space."""

import struct
import warnings
from dataclasses import dataclass
from pathlib import Path

from reflet.errors import RefletError, RefletWarning
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.readers.gltf.accessors import Accessors
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.container import read_container
from reflet.scene.readers.gltf.document import open_document
from reflet.scene.readers.gltf.extensions import check_required, note_extensions, note_what_stands_still
from reflet.scene.readers.gltf.images import Textures
from reflet.scene.readers.gltf.lights import read_lights
from reflet.scene.readers.gltf.materials.materials import Materials
from reflet.scene.readers.gltf.nodes import Nodes
from reflet.scene.readers.gltf.primitives import Primitives
from reflet.scene.readers.gltf.rig import Rig
from reflet.scene.readers.gltf.values import DamagedError
from reflet.scene.scene import Part


@dataclass(frozen=True)
class GltfScene:
    """What of a file is read: its meshes, in world space, and its lights."""

    parts: list[Part]
    lights: list[PunctualLight]


def read_gltf(path: str | Path) -> list[Part]:
    """The parts alone of `read_gltf_scene`; a RefletWarning says that lights are left out, where there are any."""
    scene = read_gltf_scene(path)
    if scene.lights:
        names = ", ".join(light.name for light in scene.lights[:8]) + (", …" if len(scene.lights) > 8 else "")
        what = f"{Path(path).name}: its {len(scene.lights)} lights are left out ({names})."
        warnings.warn(what, RefletWarning, stacklevel=2)
    return scene.parts


def read_gltf_scene(path: str | Path) -> GltfScene:
    """The triangle meshes of a file's default scene, one part per node, instance and primitive, none marked reflective,
    and its point, spot and directional lights.

    Names are those of node or mesh, with the material's behind where a mesh has several primitives; they need not be
    unique. Primitives without a material become mirrors of F0 = 0.65. Skins and morph targets are shown in the pose
    that the file's nodes have. Meshes compressed by Draco or meshoptimizer and Basis Universal textures are decoded.
    What is not honoured is said in one RefletWarning for each kind; what a file requires and is not supported, and
    files that are damaged, raise RefletError.
    """
    path = Path(path)
    try:
        container = read_container(path)
        check_required(container.root, path)
        document = open_document(path, container)
        buffers = Buffers(document)
        accessors = Accessors(document, buffers)
        nodes = Nodes(document, accessors)
        materials = Materials(document, Textures(document, buffers))
        rig = Rig(document, accessors, buffers, nodes)
        primitives = Primitives(document, accessors, buffers, rig, materials)
        parts = [part for node in nodes.placed() for part in primitives.parts(node)]
        lights = read_lights(document, nodes)
        note_extensions(document)
        note_what_stands_still(document)
    except DamagedError as error:
        raise RefletError(f"{path} is damaged: {error}; export or download it again.") from error
    except (ArithmeticError, LookupError, TypeError, AttributeError, ValueError, struct.error, RecursionError) as error:
        raise RefletError(f"{path} is no valid glTF 2.0 file ({error}); export or download it again.") from error
    except MemoryError as error:
        raise RefletError(
            f"{path} asks for more memory than there is; it is damaged, or its meshes too large."
        ) from error
    document.notes.say(2)
    return GltfScene(parts, lights)
