"""Frames that the browser read back from the viewer, and the renderer's beside them."""

import json

import numpy as np
from browser import draw
from PIL import Image


def browser_frame(session, name):
    """A raw frame as the browser read it back; a session is what it saw and the folder of its frames."""
    seen, folder = session
    frame = seen["frames"][name]
    return np.fromfile(folder / f"{name}.f32", np.float32).reshape(frame["height"], frame["width"], 4)


def drawn_frames(session, arguments, pem_of):
    """The same frames by the Python renderer on Chromium's rasterizer: ``arguments`` of `Renderer.frame` by name, and
    the name of each one's PEM folder."""
    seen, folder = session
    requests = {
        name: {
            **seen["frames"][name],
            "arguments": given,
            "pem": pem_of(name),
            "infinite": name.endswith("infinite-sphere"),
        }
        for name, given in arguments.items()
    }
    (folder / "requests.json").write_text(json.dumps(requests))
    return draw("draw_frames.py", folder, folder / "requests.json", folder / "drawn.npz")


def srgb_display(radiance):
    """CONVENTIONS.md: sRGB(1 - exp(-1.6 radiance))."""
    return srgb(1.0 - np.exp(-1.6 * radiance))


def srgb(linear):
    """Linear light as a display shows it."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def texels_on_screen(session, name, levels):
    """(texel, pixel) of one texel of each face of a cube laid flat, its levels given finest first.

    Faces px nx py ny pz nz from left to right, each further level below at half the size.
    """
    screen = np.asarray(Image.open(session[1] / f"{name}.png").convert("RGB"), np.float64) / 255.0
    height, width = screen.shape[:2]
    face = min(width / 6.5, height / 2.5)
    left, top = round((width - 6 * face) / 2), round((height - 2 * face) / 2)
    for mip_level, faces in enumerate(levels):
        size, edge = faces.shape[1], face / 2**mip_level
        y = top + 2 * face - 2 * edge
        for number in range(6):
            row, column = size // 4, size // 2
            at_x, at_y = left + (number + (column + 0.5) / size) * edge, y + (row + 0.5) / size * edge
            texel = faces[number, row, column].astype(np.float16).astype(np.float64)
            yield texel, screen[int(at_y), int(at_x)]
