"""The one entrance to files of env images: which form a file has, and which parameterization it holds.

A file's own word comes first (KTX metadata, a string attribute of .exr, text of .png, a variable of .hdr's header), and
then its shape: twice as wide as high is lat-long, strips and crosses are cubes. A square may be any of the round and
the octahedral maps: who reads it has to say which.

Radiance must be finite. Negative values, which resampling filters and renderers leave behind, are kept and warned of;
for those who take the map for light they are 0 (`read_light`).
"""

import math
import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.envmap.cube_seams import broken_edges
from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import share_of_light
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.repair import flaws_of, repaired
from reflet.envmap.resampling.padding import with_corners
from reflet.envmap.resampling.spread_light import warn_of_cut
from reflet.errors import RefletError, RefletWarning
from reflet.files.file_facts import FileFacts
from reflet.files.pictures.cube_layouts import as_seen_inside, layout_of
from reflet.files.pictures.map_in_picture import image_in_picture, kind_of_picture
from reflet.files.pictures.map_to_picture import as_stored, write_map_picture
from reflet.files.pictures.picture_file import (
    READ,
    WRITTEN,
    PictureFile,
    clipped_sentence,
    picture_outline,
    read_picture_file,
    unread_sentence,
)
from reflet.files.pictures.six_files import SixFiles, names_a_face, siblings_of, six_files
from reflet.files.textures import dds, ktx1, ktx2_container
from reflet.files.textures.env_texture import (
    as_radiance,
    as_text,
    cube_layout,
    holdable,
    kind_of_texture,
    levels_in_texture,
    texture_from_levels,
)
from reflet.files.textures.texture import Texture
from reflet.files.unreadable import unreadable

_Path = str | os.PathLike[str]

_READERS: dict[bytes, tuple[str, Callable[[_Path], Texture]]] = {
    ktx2_container.IDENTIFIER: ("KTX 2.0", ktx2_container.read_texture),
    ktx1.IDENTIFIER: ("KTX 1", ktx1.read_ktx1_texture),
    dds.MAGIC: ("DDS", dds.read_dds_texture),
}
_WRITERS: dict[str, Callable[[_Path, Texture], None]] = {
    ".ktx2": ktx2_container.write_texture,
    ".ktx": ktx1.write_ktx1_texture,
    ".dds": dds.write_dds_texture,
}
_BROKEN = 3  # edges of a cube by which its faces are not in order; at a mask's border one or two may break


def read_env_image(
    path: _Path, parameterization: Parameterization | None = None, *, layer: str | None = None, repair: bool = False
) -> EnvImage:
    """The finest level of `read_levels`; the others are not decoded."""
    return _read(Path(path), parameterization, layer, repair, most_levels=1)[0]


def read_light(path: _Path, parameterization: Parameterization | None = None, *, layer: str | None = None) -> EnvImage:
    """`read_env_image` for those who take the map for light: negative radiance is 0, and warned of."""
    return _read(Path(path), parameterization, layer, False, most_levels=1, as_light=True)[0]


def read_levels(
    path: _Path, parameterization: Parameterization | None = None, *, layer: str | None = None, repair: bool = False
) -> tuple[EnvImage, ...]:
    """All mip levels of a file, finest first, as linear radiance in float32; pictures have one.

    ``path`` may also name six files of a cube: a folder that holds them, or a name with ``{face}`` in it, such as
    sky_{face}.hdr. ``parameterization`` says what the file holds where it does not tell, and outweighs what it says.
    ``layer`` names a layer of an .exr. With ``repair`` radiance that is not finite or negative is put right
    (`repaired`). Round maps whose corners are blank are continued there (`with_corners`).

    Warns (RefletWarning) of what is read with a doubt, and of negative radiance, which is kept. Raises RefletError
    where files are missing, damaged or of other kinds, where their radiance is not finite, where their shape does not
    suit the parameterization, and where the parameterization is not known.
    """
    return _read(Path(path), parameterization, layer, repair)


