"""What an env map costs that is drawn anew for every frame, by all ways to one, beside one plain view.

    .venv/bin/python benchmarks/capture_time.py [ROWS]

Sixty moving solids of 25,200 triangles are captured by six views into a cube of ROWS² texels a face (128 by default),
by two views into a dual paraboloid, and by a warp of a cube into each other parameterization; all with mip levels, and
every view draws only the solids that reach into it. Sizes are powers of two, chosen so that the numbers of texels that
hold a direction come closest to the cube's; times are also given for as many texels. A *plain view* is the same scene
drawn through a camera of 75° into as many pixels as the cube has texels, all solids. Ways alternate and medians count,
so that a busy machine changes the ratios little.

Then the demands on a parameterization of [Heidrich00, sec. 2], in figures: cheap to look up (a frame of a mirror torus,
512² pixels, read back, beside the same with the hardware's cube sampler), good for all views (whether a walkthrough
needs it made anew), the same for all directions (the most texels a steradian over the fewest; and how many times the
texels of an even map it takes to resolve as much along every axis), cheap to make (a capture beside a plain view).
"""

import sys
import time
from collections.abc import Callable, Mapping

import numpy as np
import wgpu

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.sampling import analyze, valid_texels
from reflet.render.capture.capture import EnvironmentCapture
from reflet.render.capture.matte_scene import MatteScene
from reflet.render.device.device import adapter_name, shared_device
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture
from reflet.render.materials.env_map_renderer import EnvMapRenderer
from reflet.render.meshes.device_mesh import begin_pass
from reflet.render.meshes.views import Views, camera_view, view_layout
from reflet.scene.material import Material
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.sky_light import OVERCAST
from reflet.scene.views.camera import Camera

ROUNDS = 9
SOLIDS = 60
EYE = (0.0, 0.0, 0.0)


def solids() -> Scene:
    """Spheres and tori of 400 triangles each, all around."""
    random = np.random.default_rng(0)
    meshes = [
        sphere_mesh(0.5, around=22) if i % 2 else torus_mesh(0.4, 0.2, around=20, sides=10) for i in range(SOLIDS)
    ]
    colours = random.uniform(0.1, 0.9, (SOLIDS, 3))
    return Scene(
        tuple(
            Part(str(i), mesh, Material(base_color=(r, g, b), metallic=0.0))
            for i, (mesh, (r, g, b)) in enumerate(zip(meshes, colours, strict=True))
        ),
        (),
    )


