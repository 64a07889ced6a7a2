"""The built-in scene ``teapot-room``: Newell's teapot, chromed, on a table in a furnished room.

The room is one mesh with one texture. Everything follows from formulas, so the scene is the same on every machine.
"""

from reflet.scene.assemble import assemble
from reflet.scene.builtin import room_pictures as pictures
from reflet.scene.builtin.furnisher import Furnisher, emitter
from reflet.scene.builtin.newell import PARTS
from reflet.scene.builtin.solids import Solid, box, cone, cylinder, join, quad, sphere
from reflet.scene.builtin.teapot import teapot_mesh
from reflet.scene.material import MIRROR
from reflet.scene.scene import Part, Scene

HALF_WIDTH, HALF_DEPTH, FLOOR, CEILING = 2.6, 2.2, -0.75, 2.05
LAMP_RADIANCE = (9.0, 8.7, 8.1)
WINDOW_RADIANCE = (4.2, 4.8, 5.6)


def teapot_room() -> Scene:
    """The scene, assembled: parts ``body lid handle spout`` reflect with F0 = 0.65, ``room lamp window`` are diffuse.

    The table cloth lies at y = 0 and the teapot, 0.315 m high, stands in the origin.
    """
    parts = [_room(), emitter("lamp", _lamp(), LAMP_RADIANCE), emitter("window", _panes(), WINDOW_RADIANCE)]
    return assemble([*parts, *(Part(name, teapot_mesh(name), MIRROR) for name in PARTS)])


def _lamp() -> Solid:
    return quad((-0.9, CEILING - 0.04, 0.6), (1.8, 0, 0), (0, 0, -1.2), 0)


def _panes() -> Solid:
    """Two by three panes in the wall at +x; the bars between them belong to the room."""
    panes = [
        quad((HALF_WIDTH - 0.01, 1.52 - 0.42 * row, 0.50 + 0.46 * column), (0, 0, 0.42), (0, -0.38, 0), 0)
        for row in range(3)
        for column in range(2)
    ]
    return join(panes)


def _room() -> Part:
    room = Furnisher()
    _shell(room)
    _wall_pictures(room)
    _furniture(room)
    _table(room)
    return room.part("room")


def _shell(room: Furnisher) -> None:
    x, z, height = HALF_WIDTH, HALF_DEPTH, CEILING - FLOOR
    wide, deep = 640, 540  # texels along the walls: about 8 mm each
    high = 344
    terracotta = room.tile(pictures.papered(high, wide, (0.74, 0.38, 0.28), (0.69, 0.33, 0.24), 26))
    teal = room.tile(pictures.papered(high, wide, (0.20, 0.46, 0.49), (0.16, 0.41, 0.45), 26))
    ochre = room.tile(pictures.papered(high, deep, (0.86, 0.70, 0.42), (0.83, 0.66, 0.37), 22))
    sage = room.tile(pictures.papered(high, deep, (0.56, 0.64, 0.46), (0.51, 0.60, 0.42), 22))
    floor = room.tile(pictures.planks(512, 640, 22, (0.76, 0.56, 0.36), 11))
    ceiling = room.tile(pictures.plain((0.95, 0.95, 0.93)))
    room.add(
        quad((-x, CEILING, -z), (2 * x, 0, 0), (0, -height, 0), teal),  # looks towards +z
        quad((x, CEILING, z), (-2 * x, 0, 0), (0, -height, 0), terracotta),
        quad((x, CEILING, -z), (0, 0, 2 * z), (0, -height, 0), ochre),
        quad((-x, CEILING, z), (0, 0, -2 * z), (0, -height, 0), sage),
        quad((-x, FLOOR, -z), (2 * x, 0, 0), (0, 0, 2 * z), floor),
        quad((-x, CEILING, z), (2 * x, 0, 0), (0, 0, -2 * z), ceiling),
    )
    brass = room.tile(pictures.plain((0.80, 0.64, 0.32)))
    for side in (-1, 1):  # the lamp's rim
        room.add(
            box((0, CEILING - 0.026, 0.625 * side), (1.9, 0.05, 0.05), brass),
            box((0.925 * side, CEILING - 0.026, 0), (0.05, 0.05, 1.2), brass),
        )
    rug = room.tile(pictures.rug(400, 520))
    room.add(quad((-1.5, FLOOR + 0.01, -1.15), (3.0, 0, 0), (0, 0, 2.3), rug))