def _read(
    path: Path,
    parameterization: Parameterization | None,
    layer: str | None,
    repair: bool,
    most_levels: int | None = None,
    as_light: bool = False,
) -> tuple[EnvImage, ...]:
    files = _six_files_at(path, parameterization)
    doubts: list[str] = []
    if files is not None:
        cube, most = _cube_from_files(files, parameterization, layer, doubts)
        levels: tuple[EnvImage, ...] = (cube,)
    elif (reader := _texture_reader(path)) is not None:
        if layer is not None:
            raise RefletError(f"{path} has no layers, for only .exr files have; leave {layer} out.")
        texture = reader[1](path)
        most = texture.texel_format.most
        doubts += texture.doubts
        texture = replace(texture, levels=texture.levels[:most_levels])
        levels, said = levels_in_texture(path, texture, parameterization)
        doubts += said
    else:
        picture = _radiance_of(path, layer, doubts)
        most = picture.most
        image, said = image_in_picture(path, picture, parameterization)
        levels = (image,)
        doubts += said
    if _has_unused_alpha(levels[0].texels):
        doubts.append(f"{path} has an alpha of 0 everywhere, which is left out; its colours are kept.")
        levels = tuple(replace(level, texels=np.ascontiguousarray(level.texels[..., :3])) for level in levels)
    if levels[0].parameterization == CUBE:
        doubts += _doubts_of_edges(path, levels[0])
    clipped = share_of_light(levels[0], at_least=most) if math.isfinite(most) else 0.0
    if clipped > 0.0:
        doubts.append(clipped_sentence(path, most, clipped))
    out = []
    for number, level in enumerate(levels):
        sound, said = _sound(path, level, repair, as_light)
        doubts += said if number == 0 else []
        out.append(replace(sound, texels=with_corners(sound.parameterization, sound.texels)))
    for doubt in doubts:
        warnings.warn(doubt, RefletWarning, stacklevel=3)
    return tuple(out)


def _doubts_of_edges(path: Path, cube: EnvImage) -> list[str]:
    broken, telling = broken_edges(cube)
    if broken < _BROKEN or 3 * broken < telling:
        return []
    return [
        f"{path} is a cube whose faces do not go on into each other at {broken} of {telling} edges that tell; they may "
        "be named, ordered or turned otherwise than here."
    ]


def _has_unused_alpha(texels: np.ndarray) -> bool:
    """Whether nothing is to be seen by an alpha that is 0 everywhere, though there are colours."""
    return texels.shape[-1] == 4 and not texels[..., 3].any() and bool(texels[..., :3].any())


def _radiance_of(path: Path, layer: str | None, doubts: list[str]) -> PictureFile:
    """The picture with 3 or 4 channels; its doubts are added to those given."""
    picture = read_picture_file(path, layer)
    doubts += picture.doubts
    return replace(picture, pixels=as_radiance([picture.pixels])[0])


def file_facts(path: _Path, layer: str | None = None) -> FileFacts:
    """What a file, of an .exr the ``layer``, says of itself. Raises RefletError where it cannot be read."""
    path = Path(path)
    files = _six_files_at(path, None)
    if files is not None:
        first = files.paths[0]
        face = picture_outline(first, layer)
        height, width, channels = face.pixels.shape
        form = READ[first.suffix.lower()]
        return FileFacts(form, CUBE, "faces", height, width, 6, 1, channels, _stored_as(first), None, face.notes)
    reader = _texture_reader(path)
    if reader is not None:
        texture = reader[1](path)
        laid_out = kind_of_texture(texture)
        layout = (
            "cube" if texture.is_cube else "layers" if texture.image_count > 1 else cube_layout(texture) or "single"
        )
        return FileFacts(
            reader[0],
            laid_out,
            layout if laid_out else None,
            texture.rows,
            texture.columns,
            texture.image_count,
            len(texture.levels),
            texture.texel_format.channels,
            texture.texel_format.name,
            texture.supercompression,
            {key: as_text(value) for key, value in texture.metadata.items()},
        )
    picture = picture_outline(path, layer)
    height, width, channels = picture.pixels.shape
    laid_out = kind_of_picture(picture)
    lies = "openexr" if picture.openexr_layout else layout_of(laid_out, height, width) if laid_out else None
    form = READ[path.suffix.lower()]
    return FileFacts(form, laid_out, lies, height, width, 1, 1, channels, _stored_as(path), None, picture.notes)


def _six_files_at(path: Path, parameterization: Parameterization | None) -> SixFiles | None:
    """The six files that ``path`` means: a folder, a name with a place for the face's, or a face itself.

    A file is a face if its name says so, its picture is a square that does not tell what it is, and others like it
    stand beside it.
    """
    files = six_files(path, READ)
    if files is not None or parameterization not in (None, CUBE) or path.suffix.lower() not in READ:
        return files
    if not (path.is_file() and names_a_face(path)):
        return None
    picture = picture_outline(path)
    height, width, _ = picture.pixels.shape
    return siblings_of(path, READ) if height == width and kind_of_picture(picture) is None else None


def _stored_as(path: Path) -> str:
    return {".hdr": "rgbe", ".exr": "half or float"}.get(path.suffix.lower(), "srgb")


