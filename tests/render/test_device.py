"""The graphics device: what a machine without a driver is told."""

import os
import subprocess
import sys


def test_a_machine_without_vulkan_is_told_what_to_install() -> None:
    """The driver list is emptied, so that OpenGL at most is left, which must not be taken instead."""
    code = "from reflet.render.device.device import open_device; open_device()"
    environment = {**os.environ, "VK_DRIVER_FILES": "/nonexistent.json", "VK_ICD_FILENAMES": "/nonexistent.json"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert "RefletError: Drawing needs a Vulkan graphics adapter" in done.stderr
    assert "mesa-vulkan-drivers" in done.stderr
