"""Scores added up view by view, so that no picture needs to be kept."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from reflet.report.comparison import METHODS, PLACES, Result, Viewpoint, ViewResult
from reflet.report.measures import EXPOSURE, SquaredError, flip, squared_error, ssim


@dataclass
class Tally:
    """What each method scored so far, at each viewpoint (``views``) and at each place. A place's PSNR
    pools squared errors, its SSIM and FLIP are means over pixels."""

    exposure: float = EXPOSURE
    views: list[ViewResult] = field(default_factory=list)
    _squared: dict[tuple[str, str], SquaredError] = field(default_factory=dict)
    _sums: dict[tuple[str, str], np.ndarray] = field(default_factory=dict)  # of SSIM, of FLIP, of pixels

    def add(
        self,
        viewpoint: Viewpoint,
        method: str,
        reference: Float[np.ndarray, "height width 3"],
        image: Float[np.ndarray, "height width 3"],
        mask: Bool[np.ndarray, "height width"],
    ) -> None:
        """Counts what a method shows at one viewpoint."""
        key, pixels = (viewpoint.where, method), int(np.count_nonzero(mask))
        squared = squared_error(reference, image, mask, self.exposure)
        self.views.append(ViewResult(viewpoint, method, squared.psnr))
        self._squared[key] = self._squared.get(key, SquaredError()) + squared
        similarity, error = (measure(reference, image, mask, self.exposure) for measure in (ssim, flip))
        self._sums[key] = self._sums.get(key, np.zeros(3)) + pixels * np.array([similarity, error, 1.0])

    def results(self, spacing_deg: float, elevations_deg: dict[str, float]) -> tuple[Result, ...]:
        """One result for each place and method counted, in the order of `PLACES` and `METHODS`."""
        out = []
        for where in PLACES:
            for method in METHODS:
                if (where, method) in self._sums:
                    similarity, error, pixels = self._sums[where, method]
                    out.append(
                        Result(
                            where=where,
                            method=method,
                            spacing_deg=spacing_deg,
                            elevation_deg=elevations_deg[where],
                            distance_factor=1.0,
                            psnr_display=self._squared[where, method].psnr,
                            ssim=float(similarity / pixels),
                            flip=float(error / pixels),
                        )
                    )
        return tuple(out)
