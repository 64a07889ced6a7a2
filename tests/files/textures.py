"""Textures to write and read in tests."""

import numpy as np

from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.files.textures.texture import Texture, level_shape


def random_texture(form, rows, columns, level_count=1, *, is_cube=False, layers=1, seed=0, **fields):
    """Random texels that the format holds exactly."""
    rng = np.random.default_rng(seed)
    form = TEXEL_FORMATS[form]
    images = 6 if is_cube else layers
    levels = []
    for level in range(level_count):
        shape = level_shape(rows, columns, level)
        if form.is_writable:
            stored = form.encode(rng.random((images, *shape, form.channels)).astype(np.float32) * 10.0)
        else:
            stored = rng.integers(0, 256, (images, form.image_bytes(*shape)), dtype=np.uint8)
        levels.append(stored)
    return Texture(form, rows, columns, is_cube, tuple(levels), **fields)


def assert_same(read, written):
    """All that containers keep, and every byte of the levels."""
    assert read.texel_format == written.texel_format
    assert (read.rows, read.columns, read.is_cube) == (written.rows, written.columns, written.is_cube)
    assert len(read.levels) == len(written.levels)
    for ours, theirs in zip(read.levels, written.levels, strict=True):
        np.testing.assert_array_equal(ours, theirs)
