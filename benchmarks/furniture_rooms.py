"""Two scenes to judge shells of distant light by: a room with furniture near the object, a place half open to the sky.

In both the built-in teapot stands on y = 0 in the origin; sizes are in metres. `furniture_room` looks best from azimuth
-50 (the shelf behind the teapot) and shows its shelf in the mirror from azimuth 10, at elevation 22; at a distance of
1.25 cameras stand clear of furniture at azimuths from -210 to 40. `half_open` looks best from azimuth 30, elevation 12:
wall, horizon and sky in the mirror; there cameras stand clear all around.
"""

import numpy as np
from jaxtyping import Float32

from reflet.scene.assemble import assemble
from reflet.scene.builtin import room_pictures as pictures
from reflet.scene.builtin.furnisher import Furnisher, emitter
from reflet.scene.builtin.newell import PARTS
from reflet.scene.builtin.solids import box, cylinder, quad, sphere
from reflet.scene.builtin.teapot import teapot_mesh
from reflet.scene.material import MIRROR, EnvironmentLight
from reflet.scene.scene import Part, Scene

HALF, FLOOR, CEILING = 2.5, -0.75, 2.25  # of the room: 5 × 3 × 5
LAMP_RADIANCE = (14.0, 13.5, 12.6)
SHELF_FRONT, SHELF_DEPTH = -0.70, 0.30  # z: half a metre behind the teapot's belly
SUN_TOWARDS = (0.55, 0.60, 0.58)
SUN_RADIANCE, SUN_DEG = 60.0, 5.0  # at its middle, and where it has fallen to exp(-1/2): half floats hold it


def furniture_room(subdivisions: int = 25) -> Scene:
    """A closed room with a lamp at the ceiling; a table, and near it a shelf full of boxes and a chair.

    Parts ``body lid handle spout`` reflect with F0 = 0.65; ``room`` and ``lamp`` are diffuse. ``subdivisions`` are
    those of `teapot_mesh`.
    """
    room = Furnisher()
    _shell(room)
    _table(room)
    _shelf(room)
    _chair(room, 0.05, 0.92)
    lamp = quad((-0.8, CEILING - 0.04, 0.7), (1.6, 0, 0), (0, 0, -1.4), 0)
    return assemble([room.part("room"), emitter("lamp", lamp, LAMP_RADIANCE), *_teapot(subdivisions)])


def half_open(subdivisions: int = 25) -> Scene:
    """A paved floor of 12 × 12 and one wall on it, under a sky: the teapot stands on a plinth before the wall.

    Parts ``body lid handle spout`` reflect with F0 = 0.65; ``yard`` is diffuse. Beyond the floor there is nothing but
    the sky's picture, whose lower half is a dull meadow.
    """
    yard = Furnisher()
    paving = yard.tile(pictures.checks(720, 720, 24, 24, (0.80, 0.76, 0.68), (0.48, 0.44, 0.42)))
    bricks = yard.tile(pictures.planks(256, 640, 26, (0.72, 0.40, 0.30), 61))
    coping = yard.tile(pictures.plain((0.78, 0.76, 0.72)))
    marble = yard.tile(pictures.checks(128, 96, 8, 6, (0.90, 0.89, 0.86), (0.70, 0.70, 0.72)))
    poster = yard.tile(pictures.framed(pictures.rings(210, 280, 3, 4, 3)))
    ball = yard.tile(pictures.beach_ball(128, 256))
    yard.add(
        quad((-6.0, FLOOR, -6.0), (12.0, 0, 0), (0, 0, 12.0), paving),
        box((0.0, FLOOR + 1.2, -1.4), (5.0, 2.4, 0.2), bricks),
        box((0.0, FLOOR + 2.44, -1.4), (5.1, 0.08, 0.3), coping),
        quad((-1.2, 1.05, -1.28), (1.0, 0, 0), (0, -0.75, 0), poster),
        box((0.0, FLOOR / 2.0, 0.0), (0.76, -FLOOR, 0.5), marble),
        sphere((0.85, FLOOR + 0.3, -0.75), 0.3, ball),
    )
    return assemble([yard.part("yard"), *_teapot(subdivisions)], environment=EnvironmentLight(sky()))


