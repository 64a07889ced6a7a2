"""What a file of an environment map says of itself."""

from dataclasses import dataclass, field

from reflet.envmap.parameterizations.parameterization import Parameterization


@dataclass(frozen=True)
class FileFacts:
    """Facts of a file, without its texels.

    ``form`` is the file's format ("KTX 2.0"), ``texel_format`` how one texel is stored ("rgba16f", "rgbe").
    ``parameterization`` is None where neither the file nor its shape tells. ``layout`` says how the faces lie: "cube",
    "layers" or "single" in textures; "openexr", "faces" (six files) or a name of `cube_layouts` in pictures; None where
    the parameterization is. ``rows`` and ``columns`` are those of the whole picture, or of one of a texture's
    ``image_count``. ``metadata`` is as the file has it; binary values are given as their length.
    """

    form: str
    parameterization: Parameterization | None
    layout: str | None
    rows: int
    columns: int
    image_count: int
    level_count: int
    channels: int
    texel_format: str
    supercompression: str | None = None
    metadata: dict[str, str] = field(default_factory=dict)
