"""Draws a shaded scene as the viewer does, on another graphics driver than this process has: set VK_DRIVER_FILES.

``draw_materials.py FOLDER REQUESTS.json OUT.npz``; a request has width, height, samples and the viewer's settings. Each
frame comes twice: by the device's prefilters (``NAME``), and by `MaterialRenderer`, which filters with the CPU
(``NAME-cpu``).
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lamp import Lamp
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.rotations import turn_about_vertical
from reflet.files.measured_brdf_file import read_measured_brdf
from reflet.files.textures.ktx2 import read_ktx2
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.lobes.lobes import fit_lobes
from reflet.reflectance.materials import material as materials
from reflet.reflectance.materials.map_material import Lookup, MapMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.measured_material import Measured
from reflet.render.device.device import shared_device
from reflet.render.filters.brdf_map_filter import BrdfMapFilter
from reflet.render.filters.lamp import LampPainter
from reflet.render.filters.phong_paraboloid import PhongParaboloidFilter
from reflet.render.filters.probe_filter import ProbeFilter
from reflet.render.filters.probe_pyramid import FILLED, ProbePyramid
from reflet.render.filters.still_environment import StillEnvironment
from reflet.render.maps.env_map_texture import HALF, create_env_map, upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.scene.readers.gltf.read import read_gltf
from reflet.scene.views.parameter_space import Orbit

CLASSES = {
    "mirror": materials.Mirror,
    "dielectric": materials.Dielectric,
    "dielectric_over_diffuse": materials.DielectricOverDiffuse,
    "coated": materials.Coated,
    "conductor": materials.Conductor,
    "phong": materials.GlossyPhong,
    "ggx": materials.GlossyGgx,
}


def material_of(settings, folder):
    """The material that the viewer's settings describe; the order of their fields is that of the class."""
    fields = dict(settings["material"])
    kind = fields.pop("kind")
    if kind == "table":
        return Measured(fit_lobes(read_measured_brdf(folder / fields["table"]), angles=3))
    return CLASSES[kind](*(tuple(value) if isinstance(value, list) else value for value in fields.values()))


def lamp_of(settings):
    """The lamp that they describe."""
    phi, theta = np.radians([settings["azimuth"], settings["elevation"]])
    direction = (np.cos(phi) * np.cos(theta), np.sin(theta), -np.sin(phi) * np.cos(theta))
    return Lamp(direction, settings["radius"], tuple(settings["brightness"] * c for c in settings["colour"]))