def sky(height: int = 128) -> Float32[np.ndarray, "height width 3"]:
    """A clear sky in lat-long: blue above, pale at the horizon, a soft sun; a dull ground below. At most some 60."""
    theta = (np.arange(height) + 0.5) / height * np.pi
    phi = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2.0 * np.pi
    up = np.cos(theta)[:, None]
    d = np.stack([np.sin(theta)[:, None] * np.cos(phi), up + 0.0 * phi, np.sin(theta)[:, None] * np.sin(phi)], -1)
    towards = np.array(SUN_TOWARDS) / np.linalg.norm(SUN_TOWARDS)
    angle = np.degrees(np.arccos(np.clip(d @ towards, -1.0, 1.0)))[..., None]
    share = np.clip(up, 0.0, 1.0)[..., None] ** 0.5
    above = (1.0 - share) * (0.95, 0.92, 0.85) + share * (0.16, 0.33, 0.75)
    clouds = 0.5 + 0.5 * np.sin(7.0 * d[..., :1] + 3.0 * np.sin(5.0 * d[..., 2:])) * np.sin(9.0 * d[..., 2:])
    above = above + 1.2 * share * clouds**3
    sky = np.where(d[..., 1:2] > 0.0, above, (0.24, 0.27, 0.14))
    sun = SUN_RADIANCE * np.exp(-0.5 * (angle / SUN_DEG) ** 2) * np.array((1.0, 0.92, 0.78))
    return (sky + sun).astype(np.float32)


def _teapot(subdivisions: int) -> list[Part]:
    return [Part(name, teapot_mesh(name, subdivisions), MIRROR) for name in PARTS]


def _shell(room: Furnisher) -> None:
    h, high = HALF, CEILING - FLOOR
    walls = [
        room.tile(pictures.papered(360, 600, a, b, 24))
        for a, b in (
            ((0.20, 0.46, 0.49), (0.16, 0.41, 0.45)),
            ((0.74, 0.38, 0.28), (0.69, 0.33, 0.24)),
            ((0.86, 0.70, 0.42), (0.83, 0.66, 0.37)),
            ((0.56, 0.64, 0.46), (0.51, 0.60, 0.42)),
        )
    ]
    floor = room.tile(pictures.planks(512, 512, 22, (0.74, 0.55, 0.36), 11))
    ceiling = room.tile(pictures.plain((0.94, 0.94, 0.92)))
    room.add(
        quad((-h, CEILING, -h), (2 * h, 0, 0), (0, -high, 0), walls[0]),
        quad((h, CEILING, h), (-2 * h, 0, 0), (0, -high, 0), walls[1]),
        quad((h, CEILING, -h), (0, 0, 2 * h), (0, -high, 0), walls[2]),
        quad((-h, CEILING, h), (0, 0, -2 * h), (0, -high, 0), walls[3]),
        quad((-h, FLOOR, -h), (2 * h, 0, 0), (0, 0, 2 * h), floor),
        quad((-h, CEILING, h), (2 * h, 0, 0), (0, 0, -2 * h), ceiling),
    )
    landscape = room.tile(pictures.framed(pictures.landscape(220, 330)))
    grid = room.tile(pictures.framed(pictures.grid_painting(240, 240), (0.16, 0.13, 0.11)))
    wheel = room.tile(pictures.framed(pictures.color_wheel(220, 220), (0.30, 0.18, 0.10)))
    near = h - 0.02
    room.add(
        quad((1.9, 1.5, near), (-1.3, 0, 0), (0, -0.9, 0), landscape),
        quad((-0.4, 1.5, near), (-0.9, 0, 0), (0, -0.9, 0), wheel),
        quad((near, 1.6, -1.3), (0, 0, 1.0), (0, -1.0, 0), grid),
        quad((near, 1.5, 0.5), (0, 0, 1.3), (0, -0.9, 0), landscape),
        quad((-near, 1.5, 0.5), (0, 0, -1.0), (0, -1.0, 0), wheel),
    )


def _table(room: Furnisher) -> None:
    top = room.tile(pictures.wood(300, 500, (0.50, 0.30, 0.17), 41, rings=12.0))
    leg = room.tile(pictures.wood(64, 32, (0.40, 0.24, 0.14), 42))
    cloth = room.tile(pictures.checks(256, 256, 12, 12, (0.93, 0.91, 0.86), (0.66, 0.22, 0.20)))
    book = room.tile(pictures.book_cover(128, 180, (0.13, 0.28, 0.44)))
    pages = room.tile(pictures.stripes(32, 64, 1, [(0.90, 0.86, 0.76)]))
    lemon = room.tile(pictures.citrus(96, 192, (0.96, 0.84, 0.22), 52))
    lime = room.tile(pictures.citrus(96, 192, (0.50, 0.68, 0.20), 53))
    room.add(
        box((0.0, -0.03, 0.0), (1.6, 0.04, 0.96), top),
        box((0.0, -0.005, 0.0), (0.90, 0.01, 0.66), cloth),
        *(
            box((0.72 * i, (FLOOR - 0.05) / 2.0, 0.40 * k), (0.06, -0.05 - FLOOR, 0.06), leg)
            for i in (-1, 1)
            for k in (-1, 1)
        ),
        box((-0.58, 0.012, 0.26), (0.26, 0.044, 0.19), pages, book, turn_deg=24),
        sphere((0.50, 0.030, -0.33), 0.040, lemon, 32),
        sphere((0.56, 0.023, 0.30), 0.033, lime, 32),
    )


