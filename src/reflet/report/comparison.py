"""What a comparison hands on. Imports nothing heavy."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32

# Every method with the words that figures and tables use for it, in their order. The distant layer alone lies under the
# true local layer: it is measured without what else may be wrong.
METHODS = {
    "traced": "PEM, traced",
    "traced-static": "static shells, traced",
    "layered": "layered PEM",
    "distant-only": "distant layer alone",
    "distant-only-joint": "distant layer alone, joint",
    "distant-only-static": "distant layer alone, static",
    "static-shells": "static shells",
    "single-infinite": "single-layer PEM, infinite",
    "single-sphere": "single-layer PEM, sphere",
    "single-ellipsoid": "single-layer PEM, ellipsoid",
    "single-box": "single-layer PEM, box",
    "static-infinite": "static map, infinite",
    "static-box": "static map, box",
    "engine": "engine, static box",
    "mirror": "as mirrors, traced",
}
PLACES = {
    "sample": "at a sample",
    "between": "between samples",
    "above-10": "10° above",
    "above-20": "20° above",
    "dome": "around",
}


@dataclass(frozen=True)
class Viewpoint:
    """Where a picture is compared: the place it stands for (one of `PLACES`) and its number there, the camera's azimuth
    and elevation, and how far it stands from the sampled range (`ParameterSpace.displacement_deg`), all in degrees."""

    where: str
    number: int
    azimuth_deg: float
    elevation_deg: float
    away_deg: float

    @property
    def name(self) -> str:
        return f"{self.where}-{self.number}"


@dataclass(frozen=True)
class ViewResult:
    """What one method scores at one viewpoint: display PSNR in dB."""

    viewpoint: Viewpoint
    method: str
    psnr_display: float


@dataclass(frozen=True)
class Result:
    """What one method scores at one place: display PSNR in dB, mean SSIM and mean FLIP over all views of the place.

    ``where`` is one of `PLACES`, ``method`` one of `METHODS`; ``distance_factor`` is the camera's distance over the
    baked one.
    """

    where: str
    method: str
    spacing_deg: float
    elevation_deg: float
    distance_factor: float
    psnr_display: float
    ssim: float
    flip: float


@dataclass(frozen=True)
class Exhibit:
    """The pictures of one view, cut out around the object: what a figure shows of a place.

    ``reference`` and ``pictures`` (by method) are the object's radiance, ``coverage`` its share of each pixel.
    """

    where: str
    azimuth_deg: float
    elevation_deg: float
    reference: Float32[np.ndarray, "height width 3"]
    coverage: Float32[np.ndarray, "height width"]
    pictures: dict[str, Float32[np.ndarray, "height width 3"]]

    @property
    def mask(self) -> Bool[np.ndarray, "height width"]:
        """The pixels that measures count: those the object covers by more than half."""
        return self.coverage > 0.5


@dataclass(frozen=True)
class Comparison:
    """All results, by place and by viewpoint, one view of each place, and the circumstances (scene, adapter, samples,
    exposure, noise).

    ``reference_picture`` and ``played_picture`` are one whole view, ray traced and played back from the PEM.
    """

    results: tuple[Result, ...]
    views: tuple[ViewResult, ...]
    exhibits: tuple[Exhibit, ...]
    context: dict[str, Any]
    reference_picture: Float32[np.ndarray, "height width 3"]
    played_picture: Float32[np.ndarray, "height width 3"]

    def result(self, where: str, method: str) -> Result:
        """The one result of a method at a place; KeyError if it was not measured."""
        for result in self.results:
            if (result.where, result.method) == (where, method):
                return result
        raise KeyError((where, method))

    @property
    def methods(self) -> list[str]:
        """What was compared, in the order of `METHODS`; a PEM without a base has no joint set."""
        return [method for method in METHODS if any(result.method == method for result in self.results)]

    @property
    def played(self) -> str:
        """The method that is the PEM itself."""
        return self.methods[0]

    def as_json(self) -> dict[str, Any]:
        """The circumstances and, under ``results``, one record for each place and method; under ``views`` one for each
        viewpoint and method."""
        views = [{**asdict(v.viewpoint), "method": v.method, "psnr_display": v.psnr_display} for v in self.views]
        return {**self.context, "results": [asdict(result) for result in self.results], "views": views}
