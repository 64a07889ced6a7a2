"""Env maps of moving scenes, drawn anew for every frame."""

from typing import Literal

import numpy as np
import wgpu
from jaxtyping import Bool, Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.spread_light import HALF_MAX, held
from reflet.errors import RefletError
from reflet.render.capture.matte_scene import MatteScene
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map, upload_env_map
from reflet.render.maps.map_levels import MapLevels
from reflet.render.meshes.device_mesh import begin_pass
from reflet.render.meshes.views import Rotation, Views, cube_view, paraboloid_view, view_layout
from reflet.render.meshes.visible_parts import bounding_spheres, reach_into_cube, reach_into_paraboloids
from reflet.render.meshes.warp import Warp, WarpPrograms, face_views
from reflet.scene.scene import Scene
from reflet.scene.sky_light import OVERCAST, SkyLight
from reflet.scene.views.camera import Vec3

Method = Literal["cube", "dual_paraboloid", "warp"]
_FILLED = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.STORAGE_BINDING


def upload_environment(device: wgpu.GPUDevice, scene: Scene) -> EnvMapTexture | None:
    """The scene's distant environment, with mip levels where its rows are a power of two; 16 bytes a texel."""
    if scene.environment is None:
        return None
    image = EnvImage(LatLong(), scene.environment.radiance[None])
    (image,) = held([image], HALF_MAX, "a captured map")
    power_of_two = image.size & (image.size - 1) == 0
    return upload_env_map(device, mip_images(image) if power_of_two else [image])


def covering_cube_size(parameterization: Parameterization, size: int) -> int:
    """Rows of the smallest cube, a power of two, that has at least as many texels as a map of this size."""
    texels = int(np.prod(parameterization.shape(size)))
    return 1 << int(np.ceil(np.log2(np.sqrt(texels / 6.0))))


class EnvironmentCapture:
    """Draws what surrounds a point into an env map with all its mip levels, as often as something moves.

    Parts that reflect are left out: they are what mirrors the map. Matte and glowing surfaces are shaded under a
    `SkyLight`. The ways to a map [Heidrich00, sec. 2]:

    - ``"cube"``: six views of 90°, exact.
    - ``"dual_paraboloid"``: two views, their vertices projected onto the paraboloids. Straight edges stay straight, so
      that they miss the arcs that they should be by up to (1 - cos φ/2)/2 of a face's rows where they span the angle φ
      at the eye: below one texel for φ < √(16/size), 20° at 128 rows, 14° at 256. Cut larger triangles
      (`reflet.scene.meshes.tessellate`) or choose another method.
    - ``"warp"``: a cube, drawn as a map of the parameterization ``to``; each texel is one lookup in it.

    Maps are half float. The map's ``size`` is that of its faces in rows, a power of two; a warped cube has at least as
    many texels.
    """

    def __init__(
        self,
        device: wgpu.GPUDevice,
        scene: Scene,
        size: int,
        method: Method = "cube",
        to: Parameterization | None = None,
        light: SkyLight = OVERCAST,
        near: float = 0.01,
    ) -> None:
        """``near`` is the distance in metres within which nothing is drawn."""
        if (method == "warp") != (to is not None):
            raise RefletError(f"A warp, and nothing else, needs a parameterization to warp to; {method} to {to} came.")
        self._device, self._near = device, near
        self._drawn = np.array([not part.reflective for part in scene.parts])
        self._spheres = bounding_spheres(scene)
        self._onto_paraboloid = method == "dual_paraboloid"
        kind: Parameterization = DualParaboloid() if self._onto_paraboloid else CUBE
        drawn_size = size if to is None else covering_cube_size(to, size)
        self._map = create_env_map(device, kind, drawn_size, drawn_size.bit_length(), HALF, _FILLED)
        self._levels = MapLevels(device, self._map)
        layout = view_layout(device)
        self._views = Views(device, layout, kind.face_count, len(scene.parts))
        self._matte = MatteScene(device, scene, light, layout)
        self._environment = upload_environment(device, scene)
        self._backdrop = WarpPrograms(device, layout, as_backdrop=True)
        self._faces = face_views(self._map.texture, kind.face_count)
        self._depth = device.create_texture(
            size=(drawn_size, drawn_size, 1), format="depth32float", usage=wgpu.TextureUsage.RENDER_ATTACHMENT
        ).create_view()
        self._warped = None if to is None else create_env_map(device, to, size, size.bit_length(), HALF, _FILLED)
        self._warp = None if self._warped is None else Warp(device, self._warped)

    def frame(
        self,
        world_from_part: Float[np.ndarray, "parts 4 4"],
        centre: Vec3,
        map_from_world: Rotation | None = None,
    ) -> EnvMapTexture:
        """What is seen from ``centre``, with every part moved by its rigid transform; the same texture every time.

        ``map_from_world`` turns the map, for those that depend on the view (`view_frame`), by default not at all.
        """
        turn = np.eye(3) if map_from_world is None else map_from_world
        kind, size = self._map.parameterization, self._map.size
        view = paraboloid_view if self._onto_paraboloid else cube_view
        self._views.write(
            [view(face, size, centre, self._near, turn) for face in range(kind.face_count)], world_from_part
        )
        environment = self._environment and self._backdrop.source_group(self._environment, turn.T)
        encoder = self._device.create_command_encoder()
        visible = self._visible(world_from_part, np.array(centre, np.float64), turn)
        for group, face, seen in zip(self._views.groups, self._faces, visible, strict=True):
            render_pass = begin_pass(encoder, face, self._depth)
            render_pass.set_bind_group(0, group)
            self._matte.draw(render_pass, np.flatnonzero(seen).tolist(), HALF, self._onto_paraboloid)
            if self._environment is not None:
                self._backdrop.draw(render_pass, self._environment, environment, kind, HALF)
            render_pass.end()
        self._levels.fill(encoder)
        if self._warp is not None:
            self._warp.draw(encoder, self._map)
        self._device.queue.submit([encoder.finish()])
        return self._warped or self._map

    def _visible(
        self, world_from_part: Float[np.ndarray, "parts 4 4"], eye: Float[np.ndarray, "3"], map_from_world: Rotation
    ) -> Bool[np.ndarray, "faces parts"]:
        """The parts that each face needs."""
        homogeneous = np.concatenate([self._spheres[:, :3], np.ones((len(self._spheres), 1))], 1)
        centre = (np.einsum("pij,pj->pi", world_from_part, homogeneous)[:, :3] - eye) @ map_from_world.T
        reach = reach_into_paraboloids if self._onto_paraboloid else reach_into_cube
        return reach(centre, self._spheres[:, 3]) & self._drawn
