"""What a table of a BRDF holds, as a table for the terminal."""

import numpy as np
from rich import box
from rich.table import Table

from reflet.reflectance.brdfs.measured_brdf import MeasuredBrdf
from reflet.reflectance.lobes.brdf_facts import BrdfFacts
from reflet.report.table import table_text


def brdf_table(table: MeasuredBrdf, facts: BrdfFacts) -> str:
    """Its angles, its reciprocity, and for view angles its albedo, the errors of fitted lobes and their axis."""
    about = Table(box=None, show_header=False)
    channels = {1: "grey", 3: "RGB"}[table.values.shape[-1]]
    about.add_row("kind", f"table of an isotropic BRDF, {channels}")
    for name, angles in (("light", table.theta_i), ("viewer", table.theta_o), ("between azimuths", table.delta_phi)):
        first, last = np.rad2deg(angles[[0, -1]])
        about.add_row(f"angles, {name}", f"{len(angles)}, from {first:g}° to {last:.4g}°")
    about.add_row("values", f"{table.values.min():.4g} to {table.values.max():.4g} per steradian")
    about.add_row("reciprocity", f"broken by {facts.reciprocity_error:.1%} of the values' root mean square")
    fits = Table("view angle", box=box.SIMPLE_HEAD)
    for heading in ("albedo", "error of one lobe", f"of {' + '.join(_kinds(facts))}", "peak beyond the mirror's"):
        fits.add_column(heading, justify="right")
    glossy = facts.several.lobes[0]
    beyond = np.rad2deg(glossy.axis_angle - np.arccos(facts.several.cos_theta_o))
    for k in range(len(facts.albedo))[::-1]:
        fits.add_row(
            f"{np.rad2deg(np.arccos(facts.several.cos_theta_o[k])):.0f}°",
            " ".join(f"{value:.3f}" for value in facts.albedo[k]),
            f"{facts.one.error[k]:.1%}",
            f"{facts.several.error[k]:.1%}",
            f"{beyond[k]:+.1f}°",
        )
    return table_text(about) + "\n" + table_text(fits)


def _kinds(facts: BrdfFacts) -> list[str]:
    return ["diffuse", *(lobe.name for lobe in facts.several.lobes)]
