"""What materials and meshes look like comes back from a PEM's folder, and as any glTF reader sees it."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from small_pem import same, small_pem

from reflet.pem.container import open_pem, save_pem
from reflet.scene.material import Material, Refraction, Texture
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.readers.gltf.read import read_gltf, read_gltf_scene

save_plain = partial(save_pem, codec="none")  # where every number comes back


@pytest.fixture(scope="module")
def pem():
    return small_pem()


def test_glass_comes_back(tmp_path, pem):
    """Its powers of two and what is not: nothing is rounded; and as any other glTF reader sees it."""
    kinds = (
        Refraction(index=1.33, attenuation_color=(0.1, 0.7, 0.9), attenuation_distance=0.3),
        Refraction(index=2.4, transmission=0.7, thin=True),
    )
    ball, knob, *rest = pem.scene.parts
    glass = [Material("glass", (0.9, 1.0, 0.8), 0.0, 0.0, emission=(0, 3.0, 0), refraction=kind) for kind in kinds]
    parts = (replace(ball, material=glass[0]), replace(knob, material=glass[1]), *rest)
    scene = replace(pem.scene, parts=parts)
    save_plain(tmp_path / "pem", replace(pem, scene=scene))
    assert same(scene, open_pem(tmp_path / "pem").scene)
    read = read_gltf(tmp_path / "pem" / "scene.gltf")
    assert [part.material.refraction for part in read][:2] == list(kinds)
    document = json.loads((tmp_path / "pem" / "scene.gltf").read_text())
    assert {"KHR_materials_emissive_strength", "KHR_materials_volume"} < set(document["extensionsUsed"])


def test_lights_come_back(tmp_path, pem):
    """Of every kind, nothing rounded but the frames of nodes; what samples see of them; and as any glTF reader does."""
    lights = (
        PunctualLight("lamp", (3.0, 0.1, 1.7), (0.5, 0.25, -2.0), range=2.5),
        PunctualLight("spot", (100.0, 0.0, 7.0), (0.0, 1.0, 0.0), (0.6, -0.8, 0.0), cone=(0.25, 0.5)),
        PunctualLight("sun", (0.001, 0.002, 0.003), None, (0.0, -1.0, 0.0)),
    )
    seen = np.random.default_rng(1).integers(0, 256, (len(pem.irradiance.radiosity), 3)).astype(np.uint8)
    lit = replace(pem, scene=replace(pem.scene, lights=lights), irradiance=replace(pem.irradiance, visibility=seen))
    save_plain(tmp_path / "pem", lit)
    back = open_pem(tmp_path / "pem")
    assert same(lit.scene.parts, back.scene.parts) and same(lit.irradiance, back.irradiance)
    for read in (back.scene.lights, tuple(read_gltf_scene(tmp_path / "pem" / "scene.gltf").lights)):
        for ours, theirs in zip(lights, read, strict=True):
            assert theirs.direction == pytest.approx(ours.direction, abs=1e-15)  # float64
            assert replace(theirs, direction=ours.direction) == ours
    save_pem(tmp_path / "coded", lit)  # its triangles in another order
    coded = open_pem(tmp_path / "coded").irradiance
    assert coded.visibility.shape == (len(coded.radiosity), 3) and coded.visibility.sum() == seen.sum()


def test_looks_come_back(tmp_path, pem):
    """Colours of vertices, further texture coordinates, and pictures that wrap: here, and as glTF readers see it."""
    ball, *rest = pem.scene.parts
    random = np.random.default_rng(2)
    count = len(ball.mesh.positions)
    colors, uv, second, third = (random.uniform(0, 1, (count, width)).astype(np.float32) for width in (4, 2, 2, 2))
    pixels = random.integers(0, 255, (2, 3, 4)).astype(np.uint8)
    texture = Texture(pixels, ("mirror", "clamp"))
    material = replace(
        ball.material, base_color_texture_srgb=texture, emission=(1.0, 1.0, 1.0), alpha=0.7, alpha_mode="mask",
        alpha_cutoff=0.3, ior=1.7, specular=0.6, specular_color=(0.5, 1.0, 1.5), clearcoat=0.8, clearcoat_roughness=0.2,
        clearcoat_texture=texture, clearcoat_roughness_texture=replace(texture, coordinates=1),
        clearcoat_normal_texture=replace(texture, coordinates=2), clearcoat_normal_scale=0.6,
        metallic_roughness_texture=replace(texture, coordinates=2),
        emission_texture_srgb=replace(texture, wraps=("clamp", "repeat"), coordinates=1),
    )  # fmt: skip
    ball = replace(ball, mesh=replace(ball.mesh, uv=uv, colors=colors, more_uv=(second, third)), material=material)
    knob, *others = rest
    knob = replace(knob, material=replace(knob.material, alpha=0.2, alpha_mode="blend", unlit=True))
    scene = replace(pem.scene, parts=(ball, knob, *others))
    save_plain(tmp_path / "pem", replace(pem, scene=scene))
    assert same(scene, open_pem(tmp_path / "pem").scene)
    read = read_gltf(tmp_path / "pem" / "scene.gltf")[0]
    assert same(read.mesh.colors, colors)
    for name, written in material.textures.items():
        if written is not None:
            shown = read.material.textures[name]
            assert shown.wraps == written.wraps
            assert same(read.mesh.uv_set(shown.coordinates), ball.mesh.uv_set(written.coordinates))
