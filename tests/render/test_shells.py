"""Shells and the base, beside NumPy."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from small_pem import small_pem

from reflet.envmap.env_map import EnvMap
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.stacks import stacks_of
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.camera import Camera

mirrors = partial(small_pem, with_room=False, with_environment=False)  # what else there is takes time to compile
BETWEEN = {"azimuth_deg": 61.5}  # a quarter of the first sample, three of the second


class Reference:
    """What each sub-sample of a picture looks up, by the analytic rendering matrix, one sub-sample a pixel."""

    def __init__(self, renderer: Renderer, camera: Camera) -> None:
        self.pem = renderer.pem
        scene = self.pem.scene
        self.gbuffer = gbuffer_from_visibility(scene, rasterized_visibility(renderer, camera, 1))
        self.part = self.gbuffer.row_part[self.gbuffer.row_of_sample]

    def texels(self, number: int, env_map: EnvMap, camera: Camera) -> np.ndarray:
        """Premultiplied radiance and alpha of a layer's map that was made at ``camera``; 0 where none is looked up."""
        layer = self.pem.layers[number]
        select = np.isin(self.part, layer.parts)
        if layer.kind == "local":
            select &= ~self.pem.on_hull[self.gbuffer.triangle]
        a = rendering_matrix(
            self.gbuffer, layer.chain, layer.geometry, self.pem.lod_bias, select, layer.map_from_world(camera)
        )
        half = env_map.texels.astype(np.float16).astype(np.float64)
        four = half if layer.channels == 4 else np.concatenate([half, np.ones((len(half), 1))], 1)
        return sp.csr_matrix((a.weights, a.columns, a.starts), (len(a.starts) - 1, a.texel_count)) @ four

    def maps(self, sample: int | None) -> tuple[dict[int, EnvMap], Camera]:
        """The maps of a sample or the base, by layer, and the camera they were made at."""
        if sample is None:
            return dict(zip(self.pem.distant_layers, self.pem.base, strict=True)), self.pem.space.orbit.camera()
        return dict(enumerate(self.pem.maps[sample])), self.pem.space.camera(sample)

    def distant(self, sample: int | None, shells: tuple[int, ...]) -> np.ndarray:
        """Shells, each over the next."""
        (maps, camera), seen = self.maps(sample), 0.0
        for number in (self.pem.distant_layers[shell] for shell in shells):
            texels = self.texels(number, maps[number], camera)
            seen = seen + (1.0 - (seen[:, 3:] if shells[0] != number else 0.0)) * texels
        return np.asarray(seen)

    def local(self, sample: int) -> np.ndarray:
        """The local layers, of which no two have a row in common."""
        maps, camera = self.maps(sample)
        numbers = [i for i, layer in enumerate(self.pem.layers) if layer.kind == "local"]
        return np.sum([self.texels(i, maps[i], camera) for i in numbers], 0)


def agree(shown: np.ndarray, expected: np.ndarray) -> None:
    """Float32 beside float64: weights to 1e-5, texels up to 1.1, three roundings more a shell. Searches that a rounding
    sends over an edge of the rough relief end elsewhere: rare."""
    error = np.abs(shown - expected).max(-1)
    assert len(error) > 3000
    assert np.percentile(error, 98) < 3e-5
    assert np.mean(error > 0.01) < 0.005


@pytest.mark.parametrize(
    ("shells", "name", "shares"),
    [(2, "cube", (0.0, 0.25, 1.0)), (3, "dual_paraboloid", (0.5,)), (2, "gazing_ball", (0.25,))],
)
def test_shells_and_base_are_composited_as_in_numpy(shells: int, name: str, shares: tuple[float, ...]) -> None:
    """Two parts share the shells; the ball may see itself in one half."""
    pem = mirrors(shells=shells, parameterization=PARAMETERIZATIONS[name])
    renderer, camera = Renderer(pem), pem.space.orbit.camera(BETWEEN)
    reference = Reference(renderer, camera)
    pixels = reference.gbuffer.row_pixel
    weights = pem.space.blend_weights(BETWEEN)
    everything = tuple(range(shells))
    own = {sample: reference.distant(sample, everything) for sample in weights}
    of_base = reference.distant(None, everything)
    for share in shares:
        distant = renderer.layer_image(camera, "distant", samples=1, base=share).reshape(-1, 4)[pixels]
        mean = sum(weight * own[sample] for sample, weight in weights.items())
        agree(distant, (1.0 - share) * mean + share * of_base)
        np.testing.assert_allclose(distant[:, 3], 1.0, atol=1e-6)

        incident = np.zeros_like(of_base)
        for sample, weight in weights.items():
            near = reference.local(sample)
            behind = (1.0 - share) * own[sample] + share * of_base
            incident += weight * (near + (1.0 - near[:, 3:]) * behind)
        shown = renderer.frame(camera, samples=1, layers=("distant", "local"), what="object", base=share)
        agree(shown.reshape(-1, 4)[pixels, :3], incident[:, :3])