def _wall_pictures(room: Furnisher) -> None:
    x, z = HALF_WIDTH - 0.02, HALF_DEPTH - 0.02
    paintings = {
        "rings": room.tile(pictures.framed(pictures.rings(210, 280, 3, 4, 3))),
        "grid": room.tile(pictures.framed(pictures.grid_painting(240, 240), (0.16, 0.13, 0.11))),
        "landscape": room.tile(pictures.framed(pictures.landscape(220, 330))),
        "wheel": room.tile(pictures.framed(pictures.color_wheel(220, 220), (0.30, 0.18, 0.10))),
        "slanted": room.tile(
            pictures.framed(
                pictures.stripes(230, 170, 9, [(0.12, 0.22, 0.40), (0.94, 0.86, 0.66), (0.84, 0.30, 0.20)], 0.8)
            )
        ),
    }
    teal_wall = (("slanted", -1.75, 0.46, 0.60), ("rings", -0.72, 0.82, 0.66), ("wheel", 0.42, 0.62, 0.62),
                 ("landscape", 1.62, 0.92, 0.66))  # fmt: skip
    for name, centre, wide, high in teal_wall:
        room.add(quad((centre - wide / 2, 1.02 + high / 2, -z), (wide, 0, 0), (0, -high, 0), paintings[name]))
    terracotta_wall = (("landscape", -1.30, 1.05, 0.74), ("grid", 0.10, 0.66, 0.66), ("slanted", 1.20, 0.48, 0.62))
    for name, centre, wide, high in terracotta_wall:
        room.add(quad((centre + wide / 2, 1.02 + high / 2, z), (-wide, 0, 0), (0, -high, 0), paintings[name]))
    room.add(quad((x, 1.40, -1.55), (0, 0, 0.80), (0, -0.64, 0), paintings["rings"]))
    room.add(quad((-x, 1.38, -0.75), (0, 0, -0.62), (0, -0.62, 0), paintings["wheel"]))
    white = room.tile(pictures.plain((0.92, 0.91, 0.87)))
    frame_x = HALF_WIDTH - 0.03
    for row in range(4):  # the window's bars: across, then upright
        room.add(box((frame_x, 1.54 - 0.42 * row, 0.94), (0.05, 0.045, 0.98), white))
    for column in range(3):
        room.add(box((frame_x, 0.91, 0.48 + 0.46 * column), (0.05, 1.30, 0.045), white))
    curtain = room.tile(pictures.stripes(64, 128, 8, [(0.62, 0.16, 0.17), (0.72, 0.22, 0.21), (0.54, 0.12, 0.14)]))
    for centre in (0.30, 1.58):
        room.add(box((frame_x - 0.03, 0.72, centre), (0.10, 2.0, 0.22), curtain))


def _furniture(room: Furnisher) -> None:
    case = room.tile(pictures.wood(128, 64, (0.42, 0.27, 0.15), 21))
    shelves = room.tile(pictures.books(400, 340, 5, 4))
    depth = 0.32
    room.add(
        box((-HALF_WIDTH + depth / 2, FLOOR + 0.95, 0.75), (depth, 1.9, 1.5), case),
        quad((-HALF_WIDTH + depth + 0.004, FLOOR + 1.88, 1.47), (0, 0, -1.44), (0, -1.86, 0), shelves),
    )
    yellow = room.tile(pictures.checks(96, 96, 4, 4, (0.95, 0.78, 0.18), (0.18, 0.28, 0.60)))
    coral = room.tile(pictures.checks(96, 96, 3, 3, (0.90, 0.34, 0.26), (0.96, 0.94, 0.89)))
    green = room.tile(pictures.checks(96, 96, 5, 5, (0.16, 0.48, 0.36), (0.86, 0.82, 0.52)))
    ball = room.tile(pictures.beach_ball(128, 256))
    marble = room.tile(pictures.plain((0.88, 0.87, 0.84)))
    navy = room.tile(pictures.citrus(96, 192, (0.16, 0.26, 0.52), 31))
    room.add(
        box((2.02, FLOOR + 0.30, -1.62), (0.60, 0.60, 0.60), yellow, turn_deg=18),
        box((1.98, FLOOR + 0.80, -1.66), (0.40, 0.40, 0.40), coral, turn_deg=-22),
        sphere((1.98, FLOOR + 1.16, -1.66), 0.16, navy),
        sphere((-1.85, FLOOR + 0.34, -1.45), 0.34, ball),
        box((0.35, FLOOR + 0.22, -1.85), (0.90, 0.44, 0.46), green),
        cylinder((2.10, FLOOR + 0.45, -0.35), 0.17, 0.90, marble, marble),
        cone((2.10, FLOOR + 0.90, -0.35), 0.15, 0.42, coral),
        cylinder((-0.85, FLOOR + 0.40, 1.85), 0.20, 0.80, marble, marble),
        sphere((-0.85, FLOOR + 1.02, 1.85), 0.22, yellow),
        box((1.0, FLOOR + 0.28, 1.80), (1.1, 0.56, 0.55), coral),
    )


def _table(room: Furnisher) -> None:
    top = room.tile(pictures.wood(400, 400, (0.50, 0.30, 0.17), 41, rings=16.0))
    rim = room.tile(pictures.wood(16, 512, (0.40, 0.23, 0.12), 42, rings=2.0))
    leg = room.tile(pictures.plain((0.26, 0.16, 0.10)))
    cloth = room.tile(pictures.checks(256, 256, 12, 12, (0.93, 0.91, 0.86), (0.24, 0.40, 0.60)))
    orange = room.tile(pictures.citrus(96, 192, (0.95, 0.53, 0.12), 51))
    lemon = room.tile(pictures.citrus(96, 192, (0.96, 0.84, 0.22), 52))
    lime = room.tile(pictures.citrus(96, 192, (0.50, 0.68, 0.20), 53))
    red_book = room.tile(pictures.book_cover(128, 180, (0.58, 0.13, 0.14)))
    blue_book = room.tile(pictures.book_cover(128, 180, (0.13, 0.28, 0.44)))
    pages = room.tile(pictures.stripes(32, 64, 1, [(0.90, 0.86, 0.76)]))
    room.add(
        cylinder((0, -0.026, 0), 0.86, 0.04, rim, top, around=96),
        cylinder((0, -0.38, 0), 0.07, 0.68, leg, leg, around=32),
        cylinder((0, FLOOR + 0.02, 0), 0.34, 0.04, leg, leg),
        box((0, -0.003, 0), (0.84, 0.006, 0.84), cloth, turn_deg=14),
        sphere((0.52, 0.034, -0.40), 0.040, orange, 32),
        sphere((0.44, 0.030, -0.47), 0.036, lemon, 32),
        sphere((0.54, 0.027, -0.31), 0.033, lime, 32),
        box((-0.56, 0.016, 0.36), (0.26, 0.044, 0.19), pages, blue_book, turn_deg=28),
        box((-0.56, 0.056, 0.36), (0.22, 0.036, 0.16), pages, red_book, turn_deg=8),
    )
