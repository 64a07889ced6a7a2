"""The measured rendering matrix against the analytic one."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from surface_layers import random_surface

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Box, Ellipsoid, Geometry
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.relief import Relief, inverse_chebyshev
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.pipelines.verify import verify
from reflet.pipelines.verify_bounces import verify_bounces
from reflet.pipelines.verify_surface import verify_surface
from reflet.render.playback.coloring import coloring
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material, Refraction, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.shaders.link import link


def ring() -> Mesh:
    """A torus with waves on it, so that all levels of the maps are looked up."""
    u, v = np.meshgrid(np.arange(60) * np.pi / 30, np.arange(30) * np.pi / 15, indexing="ij")
    bumped = np.stack([np.cos(v) * np.cos(u), np.sin(v), np.cos(v) * np.sin(u)], -1)
    position = 0.12 * bumped + 0.3 * np.stack([np.cos(u), 0 * u, np.sin(u)], -1)
    normal = bumped + 0.2 * np.sin(7 * u + 3 * v)[..., None]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    i, j = np.meshgrid(np.arange(60), np.arange(30), indexing="ij")
    a, b = i * 30 + j, (i + 1) % 60 * 30 + j
    c, d = (i + 1) % 60 * 30 + (j + 1) % 30, i * 30 + (j + 1) % 30
    triangles = np.stack([a, c, b, a, d, c], -1).reshape(-1, 3)
    return Mesh(*(x.reshape(-1, 3).astype(t) for x, t in ((position, "f4"), (normal, "f4"), (triangles, "u4"))))


ROOM = Box((-1, -0.7, -1.2), (1.1, 1, 1), (0, 0.1, 0))


def relief() -> Relief:
    """A room with a table in it, whose edge is a gap in depth."""
    direction = texel_directions(64)
    at = ROOM.lookup_direction(np.broadcast_to(ROOM.origin, direction.shape), direction)
    table = np.array([0.0, -0.35, 0.0]) * (direction[..., 1:2] < -0.5)
    with np.errstate(divide="ignore"):
        distance = np.where(table[..., 1] < 0.0, table[..., 1] / direction[..., 1], np.linalg.norm(at, axis=-1))
    q = inverse_chebyshev(distance).astype(np.float16)
    return Relief(q, ROOM.lower, ROOM.upper, ROOM.origin)


def ring_pem(
    parameterization: Parameterization, distant: Geometry = ROOM, near: Geometry | None = None
) -> ParameterizedEnvironmentMap:
    """The ring with a distant and a local layer, and if asked a nearer shell."""
    mirror = Material(base_color=(0.65,) * 3, metallic=1.0, perceptual_roughness=0.0)
    scene = Scene((Part("ring", ring(), mirror, True),), (ReflectiveObject("ring", (0,)),))
    shell = () if near is None else (Layer("near", "distant", (0,), near, 64, parameterization, end=0.6),)
    layers = (
        *shell,
        Layer("distant", "distant", (0,), distant, 64, parameterization, begin=0.6 if shell else 0.0),
        Layer("local", "local", (0,), Ellipsoid((0, 0, 0), (0.45, 0.15, 0.45), (0, 0, 0)), 32, parameterization),
    )
    count = scene.triangle_offsets[-1]
    none = np.zeros(count, np.uint32)
    maps = [
        EnvMap(layer.chain, np.ones((layer.chain.texel_count, layer.channels), np.float32), layer.geometry)
        for layer in layers
    ]
    return ParameterizedEnvironmentMap(
        scene=scene,
        irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)),
        space=ParameterSpace((Axis("azimuth_deg", (60.0,)),), Orbit((0, 0, 0), 60.0, 22.0, 1.25, image_size=96)),
        layers=layers,
        maps=[tuple(maps)],
        on_hull=np.arange(count) % 3 == 0,
        lod_bias=-1.5,
        sample_count=4,
    )


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_measured_and_analytic_matrix_agree(name: str) -> None:
    pem = ring_pem(PARAMETERIZATIONS[name])
    found = verify(pem)
    assert found.agrees and found.bounces is None and found.surface is None  # there are none
    # Directions and their neighbours are float32: 1e-7 of 64 texels, four times that for quarter-pixel steps.
    assert found.max_difference < 3e-5
    assert found.compared_share > 0.99
    colors = sum(coloring(layer.chain).color_count for layer in pem.layers)
    assert found.test_renderings == colors * pem.sample_count


def roughened(
    pem: ParameterizedEnvironmentMap, roughness: float, texture: Texture | None = None
) -> ParameterizedEnvironmentMap:
    """The ring of this roughness, textured around it and along it if asked."""
    part = pem.scene.parts[0]
    i, j = np.meshgrid(np.arange(60), np.arange(30), indexing="ij")
    uv = np.stack([i / 20.0, j / 10.0], -1).reshape(-1, 2).astype("f4")
    material = replace(part.material, perceptual_roughness=roughness, metallic_roughness_texture=texture)
    rough = replace(part, material=material, mesh=replace(part.mesh, uv=uv))
    return replace(pem, scene=replace(pem.scene, parts=(rough, *pem.scene.parts[1:])))


def spots() -> Texture:
    """Green from 0 to 1, from texel to texel."""
    texels = np.random.default_rng(3).integers(0, 256, (8, 8, 4)).astype("u1")
    texels[..., 2] = 255
    return Texture(texels)


def test_lobes_are_looked_up_as_inference_believes() -> None:
    """Of one roughness, and of all that there are."""
    found = verify(roughened(ring_pem(PARAMETERIZATIONS["latlong"]), 0.3))
    assert found.agrees and found.max_difference < 3e-5  # as of mirrors
    found = verify(roughened(ring_pem(PARAMETERIZATIONS["cube"], relief()), 0.9, spots()))
    assert found.agrees and found.compared_share > 0.99


@pytest.mark.parametrize("name", ["cube", "latlong"])
def test_reliefs_agree_too(name: str) -> None:
    found = verify(ring_pem(PARAMETERIZATIONS[name], relief()))
    assert found.agrees and "but for 0.5%" in str(found)  # searches that a rounding sends over the table's edge
    assert found.compared_share > 0.99


def test_all_shells_are_verified() -> None:
    """Of a PEM without viewpoints too; and a fault in the near one is found."""
    pem = ring_pem(PARAMETERIZATIONS["cube"], ROOM, relief())
    found = verify(pem)
    assert found.agrees and found.compared_share > 0.99
    colors = coloring(pem.layers[0].chain).color_count
    assert found.test_renderings == (2 * colors + coloring(pem.layers[2].chain).color_count) * pem.sample_count
    static = replace(
        pem,
        space=ParameterSpace((Axis("azimuth_deg", ()),), pem.space.orbit),
        layers=pem.layers[:2],
        maps=[],
        base=pem.maps[0][:2],
    )
    assert verify(static).agrees
    # the renderer draws another near shell than the layer says
    moved = replace(relief(), origin=(0.0, 0.15, 0.0))
    other = replace(pem, layers=(replace(pem.layers[0], geometry=moved), *pem.layers[1:]))
    assert not verify(pem, renderer=Renderer(other)).agrees


@pytest.mark.parametrize(
    ("roughness", "change"),
    [
        (0.0, lambda text: text.replace("+ lod_bias", "+ lod_bias + 0.5")),
        (0.0, lambda text: text.replace("dot(ray, n) * n", "dot(ray, n) * n * 1.001")),
        (0.0, lambda text: text.replace("FETCHES = 4u", "FETCHES = 3u")),
        (0.3, lambda text: text.replace("spread * select(t,", "0.98 * spread * select(t,")),
        (0.3, lambda text: text.replace("r + lean * (normalize", "r + 0.9 * lean * (normalize")),
    ],
    ids=["LOD half a level off", "mirrored ray a little off", "a search that ends early", "a narrow lobe", "less lean"],
)
def test_a_shader_that_differs_is_found_out(
    roughness: float, change: Callable[[str], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert change(link("probe.wgsl")) != link("probe.wgsl")
    monkeypatch.setattr("reflet.render.playback.passes.link", lambda program: change(link(program)))
    found = verify(roughened(ring_pem(PARAMETERIZATIONS["cube"], relief()), roughness))
    assert not found.agrees and found.max_difference > 1e-3
    assert "differs" in str(found)


def traced_pem() -> ParameterizedEnvironmentMap:
    """The ring and a glass ball in it, each seen in the other, and a matte block beside them."""
    pem = ring_pem(PARAMETERIZATIONS["cube"])
    ring_part = pem.scene.parts[0]
    clear = replace(ring_part.material, metallic=0.0, refraction=Refraction(1.5, 0.9, (0.3, 0.9, 0.6), 0.2))
    ball = Part("ball", sphere_mesh(0.15, (0.0, 0.12, 0.0), around=48), clear, True)
    block = replace(ring_part, name="block", reflective=False, mesh=sphere_mesh(0.06, (0.28, 0.25, 0.1), around=16))
    glowing = replace(block, material=Material("red", (0.8, 0.2, 0.1), 0.0, 1.0, emission=(0.3, 0.1, 0.0)))
    scene = Scene((ring_part, ball, glowing), (ReflectiveObject("both", (0, 1)),))
    count = scene.triangle_offsets[-1]
    none = np.zeros(count, np.uint32)
    shells = tuple(replace(layer, parts=(0, 1)) for layer in pem.layers if layer.kind == "distant")
    return replace(
        pem, scene=scene, layers=shells, maps=[pem.maps[0][:1]], most_hits=8,
        irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)), on_hull=np.zeros(count, bool),
    )  # fmt: skip


def test_bounces_are_verified() -> None:
    """Through mirrors, glass, and what ends a ray."""
    found = verify(traced_pem())
    assert found.bounces is not None and found.bounces.agrees and found.agrees
    assert found.bounces.rays > 500 and "meet the ray tracer's triangles" in str(found)
    assert found.surface is None


def test_rays_of_what_is_nearly_smooth_are_verified() -> None:
    """Along the lobe's peak; those of what is rougher are not traced."""
    smooth, rough = (roughened(traced_pem(), roughness) for roughness in (0.15, 0.3))
    found, none = (verify_bounces(pem, pem.space.camera(0)) for pem in (smooth, rough))
    assert found.agrees and none.agrees and found.rays > 1.5 * none.rays > 0  # the glass ball's are traced in both


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda text: text.replace("OFFSET = 1e-5", "OFFSET = 2e-2"), "equal_share"),
        pytest.param(  # a driver in software compiles it for long; colours are compared in light on surfaces too
            lambda text: text.replace("exp(-hit.t * leaving.medium)", "exp(-0.9 * hit.t * leaving.medium)"),
            "difference",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["rays that start elsewhere", "glass is clearer"],
)  # fmt: skip
def test_a_shader_that_follows_rays_otherwise_is_found_out(
    change: Callable[[str], str], what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert change(link("traced_picture.wgsl")) != link("traced_picture.wgsl")
    monkeypatch.setattr("reflet.render.playback.passes.link", lambda program: change(link(program)))
    pem = traced_pem()
    found = verify_bounces(pem, pem.space.camera(0))
    assert not found.agrees
    assert found.equal_share < 0.99 if what == "equal_share" else found.difference > 5e-3


def rough_pem() -> ParameterizedEnvironmentMap:
    """The ring of roughness 0.3, with light on it."""
    pem = roughened(traced_pem(), 0.3)
    return replace(pem, surface=random_surface(pem.scene, (0,)))


def test_light_on_surfaces_is_verified() -> None:
    found = verify(rough_pem())
    assert found.surface is not None and found.surface.agrees and found.agrees
    assert found.surface.pixels > 1000 and "pixels of rough surfaces" in str(found)


@pytest.mark.parametrize(
    ("text", "instead"),
    [
        ("let right = corner + r + 1u - i;", "let right = corner + r - i;"),
        ("side - 1 - within.x, at.y != within.y", "within.x, at.y != within.y"),
    ],
    ids=["another site", "no fold at the map's edge"],
)
def test_a_shader_that_looks_light_on_surfaces_up_otherwise_is_found_out(
    text: str, instead: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert text in link("picture.wgsl")
    monkeypatch.setattr("reflet.render.playback.passes.link", lambda program: link(program).replace(text, instead))
    pem = rough_pem()
    assert not verify_surface(pem, pem.space.camera(0)).agrees
