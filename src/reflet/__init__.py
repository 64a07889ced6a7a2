"""reflet: parameterized environment maps.

Ray-traced reflections are baked into environment maps, one set for every point of a parameter space, and played back
in real time. The explicit list below is the public interface; each name is imported when it is first used, so that
``import reflet`` loads neither the ray tracer nor the graphics system.
"""

from importlib import import_module
from typing import Any

_PUBLIC = {
    "Camera": "reflet.scene.views.camera",
    "Comparison": "reflet.report.comparison",
    "EnvImage": "reflet.envmap.env_image",
    "EnvMap": "reflet.envmap.env_map",
    "EnvironmentCapture": "reflet.render.capture.capture",
    "Floor": "reflet.scene.floor_kinds",
    "LiveEnvironment": "reflet.render.filters.live_environment",
    "MaterialRenderer": "reflet.render.materials.material_renderer",
    "Orbit": "reflet.scene.views.parameter_space",
    "PARAMETERIZATIONS": "reflet.envmap.parameterizations.by_name",
    "ParameterSpace": "reflet.scene.views.parameter_space",
    "ParameterizedEnvironmentMap": "reflet.pem.pem",
    "RefletError": "reflet.errors",
    "Renderer": "reflet.render.playback.renderer",
    "Scene": "reflet.scene.scene",
    "Tracer": "reflet.trace.tracer",
    "bake": "reflet.pipelines.bake",
    "compare": "reflet.pipelines.compare",
    "convert": "reflet.pipelines.convert",
    "engine_maps": "reflet.pipelines.engine_maps",
    "env_map_of": "reflet.envmap.env_map",
    "frame_orbit": "reflet.scene.views.framing",
    "infer_layer": "reflet.infer.infer_layer",
    "join": "reflet.pipelines.join",
    "join_hemispheres": "reflet.envmap.resampling.hemispheres",
    "load_scene": "reflet.pipelines.load",
    "mip_images": "reflet.envmap.resampling.mip_reduction",
    "open_pem": "reflet.pem.container",
    "orbit_space": "reflet.scene.views.parameter_space",
    "parameterization": "reflet.envmap.parameterizations.by_name",
    "read_env_image": "reflet.files.env_image_file",
    "prefilter": "reflet.pipelines.prefilter",
    "render_mirror": "reflet.render.materials.env_map_renderer",
    "resample": "reflet.envmap.resampling.resample",
    "save_pem": "reflet.pem.container",
    "shade": "reflet.pipelines.shade",
    "sketch": "reflet.pipelines.sketch",
    "verify": "reflet.pipelines.verify",
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
