"""Choosing where the ray tracer computes."""

import drjit as dr
import mitsuba as mi

from reflet.errors import RefletError

VARIANTS = {"llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}

OLDEST_LLVM = 17  # older ones cannot compile a minimum of floats for x86 and end the process


def use_variant(variant: str = "llvm_ad_rgb") -> None:
    """Make Mitsuba compute on the CPU (``llvm``) or on an NVIDIA GPU (``cuda``); Mitsuba's own names serve too.

    Raises RefletError for an unknown name, and where libLLVM or the GPU's driver is missing.
    """
    name = VARIANTS.get(variant, variant)
    if name not in VARIANTS.values():
        raise RefletError(f"The variant must be one of {', '.join(VARIANTS)}, not {variant!r}.")
    try:
        if mi.variant() != name:
            mi.set_variant(name)
        dr.eval(mi.Float(dr.arange(mi.UInt32, 2)))
    except Exception as error:
        need = (
            "libLLVM (Debian: apt install libllvm19)"
            if "llvm" in name
            else "an NVIDIA GPU with its driver (or take --variant llvm)"
        )
        raise RefletError(f"Ray tracing with variant {variant!r} needs {need}, and it could not be used.") from error
    if "llvm" in name and dr.detail.llvm_version()[0] < OLDEST_LLVM:
        raise RefletError(
            f"Ray tracing needs libLLVM {OLDEST_LLVM} or newer, and only {dr.detail.llvm_version()[0]} was found; "
            "install one (Debian: apt install libllvm19)."
        )
