"""The graphics device."""

from functools import cache

import wgpu
from wgpu.backends.wgpu_native.extras import set_instance_extras

from reflet.errors import RefletError

# Optional features that are used where present: float maps can be filtered only with the first (test renderings).
_WANTED = ("float32-filterable",)
# Not OpenGL, which lacks float render targets on many machines and would be taken where no other driver is found.
_BACKENDS = ("Vulkan", "Metal", "DX12")
_LIMITS_RAISED = ("max-buffer-size", "max-storage-buffer-binding-size", "max-texture-dimension-2d")


def open_device() -> wgpu.GPUDevice:
    """A new device on the adapter that the system prefers.

    Raises `RefletError` where there is no graphics adapter.
    """
    _choose_backends()
    try:
        adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    except RuntimeError as error:
        raise RefletError(
            "Drawing needs a Vulkan graphics adapter and none was found; install your card's driver, or the software "
            "one: apt-get install mesa-vulkan-drivers."
        ) from error
    features = [name for name in _WANTED if name in adapter.features]
    limits = {name: adapter.limits[name] for name in _LIMITS_RAISED}
    return adapter.request_device_sync(required_features=features, required_limits=limits)


@cache
def _choose_backends() -> None:
    """Once in a process: the library takes it only before its first adapter."""
    set_instance_extras(backends=_BACKENDS)


@cache
def shared_device() -> wgpu.GPUDevice:
    """One device for all renderers of this process."""
    return open_device()


def adapter_name(device: wgpu.GPUDevice) -> str:
    """The adapter in words, as its driver calls it."""
    info = device.adapter.info
    return f"{info['device']} ({info['adapter_type']}, {info['backend_type']}, {info['description']})"


def filters_exactly(device: wgpu.GPUDevice) -> bool:
    """Whether texture filters use float weights: true of software adapters. Graphics cards round weights to 8 bits."""
    return device.adapter.info["adapter_type"] == "CPU"