class Scene:
    """What the folder holds, on the device."""

    def __init__(self, folder):
        self.folder, self.device = folder, shared_device()
        document = json.loads((folder / "scene.gltf").read_bytes())
        (self.extension,) = document["extensions"].values()
        orbit = self.extension["orbit"]
        self.orbit = Orbit(
            tuple(orbit["target"]), orbit["azimuthDeg"], orbit["elevationDeg"], orbit["distance"], orbit["fovDeg"]
        )
        (part,) = read_gltf(folder / "scene.gltf")
        self.mesh = part.mesh
        self.renderer = EnvMapRenderer(self.mesh)
        self.levels = self.read(self.extension["environment"])
        self.environment = upload_env_map(self.device, self.levels)
        self.diffuse = upload_env_map(self.device, self.read(self.extension["diffuse"]))
        self.ggx = ProbeFilter(self.device, self.extension["ggx"]["size"])
        self.painter = LampPainter(self.device, self.extension["environment"]["size"])
        self.pyramid = ProbePyramid(self.device, 64)
        self.lit_diffuse = create_env_map(self.device, CUBE, 16, 1, HALF, FILLED)
        self.phong = PhongParaboloidFilter(self.device, self.extension["phongSize"])
        finest = self.levels[0]
        maps = EnvironmentMaps(EnvImage(finest.parameterization, finest.texels.astype(np.float32)))
        self.still, self.by_cpu = StillEnvironment(maps, self.device), MaterialRenderer(self.mesh, maps)

    def read(self, item):
        """A map's levels, in half float."""
        file = read_ktx2(self.folder / item["uri"])
        return tuple(EnvImage(file.chain.parameterization, np.array(level)) for level in file.levels)

    def frames(self, request):
        """Both pictures of a request; the second only where there is light to filter."""
        settings = request["settings"]
        camera = replace(self.orbit.camera(), width=request["width"], height=request["height"])
        common = {"frame": turn_about_vertical(settings["turn"]), "samples": request["samples"]}
        if settings["material"]["kind"] == "map":
            (item,) = (each for each in self.extension["maps"] if each["name"] == settings["material"]["map"])
            material = MapMaterial(Lookup[item["lookup"].upper()])
            drawn = self.picture(self.read(item), material, camera, backdrop=False, **common)
            return drawn, None
        material = material_of(settings, self.folder)
        environment, diffuse = self.environment, self.diffuse
        lamp = lamp_of(settings["lamp"]) if settings["lamp"]["on"] else None
        if lamp is not None:
            environment, diffuse = self.lit(lamp)
        backdrop = environment if settings["backdrop"] else False
        by_cpu = None
        if lamp is None or isinstance(material, Measured):
            by_cpu = self.cpu(lamp).picture(material, camera, backdrop=settings["backdrop"], **common)
        roughness = None
        encoder = self.device.create_command_encoder()
        shown = environment
        if isinstance(material, materials.GlossyPhong):
            shown = self.phong.refilter(encoder, environment, PhongKernel(material.phong_exponent))
        elif isinstance(material, materials.GlossyGgx):
            shown, roughness = self.ggx.refilter(encoder, environment), material.perceptual_roughness
        elif isinstance(material, Measured):
            shown = self.lobes(encoder, material, environment, lamp is not None)
        self.device.queue.submit([encoder.finish()])
        arguments = {"backdrop": backdrop, "roughness": roughness, **common}
        return self.picture(shown, material, camera, diffuse, **arguments), by_cpu

    def lit(self, lamp):
        """The environment with a lamp, and its diffuse map."""
        encoder = self.device.create_command_encoder()
        environment = self.painter.paint(encoder, self.environment, lamp)
        self.pyramid.fill(encoder, environment)
        self.pyramid.diffuse(encoder, self.lit_diffuse)
        self.device.queue.submit([encoder.finish()])
        return environment, self.lit_diffuse

    def lobes(self, encoder, material, environment, lit):
        """A table's maps: those of its file, or filtered here."""
        still = self.still.maps(material).reflected
        if not lit:
            return still
        filtered = BrdfMapFilter(ProbePyramid(self.device, max(still.size, 16)), material.lobes)
        filtered.pyramid.fill(encoder, environment)
        filtered.refilter(encoder)
        return filtered.result

    def cpu(self, lamp):
        """The renderer whose maps the CPU filters, from the environment with the lamp at the painter's points."""
        if lamp is None:
            return self.by_cpu
        finest = self.levels[0]
        share = lamp.share(CUBE.texel_directions(4 * finest.size)[0])
        share = share.reshape(6, finest.size, 4, finest.size, 4, 1).mean((2, 4))
        lit = finest.texels[..., :3].astype(np.float32) + share * np.array(lamp.radiance, np.float32)
        return MaterialRenderer(self.mesh, EnvironmentMaps(EnvImage(CUBE, lit.astype(np.float32))))

    def picture(self, shown, material, camera, diffuse=None, **arguments):
        """By the renderer."""
        texture = upload_env_map(self.device, shown) if isinstance(shown, tuple) else shown
        on_device = self.renderer.programs.material(material, diffuse if material.diffuses else None)
        return self.renderer.picture(texture, camera, material=on_device, **arguments)


if __name__ == "__main__":
    scene = Scene(Path(sys.argv[1]))
    drawn = {}
    for name, request in json.loads(Path(sys.argv[2]).read_text()).items():
        drawn[name], by_cpu = scene.frames(request)
        if by_cpu is not None:
            drawn[f"{name}-cpu"] = by_cpu
    np.savez(sys.argv[3], adapter=shared_device().adapter.info["device"], **drawn)
