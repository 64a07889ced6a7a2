"""Non-photorealistic maps, and pictures of meshes that show a map as it is, by how they are turned to the viewer."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.errors import RefletError
from reflet.files.env_image_file import read_levels, write_env_image
from reflet.npr.drawing import Drawing, drawn_levels
from reflet.npr.drawings import SIZE, drawing, is_drawing
from reflet.reflectance.materials.map_material import Lookup, MapMaterial
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera

LEVEL = "{level}"
_LARGEST = 1024  # rows: drawn in half a minute at most
_TEXTURES = (".ktx2", ".ktx", ".dds")


def sketch_levels(
    drawn: str | Drawing, parameterization: Parameterization | None = None, size: int = SIZE, seed: int = 1
) -> tuple[EnvImage, ...]:
    """A drawing (`drawing`) as a map by the viewer's normal, all mip levels drawn, finest first.

    Of the parameterizations the dual paraboloid, which is the default, holds drawings best: seen from the viewer it is
    the same all around, and its texels are square.
    """
    chosen = drawing(drawn, seed) if isinstance(drawn, str) else drawn
    return drawn_levels(chosen, parameterization or DualParaboloid(), size)


def write_sketch(path: str | Path, levels: Sequence[EnvImage]) -> tuple[Path, ...]:
    """Writes a drawn map; the files it wrote.

    .ktx2, .ktx and .dds hold all levels. Of other formats one file holds the finest level; a ``path`` with ``{level}``
    in its name is one file for every level.
    """
    path = Path(path)
    if LEVEL in path.name:
        files = tuple(path.with_name(path.name.replace(LEVEL, str(k))) for k in range(len(levels)))
        for file, level in zip(files, levels, strict=True):
            write_env_image(file, [level])
        return files
    write_env_image(path, levels if path.suffix.lower() in _TEXTURES else levels[:1])
    return (path,)


def shows_map(material: str) -> bool:
    """Whether a material's name asks for a drawing or, by ``map:LOOKUP``, for a map file shown as it is."""
    return is_drawing(material) or material.partition(":")[0] == "map"


def drawing_size(image_size: int) -> int:
    """Rows that a drawing needs for pictures of so many pixels: strokes deep within large shapes ask for most."""
    return min(max(SIZE, 1 << max((image_size - 1).bit_length() - 1, 0)), _LARGEST)


def map_material(
    material: str,
    source: str | Path | None = None,
    source_is: Parameterization | None = None,
    size: int = SIZE,
) -> tuple[tuple[EnvImage, ...], Lookup]:
    """The map of a material that `shows_map`, with its mip levels, and how it is looked up.

    Drawings have ``size`` rows. ``source_is`` is the parameterization of the file ``source`` where that does not tell.
    Levels that it lacks are filtered. Raises RefletError where a drawing has a file, or a map none.
    """
    if is_drawing(material):
        if source is not None:
            raise RefletError(
                f"The drawing {material} needs no environment, and {source} came; leave it out, or show that map by "
                "map:view-normal."
            )
        return sketch_levels(material, size=size), Lookup.VIEW_NORMAL
    lookup = lookup_named(material.partition(":")[2])
    if source is None:
        raise RefletError(f"The material {material} shows a map, and none came; give its file after the mesh.")
    levels = read_levels(source, source_is)
    size = levels[0].size
    return (levels if len(levels) > 1 or size & (size - 1) else mip_images(levels[0])), lookup


def lookup_named(text: str) -> Lookup:
    """``reflection``, ``normal``, ``view-reflection`` or ``view-normal``. Raises RefletError for anything else."""
    names = {each.name.lower().replace("_", "-"): each for each in Lookup}
    if text not in names:
        raise RefletError(f"A map is looked up by {', '.join(names)}, such as map:view-normal, not {text!r}.")
    return names[text]


def sketch(
    mesh: Mesh,
    levels: Sequence[EnvImage],
    camera: Camera,
    lookup: Lookup = Lookup.VIEW_NORMAL,
    samples: int = 16,
    map_from_world: Float[np.ndarray, "3 3"] | None = None,
) -> Float32[np.ndarray, "height width 4"]:
    """The mesh as the map colours it, linear, before nothing; coverage in alpha. Backs of single-sided faces are black.

    `on_paper` puts paper behind it. ``samples`` are 1, 4 or 16 a pixel. Lookups by directions of the world go by
    ``map_from_world``, a rotation.
    """
    from reflet.render.maps.env_map_texture import upload_env_map
    from reflet.render.materials.env_map_renderer import EnvMapRenderer

    renderer = EnvMapRenderer(mesh)
    return renderer.picture(
        upload_env_map(renderer.device, levels),
        camera,
        frame=map_from_world,
        samples=samples,
        backdrop=False,
        material=renderer.programs.material(MapMaterial(lookup)),
    )


def on_paper(
    picture: Float32[np.ndarray, "height width 4"], paper: tuple[float, float, float] = (1.0, 1.0, 1.0)
) -> Float32[np.ndarray, "height width 3"]:
    """The picture before a sheet of this colour."""
    return (picture[..., :3] + (1.0 - picture[..., 3:]) * np.asarray(paper)).astype(np.float32)