def places(frame: int) -> np.ndarray:
    """Rigid transforms: every solid on an orbit of its own, 2 to 5 m away."""
    random = np.random.default_rng(1)
    direction = random.normal(size=(SOLIDS, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    angle = 0.05 * frame
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    out = np.tile(np.eye(4), (SOLIDS, 1, 1))
    out[:, :3, 3] = random.uniform(2.0, 5.0, (SOLIDS, 1)) * direction @ turn.T
    return out


class PlainView:
    """The scene through a camera, into half floats."""

    def __init__(self, device: wgpu.GPUDevice, scene: Scene, width: int, height: int) -> None:
        self._device, self._parts = device, range(len(scene.parts))
        self._camera = Camera(EYE, (0.0, 0.0, -1.0), fov_deg=75, width=width, height=height)
        layout = view_layout(device)
        self._matte = MatteScene(device, scene, OVERCAST, layout)
        self._views = Views(device, layout, 1, len(scene.parts))
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT
        size = (width, height, 1)
        self.texture = device.create_texture(size=size, format=HALF, usage=usage | wgpu.TextureUsage.COPY_SRC)
        self._depth = device.create_texture(size=size, format="depth32float", usage=usage).create_view()

    def frame(self, world_from_part: np.ndarray) -> None:
        """Draws it."""
        self._views.write([camera_view(self._camera)], world_from_part)
        encoder = self._device.create_command_encoder()
        render_pass = begin_pass(encoder, self.texture.create_view(), self._depth)
        render_pass.set_bind_group(0, self._views.groups[0])
        self._matte.draw(render_pass, self._parts, HALF)
        render_pass.end()
        self._device.queue.submit([encoder.finish()])


def wait_for(device: wgpu.GPUDevice, texture: wgpu.GPUTexture) -> None:
    """Until all that was drawn into a texture is there."""
    device.queue.read_texture({"texture": texture}, {"bytes_per_row": 256, "rows_per_image": 1}, (1, 1, 1))


def draw_once(renderer: EnvMapRenderer, env_map: EnvMapTexture, camera: Camera) -> None:
    """A frame of the mirror."""
    renderer.picture(env_map, camera, samples=1, backdrop=False)


def median_times(ways: Mapping[str, Callable[[int], None]]) -> dict[str, float]:
    """Milliseconds a frame."""
    times = np.empty((ROUNDS + 1, len(ways)))
    for i in range(len(times)):
        for j, draw in enumerate(ways.values()):
            start = time.perf_counter()
            draw(i)
            times[i, j] = 1000.0 * (time.perf_counter() - start)
    return dict(zip(ways, np.median(times[1:], 0).tolist(), strict=True))  # the first frames build pipelines


def main() -> None:
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 128
    device, scene = shared_device(), solids()
    texels = 6 * rows * rows
    ways = {"cube": (CUBE, rows), "dual_paraboloid": (DualParaboloid(), 0)}
    ways |= {f"cube, warped: {kind}": (kind, 0) for kind in PARAMETERIZATIONS.values() if kind != CUBE}
    ways = {
        name: (kind, size or equal_sampling_size(kind, texels, power_of_two=True))
        for name, (kind, size) in ways.items()
    }
    captures = {
        name: EnvironmentCapture(device, scene, size, name, None)
        if name in ("cube", "dual_paraboloid")
        else EnvironmentCapture(device, scene, size, "warp", kind)
        for name, (kind, size) in ways.items()
    }
    plain = PlainView(device, scene, 3 * rows, 2 * rows)

    def plainly(i: int) -> None:
        plain.frame(places(i))
        wait_for(device, plain.texture)

    def captured(name: str) -> Callable[[int], None]:
        return lambda i: wait_for(device, captures[name].frame(places(i), EYE).texture)

    times = median_times({"plain view": plainly, **{name: captured(name) for name in captures}})
    base = times["plain view"]
    print(f"{adapter_name(device)}\n{sum(len(part.mesh.triangles) for part in scene.parts):,} triangles\n")
    print(f"{'':36s}{'rows':>6s}{'texels':>9s}{'ms':>8s}{'plain views':>13s}{'for as many texels':>20s}")
    print(f"{'plain view':36s}{'':6s}{texels:9,d}{base:8.1f}{1.0:13.2f}{1.0:20.2f}")
    for name, (kind, size) in ways.items():
        seen, ratio = round(valid_texels(kind) * size * size), times[name] / base
        print(f"{name:36s}{size:6d}{seen:9,d}{times[name]:8.1f}{ratio:13.2f}{ratio * texels / seen:20.2f}")

    renderer = EnvMapRenderer(torus_mesh())
    camera = Camera((1.0, 1.2, 2.0), (0.0, 0.0, 0.0))
    maps = {name: captures[name].frame(places(0), EYE) for name in ways}

    def mirrored(name: str) -> Callable[[int], None]:
        return lambda i: draw_once(renderer, maps[name], camera)

    lookups = median_times({name: mirrored(name) for name in ways if name != "dual_paraboloid"})
    print(f"\n{'':24s}{'lookup':>8s}{'walkthrough':>14s}{'rates':>10s}{'cost':>10s}{'making':>10s}")
    for name, ratio in lookups.items():
        kind = ways[name][0]
        rates = analyze(kind)
        anew = "made anew" if kind.is_view_dependent else "one map"
        made = times["dual_paraboloid" if kind == DualParaboloid() else name] / base
        figures = f"{rates.area_ratio:10.1f}{rates.cost:10.1f}{made:10.2f}"
        print(f"{kind!s:24s}{ratio / lookups['cube']:8.2f}{anew:>14s}{figures}")


if __name__ == "__main__":
    main()