def _cube_from_files(
    files: SixFiles, parameterization: Parameterization | None, layer: str | None, doubts: list[str]
) -> tuple[EnvImage, float]:
    """The cube and the most radiance that its files can hold."""
    if parameterization not in (None, CUBE):
        raise RefletError(f"Six files are a cube, not {parameterization}; give one file.")
    doubts += files.doubts
    pictures = [_radiance_of(file, layer, doubts) for file in files.paths]
    faces = [picture.pixels for picture in pictures]
    for file, face in zip(files.paths, faces, strict=True):
        if face.shape != (faces[0].shape[0], faces[0].shape[0], faces[0].shape[2]):
            height, width, _ = face.shape
            raise RefletError(f"{file} is {width}×{height} pixels; a cube's six files are alike and square.")
    return EnvImage(CUBE, as_seen_inside(np.stack(faces))), min(picture.most for picture in pictures)


def _texture_reader(path: Path) -> tuple[str, Callable[[_Path], Texture]] | None:
    """By what the file begins with; by its suffix only that it is no picture. Raises RefletError for other files."""
    suffix = path.suffix.lower()
    if suffix not in READ and suffix not in _WRITERS:
        raise RefletError(unread_sentence(path, "environment map", [*READ, *_WRITERS]))
    if suffix in READ:
        return None
    try:
        with path.open("rb") as file:
            head = file.read(12)
    except OSError as error:
        raise unreadable(path, error) from error
    for identifier, reader in _READERS.items():
        if head.startswith(identifier):
            return reader
    raise RefletError(f"{path} is neither a KTX nor a DDS file; copy it again, or name it by what it is.")


def _sound(path: Path, image: EnvImage, repair: bool, as_light: bool) -> tuple[EnvImage, list[str]]:
    """The image, repaired if so asked, and what is to be said about that. Raises RefletError for no finite radiance."""
    if repair:
        image, flaws = repaired(image)
        return image, [f"{path} is repaired: it held {flaws}."] if flaws else []
    flaws = flaws_of(image)
    if flaws is None:
        return image, []
    if flaws.nan or flaws.infinite:
        raise RefletError(f"{path} holds radiance that is not finite: {flaws}; reflet convert --repair mends it.")
    if as_light:
        said = f"{path} holds negative radiance, which is no light, and is taken as 0: {flaws}."
        return repaired(image)[0], [said]
    return image, [f"{path} holds negative radiance, which is kept: {flaws}; reflet convert --repair makes it 0."]


def write_env_image(
    path: _Path,
    levels: Sequence[EnvImage],
    layout: str | None = None,
    *,
    texel_format: str | None = None,
    zstd: bool = False,
) -> None:
    """Writes a map in the format that the suffix of ``path`` tells, whole or not at all.

    .ktx2, .ktx and .dds take all ``levels``, finest first, as "half" (the default), "float", "rgb9e5" or "r11g11b10f";
    .ktx2 packed by Zstandard if ``zstd``. Other files take one level: .hdr; .exr as "float" (the default) or "half";
    .png, clipped to [0, 1] and sRGB-encoded, with a RefletWarning that says what share of the light that costs. Light
    too bright for half floats and packed ones is spread (`holdable`).

    ``layout`` is how the faces of a cube lie in a picture: vertical-strip (the default), horizontal-strip,
    vertical-cross or horizontal-cross; a ``path`` with ``{face}`` in its name is six files, px nx py ny pz nz. For .exr
    it may be "openexr": lat-long maps and cubes as OpenEXR lays them out, marked by its ``envmap`` attribute.

    Texels are linear radiance in floats of any width, of 3 channels or 4 with alpha, in any order in memory; integers
    are refused, for they might be meant as sRGB. Raises RefletError for others, where radiance is not finite as
    float32, where the format cannot hold the map, and where a file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    levels = [as_stored(path, level) for level in levels]
    if not levels:
        raise RefletError(f"{path} cannot be written: there is no mip level to write.")
    if zstd and suffix != ".ktx2":
        raise RefletError(f"{path} cannot be packed by Zstandard; only .ktx2 can.")
    if suffix in _WRITERS:
        if layout is not None:
            raise RefletError(f"{path} holds its faces as a texture; the layout {layout} is for pictures.")
        _WRITERS[suffix](path, texture_from_levels(levels, texel_format or "half", zstd=zstd))
        return
    if suffix not in WRITTEN:
        known = " ".join([*WRITTEN, *_WRITERS])
        raise RefletError(f"{path} has no format that can be written; give a name that ends in one of {known}.")
    if len(levels) > 1:
        raise RefletError(f"{path} can hold one mip level, not {len(levels)}; leave them out or write .ktx2.")
    if texel_format not in (None, "float", "half") or (texel_format is not None and suffix != ".exr"):
        raise RefletError(f"{path} cannot be stored as {texel_format}; textures can, and .exr as float or half.")
    image = levels[0]
    if texel_format == "half":
        (image,) = holdable([image], "half")
    write_map_picture(path, image, layout, half=texel_format == "half")
    if suffix == ".png":
        warn_of_cut(image)
