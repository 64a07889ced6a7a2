"""The pictures that the built-in room is papered with: drawn by formula, the same on every machine.

All are sRGB in [0, 1], (height, width, 3); coordinates x to the right and y down run over [0, 1].
"""

import numpy as np
from jaxtyping import Float

Picture = Float[np.ndarray, "height width 3"]
Color = tuple[float, float, float]


def _grid(height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    y, x = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    return x, y


def plain(color: Color, height: int = 16, width: int = 16) -> Picture:
    """One colour."""
    return np.broadcast_to(np.array(color), (height, width, 3)).copy()


def _choose(mask: np.ndarray, a: Picture | Color, b: Picture | Color) -> Picture:
    """``a`` where the mask is 1, ``b`` where it is 0, mixed between."""
    return np.asarray(b) + (np.asarray(a) - np.asarray(b)) * np.clip(mask, 0.0, 1.0)[..., None]


def _noise(height: int, width: int, cells_y: int, cells_x: int, seed: int, octaves: int = 4) -> np.ndarray:
    """Smooth noise about 0, each octave twice as fine and half as strong, between about -1 and 1."""
    random = np.random.default_rng(seed)
    total = np.zeros((height, width))
    for octave in range(octaves):
        rows, columns = min(cells_y << octave, height), min(cells_x << octave, width)
        lattice = random.random((rows + 1, columns + 1)) * 2.0 - 1.0
        total += _stretched(_stretched(lattice, height).T, width).T / 2**octave
    return total / 2.0


def _stretched(lattice: np.ndarray, size: int) -> np.ndarray:
    """The rows of a lattice blended smoothly into ``size`` rows."""
    at = (np.arange(size) + 0.5) / size * (len(lattice) - 1)
    low = at.astype(int)
    t = (at - low)[:, None]
    return lattice[low] + (lattice[low + 1] - lattice[low]) * (t * t * (3.0 - 2.0 * t))


def checks(height: int, width: int, rows: int, columns: int, a: Color, b: Color) -> Picture:
    """A chessboard."""
    x, y = _grid(height, width)
    return _choose((np.floor(x * columns) + np.floor(y * rows)) % 2, a, b)


def stripes(height: int, width: int, count: int, colors: list[Color], slant: float = 0.0) -> Picture:
    """``count`` stripes, upright or slanting, in turn in all the colours."""
    x, y = _grid(height, width)
    index = np.floor((x + slant * y) * count).astype(int) % len(colors)
    return np.array(colors)[index]


def wood(height: int, width: int, color: Color, seed: int, rings: float = 9.0) -> Picture:
    """Grain along x."""
    _, y = _grid(height, width)
    bent = y * rings + 1.2 * _noise(height, width, 3, 2, seed, 3)
    fibre = _noise(height, width, 48, 4, seed + 1, 3)
    grain = 0.5 + 0.5 * np.sin(2.0 * np.pi * bent)
    return np.clip(np.array(color) * (0.78 + 0.26 * grain + 0.16 * fibre)[..., None], 0.0, 1.0)


def planks(height: int, width: int, rows: int, color: Color, seed: int) -> Picture:
    """Floor boards along x, each of its own shade, with dark joints."""
    random = np.random.default_rng(seed)
    x, y = _grid(height, width)
    row = np.floor(y * rows).astype(int)
    shifted = x * 3.0 + random.random(rows)[row]
    board = np.floor(shifted).astype(int)
    shade = 0.8 + 0.3 * random.random((rows, 5))[row, board]
    joint = np.minimum(np.minimum(y * rows % 1.0, 1.0 - y * rows % 1.0) * 6.0, np.minimum(shifted % 1.0, 0.5) * 60.0)
    picture = wood(height, width, color, seed + 7, rings=float(rows) * 1.5) * shade[..., None]
    return np.clip(picture * (0.45 + 0.55 * np.clip(joint, 0.0, 1.0))[..., None], 0.0, 1.0)


def papered(height: int, width: int, a: Color, b: Color, count: int) -> Picture:
    """A wall: striped paper above a white wainscot with panels and a rail."""
    x, y = _grid(height, width)
    stripe = np.abs((x * count) % 1.0 - 0.5) < 0.24
    motif = (np.abs((x * count) % 1.0 - 0.5) + np.abs((y * count * height / width) % 1.0 - 0.5)) < 0.13
    wall = _choose(stripe.astype(float), a, b)
    wall = _choose(motif.astype(float) * 0.55, (0.96, 0.90, 0.74), wall)
    wall *= (1.0 + 0.05 * _noise(height, width, 6, 10, 5))[..., None]
    panel_x, panel_y = (x * 9.0) % 1.0, (y - 0.70) / 0.27
    inside = (np.abs(panel_x - 0.5) < 0.40) & (np.abs(panel_y - 0.52) < 0.36)
    bevel = (np.abs(panel_x - 0.5) < 0.37) & (np.abs(panel_y - 0.52) < 0.31)
    wainscot = _choose(inside & ~bevel, (0.66, 0.63, 0.57), plain((0.90, 0.88, 0.83), height, width))
    wainscot = _choose(bevel.astype(float), (0.86, 0.84, 0.79), wainscot)
    rail = np.abs(y - 0.68) < 0.014
    skirting = y > 0.965
    wall = _choose((y > 0.68).astype(float), wainscot, wall)
    wall = _choose(rail.astype(float), (0.55, 0.36, 0.20), wall)
    wall = _choose(skirting.astype(float), (0.42, 0.27, 0.15), wall)
    cornice = _choose(((y * 90.0) % 2.0 < 1.0).astype(float), (0.97, 0.95, 0.90), (0.82, 0.79, 0.72))
    return np.clip(_choose((y < 0.045).astype(float), cornice, wall), 0.0, 1.0)


def framed(
    picture: Picture, frame: Color = (0.62, 0.45, 0.16), border: int = 10
) -> Float[np.ndarray, "framed_height framed_width 3"]:
    """A picture in a frame with a white mount, twice ``border`` texels larger on every side."""
    mount = np.pad(picture, ((border, border), (border, border), (0, 0)), constant_values=0.95)
    b = border
    out = np.empty((mount.shape[0] + 2 * b, mount.shape[1] + 2 * b, 3))
    out[:] = frame
    out[2:-2, 2:-2] = np.clip(np.array(frame) * 1.35, 0.0, 1.0)
    out[b - 3 : -(b - 3), b - 3 : -(b - 3)] = np.array(frame) * 0.55
    out[b:-b, b:-b] = mount
    return out


def rings(height: int, width: int, rows: int, columns: int, seed: int) -> Picture:
    """Squares with concentric circles, after Kandinsky."""
    random = np.random.default_rng(seed)
    x, y = _grid(height, width)
    i, j = np.floor(y * rows).astype(int), np.floor(x * columns).astype(int)
    palette = np.array([(0.93, 0.76, 0.20), (0.85, 0.22, 0.16), (0.13, 0.30, 0.60), (0.95, 0.92, 0.84),
                        (0.20, 0.55, 0.48), (0.92, 0.52, 0.16), (0.36, 0.18, 0.42), (0.10, 0.12, 0.18)])  # fmt: skip
    radius = np.hypot((x * columns) % 1.0 - 0.5, (y * rows) % 1.0 - 0.5)
    ring = np.minimum((radius * 9.5).astype(int), 5)
    choice = np.argsort(random.random((rows, columns, len(palette))), axis=-1)
    return palette[choice[i, j, ring]]


def grid_painting(height: int, width: int) -> Picture:
    """Rectangles in primary colours between black lines, after Mondrian."""
    x, y = _grid(height, width)
    out = plain((0.95, 0.94, 0.90), height, width)
    fields: list[tuple[float, float, float, float, Color]] = [
        (0.28, 0.0, 1.0, 0.66, (0.84, 0.13, 0.10)), (0.0, 0.66, 0.28, 1.0, (0.10, 0.22, 0.60)),
        (0.88, 0.83, 1.0, 1.0, (0.96, 0.80, 0.12)), (0.0, 0.0, 0.28, 0.30, (0.95, 0.94, 0.90)),
    ]  # fmt: skip
    for left, top, right, bottom, color in fields:
        out = _choose(((x > left) & (x < right) & (y > top) & (y < bottom)).astype(float), color, out)
    lines = (np.abs(x - 0.28) < 0.018) | (np.abs(y - 0.66) < 0.018)
    lines |= (np.abs(y - 0.30) < 0.018) & (x < 0.28)
    lines |= (np.abs(x - 0.88) < 0.018) & (y > 0.66)
    lines |= (np.abs(y - 0.83) < 0.018) & (x > 0.88)
    return _choose(lines.astype(float), (0.05, 0.05, 0.06), out)


def landscape(height: int, width: int) -> Picture:
    """A sun over three ridges and their lake."""
    x, y = _grid(height, width)
    sky = _choose(np.clip(y * 1.7, 0.0, 1.0), (0.98, 0.72, 0.36), (0.20, 0.28, 0.55))
    sun = np.hypot((x - 0.66) * width / height, y - 0.40)
    sky = _choose(np.clip(1.2 - 3.0 * sun, 0.0, 0.7), (1.0, 0.90, 0.60), sky)
    sky = _choose((sun < 0.085).astype(float), (1.0, 0.97, 0.85), sky)
    for level, height_of, color in ((0.52, 0.10, (0.52, 0.36, 0.50)), (0.60, 0.09, (0.30, 0.24, 0.42)),
                                    (0.68, 0.07, (0.13, 0.14, 0.28))):  # fmt: skip
        wave = np.sin(9.0 * x + 20.0 * level) + 0.5 * np.sin(23.0 * x + 31.0 * level)
        sky = _choose((y > level - height_of * 0.6 * wave).astype(float), color, sky)
    glitter = np.exp(-(((x - 0.66) / np.maximum(0.05 + 0.5 * (y - 0.75), 0.05)) ** 2))
    ripple = glitter * (0.5 + 0.5 * np.sin(220.0 * y))
    lake = _choose(ripple, (0.92, 0.62, 0.40), (0.12, 0.16, 0.32))
    return np.clip(_choose((y > 0.76).astype(float), lake, sky), 0.0, 1.0)


def color_wheel(height: int, width: int) -> Picture:
    """Twelve hues in three rings on dark ground."""
    x, y = _grid(height, width)
    dx, dy = (x - 0.5) * width / height, y - 0.5
    radius, angle = np.hypot(dx, dy), np.arctan2(dy, dx)
    hue = np.floor((angle / (2.0 * np.pi) + 0.5) * 12.0) / 12.0
    k = (hue[..., None] * 6.0 + np.array([0.0, 4.0, 2.0])) % 6.0
    color = np.clip(np.abs(k - 3.0) - 1.0, 0.0, 1.0)
    level = np.floor(radius * 8.0)
    color = 0.92 * color * (0.45 + 0.2 * level[..., None]).clip(0.0, 1.0) + 0.06
    return _choose(((radius > 0.08) & (radius < 0.45)).astype(float), np.clip(color, 0.0, 1.0), (0.08, 0.09, 0.13))


def books(height: int, width: int, shelves: int, seed: int) -> Picture:
    """A bookcase seen from the front."""
    random = np.random.default_rng(seed)
    palette = np.array([(0.55, 0.14, 0.12), (0.14, 0.26, 0.42), (0.16, 0.38, 0.28), (0.80, 0.62, 0.22),
                        (0.86, 0.80, 0.68), (0.38, 0.20, 0.34), (0.78, 0.38, 0.16), (0.22, 0.20, 0.20)])  # fmt: skip
    out = wood(height, width, (0.42, 0.27, 0.15), seed + 3)
    board = max(height // (shelves * 12), 2)
    for shelf in range(shelves):
        top, bottom = shelf * height // shelves + board, (shelf + 1) * height // shelves - board
        out[top:bottom, board * 2 : -board * 2] = (0.10, 0.07, 0.05)
        x = board * 2
        while x < width - 3 * board:
            wide = int(4 + random.random() * 8 * width / 512)
            high = int((bottom - top) * (0.62 + 0.33 * random.random()))
            if random.random() < 0.07:
                x += 3 * wide
                continue
            right = min(x + wide, width - 2 * board)
            color = palette[int(random.random() * len(palette))] * (0.8 + 0.4 * random.random())
            out[bottom - high : bottom, x:right] = np.clip(color, 0.0, 1.0)
            out[bottom - high : bottom, x] = color * 0.5
            band = bottom - high + high // 6
            out[band : band + max(high // 12, 1), x + 1 : right] = (0.90, 0.78, 0.42)
            x = right
    return out


def rug(height: int, width: int) -> Picture:
    """A carpet: borders within borders around a field of diamonds."""
    x, y = _grid(height, width)
    edge = np.minimum(np.minimum(x, 1.0 - x) * width / height, np.minimum(y, 1.0 - y))
    band = np.minimum((edge * 22.0).astype(int), 6)
    palette = np.array([(0.90, 0.82, 0.62), (0.48, 0.10, 0.12), (0.12, 0.20, 0.36), (0.80, 0.60, 0.28),
                        (0.12, 0.20, 0.36), (0.90, 0.82, 0.62), (0.55, 0.12, 0.13)])  # fmt: skip
    out = palette[band]
    u, v = x * 10.0 * width / height, y * 10.0
    diamond = np.abs(u % 1.0 - 0.5) + np.abs(v % 1.0 - 0.5)
    field = _choose((diamond < 0.36).astype(float), (0.13, 0.22, 0.38), (0.55, 0.12, 0.13))
    field = _choose((diamond < 0.22).astype(float), (0.88, 0.70, 0.34), field)
    field = _choose((diamond < 0.10).astype(float), (0.55, 0.12, 0.13), field)
    return _choose((band >= 6).astype(float), field, out)


def beach_ball(height: int, width: int) -> Picture:
    """Gores in six colours with white caps, to be wrapped around a sphere."""
    _, y = _grid(height, width)
    out = stripes(height, width, 12, [(0.90, 0.20, 0.16), (0.96, 0.94, 0.90), (0.14, 0.40, 0.74), (0.96, 0.94, 0.90),
                                      (0.97, 0.77, 0.14), (0.96, 0.94, 0.90)])  # fmt: skip
    return _choose((np.abs(y - 0.5) > 0.44).astype(float), (0.97, 0.96, 0.93), out)


def citrus(height: int, width: int, color: Color, seed: int) -> Picture:
    """Dimpled peel."""
    dimples = _noise(height, width, 40, 80, seed, 2)
    return np.clip(np.array(color) * (0.96 + 0.10 * dimples)[..., None], 0.0, 1.0)


def book_cover(height: int, width: int, color: Color) -> Picture:
    """Cloth with a gilt rule."""
    x, y = _grid(height, width)
    edge = np.minimum(np.minimum(x, 1.0 - x) * width / height, np.minimum(y, 1.0 - y))
    out = plain(color, height, width)
    out = _choose(((edge > 0.07) & (edge < 0.095)).astype(float), (0.86, 0.70, 0.34), out)
    star = np.abs(x - 0.5) * width / height + np.abs(y - 0.5)
    return _choose(((star < 0.16) & (star > 0.10)).astype(float), (0.86, 0.70, 0.34), out)
