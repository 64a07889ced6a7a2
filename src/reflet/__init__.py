"""reflet: parameterized environment maps.

Ray-traced reflections are baked into environment maps, one set for every point of a parameter space, and played back
in real time. The explicit list below is the public interface; each name is imported when it is first used, so that
``import reflet`` loads neither the ray tracer nor the graphics system.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

_PUBLIC = {
    "Camera": "reflet.scene.camera",
    "Comparison": "reflet.report.comparison",
    "EnvImage": "reflet.envmap.env_image",
    "EnvMap": "reflet.envmap.env_map",
    "EnvironmentCapture": "reflet.render.capture",
    "LiveEnvironment": "reflet.render.live_environment",
    "MaterialRenderer": "reflet.render.material_renderer",
    "Orbit": "reflet.scene.parameter_space",
    "PARAMETERIZATIONS": "reflet.envmap.parameterizations",
    "ParameterSpace": "reflet.scene.parameter_space",
    "ParameterizedEnvironmentMap": "reflet.pem.pem",
    "RefletError": "reflet.errors",
    "Renderer": "reflet.render.renderer",
    "Scene": "reflet.scene.scene",
    "Tracer": "reflet.trace.tracer",
    "bake": "reflet.bake",
    "compare": "reflet.compare",
    "convert": "reflet.convert",
    "engine_maps": "reflet.engine_maps",
    "frame_orbit": "reflet.scene.framing",
    "infer_layer": "reflet.infer.infer_layer",
    "join": "reflet.join",
    "join_hemispheres": "reflet.envmap.hemispheres",
    "load_scene": "reflet.load",
    "mip_images": "reflet.envmap.mip_reduction",
    "open_pem": "reflet.pem.container",
    "orbit_space": "reflet.scene.parameter_space",
    "parameterization": "reflet.envmap.parameterizations",
    "read_env_image": "reflet.files.env_image_file",
    "prefilter": "reflet.prefilter",
    "render_mirror": "reflet.render.env_map_renderer",
    "resample": "reflet.envmap.resample",
    "save_pem": "reflet.pem.container",
    "shade": "reflet.shade",
    "sketch": "reflet.sketch",
    "verify": "reflet.verify",
    "write_env_image": "reflet.files.env_image_file",
}

__all__ = sorted(_PUBLIC)  # noqa: PLE0605
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'reflet' has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


class _Package(ModuleType):
    """Keeps functions such as `bake`, `compare` and `convert` in front of the modules of the same names.

    Importing a submodule binds it to its package's attribute, which would hide the function from then on.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _PUBLIC and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
