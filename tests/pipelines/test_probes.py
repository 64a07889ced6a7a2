"""Static maps as the parts of one object look them up."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import sky

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lod import roughness_of_level
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.mip_reduction import halved
from reflet.pipelines.baking.probes import seen_by
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.scene.assemble import assemble
from reflet.scene.material import MIRROR, Material, Texture
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.layers import Shells, StaticProbe
from reflet.trace.tracer import Tracer

ROUGH = replace(MIRROR, perceptual_roughness=0.6)
PATCHY = np.full((8, 8, 4), 255, np.uint8)
PATCHY[:, ::2, 1] = 0  # mirrors, every other column
MIXED = replace(ROUGH, metallic_roughness_texture=Texture(PATCHY))


def scene_of(*materials: Material) -> Scene:
    balls = [Part(f"ball {k}", sphere_mesh(0.5, (k, 0.0, 0.0), 16), look) for k, look in enumerate(materials)]
    return assemble(balls, environment=sky())


def probe_of(scene: Scene, size: int) -> StaticProbe:
    count = scene.triangle_offsets[-1]
    none = IrradianceMap(np.zeros(count, np.uint32), np.zeros(count, np.uint32), np.zeros((1, 3), np.float32))
    return Tracer(scene, irradiance=none).probe(0, Shells((0.0, 0.0, 0.0)), size=size, spp=1)


@pytest.mark.parametrize("materials", [(ROUGH,), (MIRROR, ROUGH), (MIXED,)], ids=["rough", "beside a mirror", "patchy"])
def test_rough_surfaces_see_their_lobe_whatever_is_beside_them(materials: tuple[Material, ...]) -> None:
    scene = scene_of(*materials)
    probe = probe_of(scene, 32)
    chain, plain = probe.chain, probe.shells[0].texels
    seen = seen_by(scene, tuple(range(len(materials))), probe, 0)
    np.testing.assert_array_equal(chain.level(seen, 0), chain.level(plain, 0))
    level = 3  # that 0.6 reads, mostly
    roughness = roughness_of_level(level, 32)
    assert abs(roughness - 0.6) < 0.1
    prefilter = Prefilter(EnvImage(CUBE, chain.level(plain, 0)))
    wanted = prefilter.map(GgxKernel(roughness**2), CUBE, 4).texels
    np.testing.assert_array_equal(chain.level(seen, level), wanted)
    assert np.abs(wanted - chain.level(plain, level)).max() > 0.02


@pytest.mark.parametrize(
    "other",
    [MIRROR, Material("paint", (0.5, 0.5, 0.5), 0.0, 0.9), replace(ROUGH, base_color=(0.1, 0.1, 0.1))],
    ids=["mirrors", "paint", "dark metal"],
)
def test_mirrors_see_the_map_as_it_is_also_beside_what_hardly_reflects(other: Material) -> None:
    scene = scene_of(MIRROR, other)
    probe = probe_of(scene, 16)
    assert seen_by(scene, (0, 1), probe, 0) is probe.shells[0].texels


@pytest.mark.parametrize("size", [16, 32])
def test_what_is_nearly_smooth_sees_its_lobe_too(size: int) -> None:
    """Of roughness 0.2, which is narrower than two texels of these maps: the level that it reads is filtered; coarser
    ones, which only pixels that see much read, are means of it."""
    scene = scene_of(replace(MIRROR, perceptual_roughness=0.2))
    probe = probe_of(scene, size)
    chain, plain = probe.chain, probe.shells[0].texels
    seen = seen_by(scene, (0,), probe, 0)
    roughness = [roughness_of_level(level, size) for level in range(chain.level_count)]
    assert roughness[0] > 0.2
    wanted = Prefilter(EnvImage(CUBE, chain.level(plain, 0))).map(GgxKernel(0.2**2), CUBE, size).texels
    np.testing.assert_array_equal(chain.level(seen, 0), wanted)
    np.testing.assert_array_equal(chain.level(seen, 1), halved(CUBE, wanted))
