"""The maps that one material looks up, on the device."""

from dataclasses import dataclass

from reflet.render.maps.env_map_texture import EnvMapTexture


@dataclass(frozen=True)
class DeviceMaps:
    """As `MaterialMaps`, with mip levels."""

    reflected: EnvMapTexture  # L_r, in the mirrored direction; of measured materials their lobes' maps
    roughness: float | None  # perceptual_roughness to look up with, where its levels are filtered for that
    diffuse: EnvMapTexture | None  # L_d, by the normal; none where the material has no use for it
