"""What a measured BRDF costs, by lobes and view angles, and what is lost.

    .venv/bin/python benchmarks/measured_material.py [TABLE.npz]

By default the table is that of examples/brdf_table.py, in the studio of examples/any_brdf.py. The *error* is the mean
absolute difference to the whole BRDF, summed over all texels of the environment, on a sphere seen from far away, in
shares of its mean radiance. Seconds are those of all processors together, for fitting the lobes and filtering their
maps. A *frame* is a picture of a teapot, 512² pixels with one sample each, relative to that of a mirror; pictures
alternate and medians count, so that a busy machine changes the ratios little.
"""

import sys
import time
from pathlib import Path

import numpy as np

from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.files.measured_brdf_file import read_measured_brdf
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.reflectance.brdfs.brdf_reference import reflected_reference
from reflet.reflectance.lobes.lobes import KINDS, fit_lobes
from reflet.reflectance.materials.material import GlossyGgx, Mirror, SurfaceMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.measured_material import Measured
from reflet.reflectance.prefilter.brdf_map import brdf_map_3d, reflected_radiance
from reflet.render.device.device import adapter_name, shared_device
from reflet.render.materials.material_renderer import MaterialRenderer

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from any_brdf import sphere, studio
from brdf_table import measured

ROUNDS, PIXELS, ROWS = 7, 48, 32


def main() -> None:
    """Prints both tables."""
    brdf = read_measured_brdf(sys.argv[1]) if len(sys.argv) > 1 else measured()
    light = studio(ROWS)
    normal, wo = sphere(PIXELS)
    exact = reflected_reference(light, brdf, normal, wo)
    one = ("glossy",)
    print("lobes  view angles  error  fit, s  maps, s  texels")
    for kinds, angles in ((one, 12), (KINDS[:2], 12), (KINDS, 4), (KINDS, 8), (KINDS, 12), (KINDS, 16)):
        start = time.process_time()
        lobes = fit_lobes(brdf, kinds, angles)
        fitted = time.process_time()
        maps = brdf_map_3d(light, lobes, Octahedral(), ROWS)
        filtered = time.process_time()
        off = np.abs(reflected_radiance(maps, normal, wo) - exact).mean() / exact.mean()
        texels = sum(image.texels[..., 0].size for slices in maps.slices for image in slices)
        cost = f"{fitted - start:7.2f} {filtered - fitted:8.2f} {texels:7d}"
        print(f"{len(kinds):5d} {angles:12d} {off:6.1%} {cost}")
    print(f"\n{adapter_name(shared_device())}\nmaterial    frame, of a mirror's")
    materials: dict[str, SurfaceMaterial] = {
        "mirror": Mirror(),
        "GGX": GlossyGgx(perceptual_roughness=0.4),
        "one lobe": Measured(fit_lobes(brdf, one, 12)),
        "three lobes": Measured(fit_lobes(brdf, KINDS, 12)),
    }
    mesh = load_mesh("teapot")
    camera = frame_mesh(mesh, image_size=512).camera()
    renderer = MaterialRenderer(mesh, EnvironmentMaps(light))
    times: dict[str, list[float]] = {name: [] for name in materials}
    for _ in range(1 + ROUNDS):
        for name, material in materials.items():
            start = time.perf_counter()
            renderer.picture(material, camera, samples=1, backdrop=False)
            times[name].append(time.perf_counter() - start)
    for name, each in times.items():
        print(f"{name:12s} {np.median(each[1:]) / np.median(times['mirror'][1:]):.2f}")


if __name__ == "__main__":
    main()