def test_shells_can_be_hidden() -> None:
    pem = mirrors(views=1, shells=3, size=8)
    renderer, camera = Renderer(pem), pem.space.camera(0)
    reference = Reference(renderer, camera)
    pixels = reference.gbuffer.row_pixel
    for shells in ((1,), (0, 2)):
        shown = renderer.layer_image(camera, "distant", samples=1, shells=shells).reshape(-1, 4)[pixels]
        agree(shown, reference.distant(0, shells))
    frame = renderer.frame(camera, samples=1, shells=shells, layers=("distant",), what="object")
    np.testing.assert_allclose(frame.reshape(-1, 4)[pixels, :3], shown[:, :3], atol=1e-6)
    assert not renderer.layer_image(camera, "distant", samples=1, shells=()).any()
    everything = renderer.layer_image(camera, "distant", samples=1, shells=(0, 1, 2))
    np.testing.assert_array_equal(everything, renderer.layer_image(camera, "distant", samples=1))


def test_the_base_has_its_share_by_place() -> None:
    """Half the way to `fade_deg` it is half the distant light; on the samples none, far away all."""
    pem = mirrors(shells=2, size=8)
    renderer = Renderer(pem)
    on, off, far = ({"azimuth_deg": 60.0, "elevation_deg": 22.0 + up} for up in (0.0, 5.0, 30.0))
    for point, share in ((on, 0.0), (off, pem.base_share(off)), (far, 1.0)):
        camera = pem.space.orbit.camera(point)
        by_place, forced = (renderer.frame(camera, samples=1, point=point, base=base) for base in (None, share))
        np.testing.assert_array_equal(by_place, forced)
        for other in {0.0, 1.0} - {share}:
            assert np.abs(by_place - renderer.frame(camera, samples=1, point=point, base=other)).max() > 0.1
    assert pem.base_share(off) == pytest.approx(0.5, abs=1e-3)  # a chord for an arc of 5°


def test_a_base_alone_serves_every_viewpoint() -> None:
    """A PEM without samples shows what another shows of its base; it has no local maps."""
    pem = mirrors(shells=2, size=8)
    static = Renderer(mirrors(views=0, shells=2, size=8))
    for point in ({"azimuth_deg": 200.0}, {"azimuth_deg": 61.0, "elevation_deg": 50.0}):
        camera = pem.space.orbit.camera(point)
        expected = Renderer(pem).frame(camera, samples=1, layers=("diffuse", "fresnel", "distant"), base=1.0)
        np.testing.assert_array_equal(static.frame(camera, samples=1), expected)
        np.testing.assert_array_equal(static.frame(camera, samples=1, blend=False), expected)
        assert not static.layer_image(camera, "local", samples=1).any()
        assert (static.layer_image(camera, "distant", samples=1)[..., 3] == 1.0).any()


def two_objects() -> ParameterizedEnvironmentMap:
    """The ball sees two shells, the knob none but the far one, by layers of its own."""
    pem = mirrors(shells=2, size=8)
    near, far, *local = pem.layers
    layers = (replace(far, parts=(1,)), replace(near, parts=(0,)), replace(far, parts=(0,)), *local)
    maps = [(far_map, near_map, far_map, *rest) for near_map, far_map, *rest in pem.maps]
    return replace(pem, layers=layers, maps=maps, base=(pem.base[1], *pem.base))


