"""Prefiltered maps of sheen as mip levels, looked up by the sheen's own roughness."""

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.resampling.resample import resample
from reflet.envmap.sampling import valid_texels
from reflet.reflectance.brdfs.charlie import CharlieKernel
from reflet.reflectance.prefilter.ggx_levels import LINEAR, RoughnessScale, checked_level_count
from reflet.reflectance.prefilter.prefilter import Prefilter, Progress, unheard

# perceptual_roughness: there the lobe, a ring along the horizon, is 5° wide; below, engines have fits that end as well
_LEAST = 0.2
_FINEST = 64  # rows of a cube, 1.4°: interpolated between, rings of 5° err by (1.4/5)²/8 or 1 % of what they vary
_TOLERANCE = 0.1  # of the cells: a tenth of a per cent is left, and a third of the time


def sheen_levels(
    image: EnvImage,
    to: Parameterization,
    size: int,
    level_count: int | None = None,
    scale: RoughnessScale = LINEAR,
    progress: Progress = unheard,
) -> tuple[EnvImage, ...]:
    """The environment filtered with `CharlieKernel`: level k, of ``size`` >> k rows, for the roughness of ``scale``.

    What is smoother than 0.2 stands for 0.2. Levels finer than sheen's own detail are interpolated. ``level_count`` is
    by default that which ends at 16 rows. ``progress`` hears of texels made, and of all. Raises RefletError as
    `ggx_levels` does.
    """
    count = checked_level_count(size, level_count)
    environment = Prefilter(image, _TOLERANCE)
    finest = equal_sampling_size(to, valid_texels(CUBE) * _FINEST**2, power_of_two=True)
    roughness = [max(scale.roughness_of_level(level, count), _LEAST) for level in range(count)]
    wanted = [(min(size >> level, finest), roughness[level]) for level in range(count)]
    todo = dict.fromkeys(wanted)
    total, done = sum(rows * rows for rows, _ in todo), 0
    made: dict[tuple[int, float], EnvImage] = {}
    for rows, r in todo:

        def heard(part: int, whole: int, before: int = done, own: int = rows * rows) -> None:
            progress(before + own * part // whole, total)

        made[rows, r] = environment.map(CharlieKernel(r * r), to, rows, heard)
        done += rows * rows
    progress(total, total)
    return tuple(resample(made[key], to, size >> level) for level, key in enumerate(wanted))