def _shelf(room: Furnisher) -> None:
    """Two uprights, a back and boards, open towards the table; on each board boxes of all sizes."""
    left, right, top = -0.95, 0.65, 0.62
    back = SHELF_FRONT - SHELF_DEPTH
    middle, depth, high = (SHELF_FRONT + back) / 2.0, SHELF_DEPTH, top - FLOOR
    board = room.tile(pictures.wood(64, 300, (0.62, 0.44, 0.26), 71, rings=4.0))
    upright = room.tile(pictures.wood(64, 300, (0.55, 0.38, 0.22), 72, rings=4.0))
    room.add(
        box((left + 0.015, FLOOR + high / 2.0, middle), (0.03, high, depth), upright),
        box((right - 0.015, FLOOR + high / 2.0, middle), (0.03, high, depth), upright),
        box((0.5 * (left + right), FLOOR + high / 2.0, back + 0.01), (right - left - 0.06, high, 0.02), board),
    )
    heights = (FLOOR + 0.05, -0.38, -0.04, 0.29, top - 0.015)  # of the boards' middles
    room.add(*(box((0.5 * (left + right), y, middle), (right - left - 0.06, 0.03, depth), board) for y in heights))
    palette = [(0.90, 0.34, 0.26), (0.95, 0.78, 0.18), (0.16, 0.48, 0.36), (0.18, 0.28, 0.60), (0.55, 0.24, 0.52)]
    pale = (0.95, 0.93, 0.88)
    wraps = [room.tile(pictures.checks(96, 96, 3 + k, 3 + k, color, pale)) for k, color in enumerate(palette)]
    random = np.random.default_rng(8)
    for number, y in enumerate(heights):
        x, room_above = left + 0.06, 0.26 if number < 4 else 0.22
        while True:
            wide, tall, deep = random.uniform((0.09, 0.10, 0.10), (0.20, room_above, 0.24))
            if x + wide > right - 0.06:
                break
            centre = (x + wide / 2.0, y + 0.015 + tall / 2.0, SHELF_FRONT - 0.03 - deep / 2.0)
            room.add(box(centre, (wide * 0.9, tall, deep), wraps[int(random.integers(len(wraps)))]))
            x += wide + random.uniform(0.02, 0.08)


def _chair(room: Furnisher, x: float, z: float) -> None:
    """Its seat towards the table, its back away from it."""
    beech = room.tile(pictures.wood(64, 128, (0.80, 0.62, 0.42), 81))
    cushion = room.tile(pictures.checks(96, 96, 6, 6, (0.20, 0.42, 0.62), (0.86, 0.86, 0.80)))
    seat = FLOOR + 0.45
    room.add(
        box((x, seat - 0.02, z), (0.42, 0.04, 0.42), beech),
        box((x, seat + 0.02, z), (0.38, 0.04, 0.38), cushion),
        *(
            box((x + 0.18 * i, (FLOOR + seat - 0.04) / 2.0, z + 0.18 * k), (0.04, 0.41, 0.04), beech)
            for i in (-1, 1)
            for k in (-1, 1)
        ),
        *(box((x + 0.18 * i, seat + 0.24, z + 0.19), (0.04, 0.48, 0.03), beech) for i in (-1, 1)),
        *(box((x, seat + 0.16 + 0.13 * k, z + 0.19), (0.33, 0.06, 0.02), beech) for k in range(3)),
    )
    vase = room.tile(pictures.stripes(64, 128, 12, [(0.86, 0.86, 0.84), (0.24, 0.40, 0.60)]))
    room.add(
        cylinder((1.75, FLOOR + 0.35, -1.75), 0.22, 0.70, vase, vase), sphere((-1.8, FLOOR + 0.3, 1.7), 0.3, cushion)
    )
