"""Writing small OBJ files, and what is asked of their parts."""

import warnings

import numpy as np


def write(folder, text, name="a.obj"):
    (folder / name).write_text(text)
    return folder / name


def triangles(part):
    return part.mesh.positions[part.mesh.triangles].astype(float)


def area(part):
    at = triangles(part)
    return 0.5 * np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1).sum()


def silently(read, *arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return read(*arguments)
