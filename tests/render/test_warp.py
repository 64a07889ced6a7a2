"""Maps made from maps on the device: mip levels, and other parameterizations."""

import numpy as np
import pytest
import wgpu
from map_scenes import analytic_levels, linear

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mip_levels_from_finest
from reflet.envmap.resampling.padding import continued, outside_disc
from reflet.render.device.device import shared_device
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map, upload_env_map
from reflet.render.maps.map_levels import MapLevels
from reflet.render.materials.env_map_renderer import view_frame
from reflet.render.meshes.warp import Warp
from reflet.scene.views.camera import Camera

EACH = pytest.mark.parametrize("kind", PARAMETERIZATIONS.values(), ids=str)


def filled(env_map: EnvMapTexture) -> EnvMapTexture:
    """With the mip levels made on the device."""
    encoder = shared_device().create_command_encoder()
    MapLevels(shared_device(), env_map).fill(encoder)
    shared_device().queue.submit([encoder.finish()])
    return env_map


def uploaded(image: EnvImage) -> EnvMapTexture:
    """A half-float map with room for all levels, the finest filled."""
    env_map = create_env_map(
        shared_device(), image.parameterization, image.size, image.size.bit_length(), HALF,
        wgpu.TextureUsage.STORAGE_BINDING,
    )  # fmt: skip
    faces, rows, columns = image.parameterization.shape(image.size)
    texels = np.ones((faces, rows, columns, 4), np.float16)
    texels[..., :3] = image.texels
    shared_device().queue.write_texture(
        {"texture": env_map.texture},
        texels,
        {"bytes_per_row": texels.strides[1], "rows_per_image": rows},
        (columns, rows, faces),
    )
    return env_map


@EACH
def test_levels_are_means_by_solid_angle(kind: Parameterization) -> None:
    chain = MipChain(32, kind)
    finest = np.random.default_rng(7).uniform(0.0, 2.0, (*chain.level_shape(0), 3))
    finest = continued(kind, finest, outside_disc(kind, 32)).astype(np.float16)
    env_map = filled(uploaded(EnvImage(kind, finest)))
    expected = mip_levels_from_finest(chain, finest.astype(np.float64))
    solid_angle = np.array(kind.texel_solid_angle(32))
    for level in range(1, chain.level_count):
        faces, rows, columns = chain.level_shape(level)
        solid_angle = solid_angle.reshape(faces, rows, 2, columns, 2).sum((2, 4))
        seen = solid_angle > 1e-6  # steradians; beyond the rim there is the map's continuation
        texels, wanted = env_map.read(level).texels[seen][:, :3].astype(float), chain.level(expected, level)[seen]
        if kind.is_round:  # the device does not restore the mean over all directions
            wanted = wanted * (solid_angle[seen] @ texels) / (solid_angle[seen] @ wanted)
        # Each level rounds to half floats, on some drivers towards zero: up to 2^-10 of values from 1 to 2, five times.
        np.testing.assert_allclose(texels, wanted, atol=5e-3)


@EACH
def test_levels_keep_a_constant(kind: Parameterization) -> None:
    env_map = filled(uploaded(EnvImage(kind, np.ones((*kind.shape(16), 3), np.float16))))
    for level in range(5):
        assert (env_map.read(level).texels == 1.0).all()


@EACH
def test_a_warped_cube_holds_the_same(kind: Parameterization) -> None:
    device = shared_device()
    turn = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0)))
    cube = upload_env_map(device, analytic_levels(CUBE, 64))
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.STORAGE_BINDING
    target = create_env_map(device, kind, 64, 7, HALF, usage)
    encoder = device.create_command_encoder()
    Warp(device, target).draw(encoder, cube, turn)
    device.queue.submit([encoder.finish()])
    direction, valid = kind.texel_directions(64)
    texels = target.read().texels[..., :3].astype(float)
    # Half floats near 0.9, and curvature over cube texels: as coarse as the target's where those are long (a gazing
    # ball's near its rim, an angular map's at its own, lat-longs' at the poles).
    error = np.abs(texels - linear(direction @ turn.T)).max(-1)[valid]
    assert np.quantile(error, 0.9) < (4e-3 if kind.is_view_dependent else 1.5e-3)
    assert error.max() < (0.2 if kind.is_view_dependent else 0.03)
