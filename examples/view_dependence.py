"""Where the maps of the nineties show how they are made, and how they hide it.

Run it with the folder to write to::

    python examples/view_dependence.py out/view_dependence

``sphere_map.png``: a sphere map (gazing ball) looked at from the viewpoint it was made for; from 60° aside, where its
singularity comes into the picture; and from there again, warped anew for that view, on the device, as
[Heidrich00, sec. 2.1] asks for every change of the viewpoint. Left and right must be clean; in the middle the wall -Z,
which is the map's whole rim, is smeared beyond reading.

``paraboloid.png``: a dual paraboloid drawn in two passes with texture matrices and the alpha test, without the ring of
valid texels around the discs: pink shows through where neither half draws; with a ring of two texels: nothing shows;
and by today's single lookup, which must look the same. Below, the middle of the border enlarged.
"""

import sys
from pathlib import Path

import numpy as np
import wgpu

from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.gazing_ball import GazingBall
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.files.pictures.png import write_png
from reflet.render.device.device import shared_device
from reflet.render.maps.env_map_texture import HALF, create_env_map, upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer, render_mirror, view_frame
from reflet.render.materials.paraboloid_two_pass import ParaboloidRenderer
from reflet.render.meshes.warp import Warp
from reflet.report.measures import picture_srgb
from reflet.scene.builtin.labelled_court import labelled_court
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

PINK = (1.0, 0.0, 0.6, 0.0)


def sphere_map(size: int, picture: int) -> np.ndarray:
    """From its own viewpoint, from aside, and made anew."""
    device = shared_device()
    turns = [np.radians(azimuth) for azimuth in (0.0, 60.0)]
    own, aside = (
        Camera(
            (3.2 * np.sin(turn), 0.4, 3.2 * np.cos(turn)), (0.0, 0.0, 0.0), fov_deg=42, width=picture, height=picture
        )
        for turn in turns
    )
    cube = upload_env_map(device, mip_images(labelled_court(size)))
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.STORAGE_BINDING
    ball = create_env_map(device, GazingBall(), 2 * size, (2 * size).bit_length(), HALF, usage)
    warp, renderer = Warp(device, ball), EnvMapRenderer(sphere_mesh(around=256))

    def seen(camera: Camera, made_for: Camera) -> np.ndarray:
        turn = view_frame(made_for)
        encoder = device.create_command_encoder()
        warp.draw(encoder, cube, turn.T)
        device.queue.submit([encoder.finish()])
        return renderer.picture(ball, camera, frame=turn, backdrop=False)

    return picture_srgb(np.concatenate([seen(own, own), seen(aside, own), seen(aside, aside)], 1)[..., :3])


def paraboloid(size: int, picture: int) -> np.ndarray:
    """Two passes without a ring and with one, and the single lookup; the border enlarged."""
    levels = mip_images(resample(labelled_court(2 * size), DualParaboloid(), size))
    camera = Camera((3.2, 0.4, 1.0), (0.0, 0.0, 0.0), fov_deg=42, width=picture, height=picture)
    sphere = sphere_mesh(around=256)
    bare, ringed = (ParaboloidRenderer(sphere, levels, ring=ring).picture(camera) for ring in (0.0, 2.0))
    single = render_mirror(sphere, levels, camera, samples=1)
    covered = single[..., 3] == 1.0
    for each in (bare, ringed):
        each[covered & (each[..., 3] == 0.0)] = PINK
    single[~covered] = 0.0
    whole = np.concatenate([bare, ringed, single], 1)
    eighth, middle = picture // 8, picture // 2
    crops = [each[middle - eighth : middle + eighth, middle : middle + 2 * eighth] for each in (bare, ringed, single)]
    enlarged = np.concatenate([crop.repeat(4, 0).repeat(4, 1) for crop in crops], 1)
    return picture_srgb(np.concatenate([whole[:, : enlarged.shape[1]], enlarged])[..., :3])


def main(out: Path, size: int = 256, picture: int = 384) -> None:
    """Writes the two pictures; maps have ``size`` rows or twice as many."""
    out.mkdir(parents=True, exist_ok=True)
    write_png(out / "sphere_map.png", sphere_map(size, picture))
    write_png(out / "paraboloid.png", paraboloid(size // 2, picture))
    print(f"Look at sphere_map.png and paraboloid.png in {out}.")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
