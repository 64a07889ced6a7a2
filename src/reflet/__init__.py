"""reflet: parameterized environment maps.

Ray-traced reflections are baked into environment maps, one set for every point of a parameter space, and played back
in real time. The explicit list below is the public interface; each name is imported when it is first used, so that
``import reflet`` loads neither the ray tracer nor the graphics system.
"""

from importlib import import_module
from typing import Any

_PUBLIC = {
    "Camera": "reflet.scene.camera",
    "EnvMap": "reflet.envmap.env_map",
    "ParameterSpace": "reflet.scene.parameter_space",
    "Scene": "reflet.scene.scene",
}

__all__ = sorted(_PUBLIC)  # noqa: PLE0605
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'reflet' has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
