"""Draws environment-mapped meshes, and env maps behind them.

The host's side of `shaders/material_picture.wgsl`, and of `shaders/within.wgsl` for maps of a geometry.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import wgpu

from reflet.envmap.geometry import pack
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.reflectance.materials.map_material import Lookup, MapMaterial
from reflet.reflectance.materials.material import (
    WHITE,
    Coated,
    Conductor,
    Dielectric,
    DielectricOverDiffuse,
    GlossyGgx,
    GlossyPhong,
    Mirror,
    SurfaceMaterial,
    dfg_table,
)
from reflet.reflectance.materials.measured_material import Measured
from reflet.render.maps.brdf_map_texture import lobe_table
from reflet.render.maps.env_map_texture import FULL, EnvMapTexture, create_env_map, env_map_group, env_map_layout
from reflet.render.meshes.device_mesh import VERTEX_BUFFERS, DeviceMesh, depth_state
from reflet.render.meshes.views import Rotation, view_layout
from reflet.shaders.link import link

_UNIFORM = np.dtype(
    [
        ("specular", "f4", 3), ("kind", "u4"), ("diffuse", "f4", 3), ("index", "f4"), ("k", "f4", 3),
        ("perceptual_roughness", "f4"),
    ]
)  # fmt: skip


@dataclass(frozen=True)
class DeviceMaterial:
    """A material on the device: bind group 2, and what its pipelines are built for."""

    group: wgpu.GPUBindGroup
    diffuse_map: Parameterization | None  # of the diffuse map, where it is used
    lookup: Lookup | None  # of materials that show a map as it is
    by_lobes: bool  # whether the env map holds a BRDF's lobes


@cache
def material_programs(device: wgpu.GPUDevice, colour_format: str) -> "MaterialPrograms":
    """One for all who draw into this format; building pipelines takes longer than a frame."""
    return MaterialPrograms(device, colour_format)


class MaterialPrograms:
    """Pipelines that draw a mesh before an env map, and that map as a backdrop, into passes with depth."""

    def __init__(self, device: wgpu.GPUDevice, colour_format: str) -> None:
        self._device, self._format = device, colour_format
        self.view_layout = view_layout(device)
        self._map_layouts = {near: env_map_layout(device, near) for near in (False, True)}
        fragment = wgpu.ShaderStage.FRAGMENT
        faces, table = (
            {"sample_type": "unfilterable-float", "view_dimension": dimension} for dimension in ("2d-array", "2d")
        )
        self._material_layout = device.create_bind_group_layout(
            entries=[
                {"binding": 0, "visibility": fragment, "buffer": {"type": "uniform"}},
                {"binding": 1, "visibility": fragment, "texture": faces},
                {"binding": 2, "visibility": fragment, "texture": table},
            ]
        )
        self._pipelines: dict[tuple[str, bool, tuple[tuple[str, float], ...]], wgpu.GPURenderPipeline] = {}
        self._unused_map = create_env_map(device, CUBE, 1, 1, FULL)
        self._unused_table = self._table(np.zeros((1, 1, 3), np.float32))

    def draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        env_map: EnvMapTexture,
        material: DeviceMaterial,
        mesh: DeviceMesh,
        instance: int = 0,
        double_sided: bool = False,
    ) -> None:
        """Draws a mesh; its first two bind groups are set. Backs are black where it is not double-sided.

        Raises RefletError for materials that cannot be drawn within the map's geometry.
        """
        if env_map.is_near and (material.by_lobes or material.lookup is not None):
            raise RefletError(
                f"Measured materials and maps shown as they are know no places: a map whose geometry is a "
                f"{env_map.geometry.kind} serves mirrors and glossy materials; give it the geometry infinite_sphere."
            )
        constants = _map_constants(env_map)
        if double_sided:
            constants |= {"DOUBLE_SIDED": 1}
        if material.diffuse_map is not None:
            constants |= {"DIFFUSES": 1, "DIFFUSE_KIND": material.diffuse_map.kind}
        if material.lookup is not None:
            constants |= {"LOOKUP": int(material.lookup)}
        render_pass.set_bind_group(2, material.group)
        render_pass.set_pipeline(self._pipeline("lobes" if material.by_lobes else "mesh", env_map.is_near, constants))
        mesh.draw(render_pass, instance)

    def draw_backdrop(self, render_pass: wgpu.GPURenderPassEncoder, env_map: EnvMapTexture) -> None:
        """Draws the map behind everything; its first two bind groups are set."""
        render_pass.set_pipeline(self._pipeline("backdrop", env_map.is_near, _map_constants(env_map)))
        render_pass.draw(3)

    def _pipeline(self, what: str, near: bool, constants: dict[str, float]) -> wgpu.GPURenderPipeline:
        key = what, near, tuple(constants.items())
        if key not in self._pipelines:
            mesh = what != "backdrop"
            module = self._near_module if near else self._module
            groups = [self.view_layout, self._map_layouts[near], *([self._material_layout] if mesh else [])]
            self._pipelines[key] = self._device.create_render_pipeline(
                layout=self._device.create_pipeline_layout(bind_group_layouts=groups),
                vertex={
                    "module": module,
                    "entry_point": "vertex_material" if mesh else "vertex_backdrop",
                    "buffers": VERTEX_BUFFERS if mesh else [],
                },
                primitive={"topology": "triangle-list"},
                depth_stencil=depth_state(backdrop=not mesh),
                fragment={
                    "module": module,
                    "entry_point": f"material_{what}{'_within' if near else ''}",
                    "constants": constants,
                    "targets": [{"format": self._format}],
                },
            )
        return self._pipelines[key]

    @cached_property
    def _module(self) -> wgpu.GPUShaderModule:
        return self._device.create_shader_module(code=link("material_picture.wgsl"))

    @cached_property
    def _near_module(self) -> wgpu.GPUShaderModule:
        return self._device.create_shader_module(code=link("within.wgsl"))

    def map_group(
        self,
        env_map: EnvMapTexture,
        map_from_world: Rotation | None = None,
        roughness: float | None = None,
        lod_bias: float = 0.0,
    ) -> wgpu.GPUBindGroup:
        """Bind group 1. ``roughness`` is that of lookups in a map whose levels are filtered for it."""
        near = env_map.is_near
        return env_map_group(self._device, self._map_layouts[near], env_map, map_from_world, lod_bias, roughness, near)

    def material(self, material: SurfaceMaterial, diffuse_map: EnvMapTexture | None = None) -> DeviceMaterial:
        """Bind group 2. Materials that diffuse light need the diffuse map, of any parameterization."""
        data = _packed(material).tobytes()
        buffer = self._device.create_buffer_with_data(data=data, usage=wgpu.BufferUsage.UNIFORM)
        if isinstance(material, Measured):
            table = self._table(lobe_table(material.lobes))
        else:
            table = self._dfg if isinstance(material, GlossyGgx) else self._unused_table
        shown = diffuse_map if diffuse_map is not None else self._unused_map
        group = self._device.create_bind_group(
            layout=self._material_layout,
            entries=[
                {"binding": 0, "resource": {"buffer": buffer}},
                {"binding": 1, "resource": shown.texture.create_view(dimension="2d-array")},
                {"binding": 2, "resource": table.create_view()},
            ],
        )
        return DeviceMaterial(
            group,
            diffuse_map.parameterization if diffuse_map is not None else None,
            material.lookup if isinstance(material, MapMaterial) else None,
            isinstance(material, Measured),
        )

    @cached_property
    def _dfg(self) -> wgpu.GPUTexture:
        return self._table(dfg_table())

    def _table(self, values: np.ndarray) -> wgpu.GPUTexture:
        rows, columns, channels = values.shape
        texture = self._device.create_texture(
            size=(columns, rows, 1),
            format=FULL,
            usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
        )
        texels = np.zeros((rows, columns, 4), np.float32)
        texels[..., :channels] = values
        self._device.queue.write_texture(
            {"texture": texture}, texels, {"bytes_per_row": 16 * columns, "rows_per_image": rows}, (columns, rows, 1)
        )
        return texture


def _map_constants(env_map: EnvMapTexture) -> dict[str, float]:
    constants = {"KIND": env_map.parameterization.kind, "BY_HARDWARE": int(env_map.by_hardware)}
    if env_map.levels_a_size > 1:
        constants["LEVELS_A_SIZE"] = env_map.levels_a_size
    return constants | ({"GEOMETRY_KIND": float(pack(env_map.geometry)[0])} if env_map.is_near else {})


def _packed(material: SurfaceMaterial) -> np.ndarray:
    """`Material` in `material.wgsl`."""
    uniform = np.zeros((), _UNIFORM)
    uniform["kind"] = material.kind
    for name, value in _fields(material).items():
        uniform[name] = value
    return uniform


def _fields(material: SurfaceMaterial) -> dict[str, Any]:
    match material:
        case Mirror(reflectance):
            return {"specular": reflectance}
        case MapMaterial():
            return {"specular": WHITE}
        case Measured():
            return {}
        case Dielectric(index):
            return {"index": index}
        case DielectricOverDiffuse(index, albedo) | Coated(index, albedo):
            return {"index": index, "diffuse": albedo}
        case Conductor(n, k):
            return {"specular": n, "k": k}
        case GlossyPhong(_, specular, diffuse):
            return {"specular": specular, "diffuse": diffuse}
        case GlossyGgx(color, metallic, roughness):
            diffuse = material.diffuse_color
            return {"specular": color, "diffuse": diffuse, "index": metallic, "perceptual_roughness": roughness}
    raise TypeError(f"{type(material).__name__} has no form on the device")
