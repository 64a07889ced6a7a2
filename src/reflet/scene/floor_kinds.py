"""What a floor beneath a model is like, as it is asked for."""

from dataclasses import dataclass

KINDS = ("matte", "polished", "shadow")
RADIUS = 10.0  # times the height: at the rim the ground is seen 6° below the horizon
ROUGHNESS = 0.1  # of polished stone


@dataclass(frozen=True)
class Floor:
    """``height`` in metres from which the environment was photographed, by default the diagonal of the box around the
    model; ``radius`` in metres of the floor, by default `RADIUS` heights; ``kind`` one of `KINDS`. ``roughness`` is the
    perceptual one of a polished floor, by default `ROUGHNESS`."""

    height: float | None = None
    radius: float | None = None
    kind: str = "matte"
    roughness: float | None = None