def test_objects_have_shells_of_their_own() -> None:
    renderer, both = Renderer(two_objects()), Renderer(mirrors(shells=2, size=8))
    assert [stack.layers for stack in renderer.stacks] == [(0,), (1, 2), (3,), (4,)]
    camera = both.pem.space.orbit.camera(BETWEEN)
    seen = rasterized_visibility(both, camera, 1)
    knob = seen.triangle >= both.pem.scene.triangle_offsets[1]
    assert 0.05 < knob.mean() < 0.5
    for base in (0.0, 0.5):
        shown, with_both, with_far = (
            each.frame(camera, samples=1, shells=shells, base=base).reshape(-1, 4)[seen.pixel]
            for each, shells in ((renderer, None), (both, None), (both, (1,)))
        )
        np.testing.assert_allclose(shown[~knob], with_both[~knob], atol=1e-6)
        np.testing.assert_allclose(shown[knob], with_far[knob], atol=1e-6)
        assert np.abs(with_both - with_far)[knob].max() > 0.1


def test_few_slots_serve_many_samples() -> None:
    pem = mirrors(views=40, shells=3, size=4)  # more than the 13 of 18 array layers each that fit beside the base's
    small, large = Renderer(pem, map_memory=1), Renderer(pem)
    for azimuth in (60.0, 137.0, 99.5, 61.0):
        camera = pem.space.orbit.camera({"azimuth_deg": azimuth, "elevation_deg": 25.0})
        np.testing.assert_array_equal(small.frame(camera, samples=1), large.frame(camera, samples=1))


def test_what_makes_no_sense_is_refused_in_a_sentence() -> None:
    pem = mirrors(shells=2, size=4)
    renderer, camera = Renderer(pem), pem.space.camera(0)
    with pytest.raises(RefletError, match="0 to 2, the nearest first, not 3"):
        renderer.frame(camera, shells=[0, 3])
    with pytest.raises(RefletError, match=r"between 0 and 1 of the distant light, not 1\.5"):
        renderer.frame(camera, base=1.5)
    with pytest.raises(RefletError, match="between 0 and 0"):
        Renderer(mirrors(with_base=False, size=4)).frame(camera, base=0.5)
    with pytest.raises(RefletError, match="between 1 and 1"):
        Renderer(mirrors(views=0, size=4)).layer_image(camera, "distant", base=0.0)
    with pytest.raises(RefletError, match="neither viewpoints nor maps that serve all"):
        Renderer(mirrors(views=0, size=4, with_base=False))
    near, far, *_ = pem.layers
    for layers, sentence in (
        ((far, near), "nearest first"),
        ((near,), "only the last without end"),
        ((near, near, near, far), "at most 3"),
        ((near, replace(far, size=8)), "differ in size"),
        ((near, far, replace(far, parts=(1,))), "shares with different parts"),
    ):
        with pytest.raises(RefletError, match=sentence):
            stacks_of(layers)
    coarse = replace(near.geometry, inverse_distance=near.geometry.inverse_distance[:, ::2, ::2])
    uneven = (replace(near, geometry=coarse, end=0.5), replace(near, begin=0.5), far)
    maps = [(maps[0], *maps) for maps in pem.maps]
    with pytest.raises(RefletError, match="4 and 8 rows"):
        Renderer(replace(pem, layers=(*uneven, *pem.layers[2:]), maps=maps, base=()))


def test_colours_of_origin_add_up_to_the_light() -> None:
    """Each colour times the luminance of the light from there, shell by shell; the last of three is the far one."""
    pem = mirrors(views=0, shells=3, size=8)
    renderer, camera = Renderer(pem), pem.space.orbit.camera()
    colours = np.array([[0.5, 1.2, 0.25], [1.1, 1.05, 0.1], [0.35, 1.0, 2.6]])
    luminance = np.array([0.2126, 0.7152, 0.0722])

    def frame(shells: tuple[int, ...], by_origin: bool) -> np.ndarray:
        return renderer.frame(
            camera, samples=1, shells=shells, layers=("distant",), what="object", by_origin=by_origin
        )[..., :3]

    # What the shells behind the nearest bring to the picture is what is missing without them.
    first, two, three = (frame(tuple(range(count)), False) for count in (1, 2, 3))
    expected = sum(
        (light @ luminance)[..., None] * colour
        for light, colour in zip((first, two - first, three - two), colours, strict=True)
    )
    np.testing.assert_allclose(frame((0, 1, 2), True), expected, atol=1e-5)  # float32
    np.testing.assert_allclose(three @ luminance, expected @ luminance, rtol=0.025)  # of the colours
