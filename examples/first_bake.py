"""From a scene to a picture, step by step: load, trace, infer, save, open, draw.

Run it with the folder to write to::

    python examples/first_bake.py out/first

It bakes one viewpoint of the built-in teapot room, small, with the functions that ``reflet bake`` is made of, and
writes two pictures: ``traced.png`` as the ray tracer sees it, ``baked.png`` as the maps show it. They should look
alike, down to the knob mirrored in the lid and the spout in the body; the second is softer where small maps hold no
more detail.
"""

import sys
from pathlib import Path

import reflet
from reflet.envmap.mip_chain import MipChain
from reflet.files.pictures.png import write_png
from reflet.infer.fit_geometry import em_origin, fit
from reflet.pem.pem import Layer
from reflet.report.measures import picture_srgb
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.trace.compose import compose
from reflet.trace.layers import Shells

LOD_BIAS = -1.5  # of lookups, for maps of single viewpoints


def main(out: Path) -> None:
    """Bakes one viewpoint into ``out/pem`` and writes two pictures of it."""
    scene = reflet.load_scene("teapot-room")
    space = reflet.orbit_space(reflet.frame_orbit(scene, image_size=128), views=1, spacing_deg=2.0)
    camera, teapot, chain = space.camera(0), scene.objects[0], MipChain(64)

    # Trace: the layers of the picture, and the static env map from the teapot's centre.
    tracer = reflet.Tracer(scene, irradiance_spp=16)
    view = tracer.view(camera, spp=16, surroundings=True)
    probe = tracer.probe(0, Shells(em_origin(scene, teapot.parts)), size=chain.size, spp=16)

    # Infer: one distant map for the teapot, whose room is a box; one local map in an ellipsoid for each part.
    gbuffer = gbuffer_from_visibility(scene, view.visibility)
    on_hull = hull_triangles(scene)
    box = fit("box", scene, teapot.parts, probe)
    layers = [Layer("teapot distant", "distant", teapot.parts, box, chain.size)]
    for part in teapot.parts:
        ellipsoid = fit("ellipsoid", scene, (part,))
        layers.append(Layer(f"{scene.parts[part].name} local", "local", (part,), ellipsoid, chain.size))
    maps = []
    for layer in layers:
        prior = probe.texels if layer.kind == "distant" else None
        solution = reflet.infer_layer(
            layer.kind, gbuffer, view.layers, layer.parts, layer.geometry, chain, LOD_BIAS, prior=prior, on_hull=on_hull
        )
        maps.append(reflet.EnvMap(chain, solution.texels, layer.geometry))
        print(f"{layer.name}: {solution.iterations} iterations, {solution.seen_share:.0%} of the texels seen")

    # Save and open again: maps are half float on disk.
    pem = reflet.ParameterizedEnvironmentMap(
        scene, tracer.irradiance, space, tuple(layers), [tuple(maps)], on_hull, LOD_BIAS, sample_count=16
    )
    reflet.save_pem(out / "pem", pem)
    opened = reflet.open_pem(out / "pem")

    # Draw.
    write_png(out / "traced.png", picture_srgb(compose(view.layers)))
    write_png(out / "baked.png", picture_srgb(reflet.Renderer(opened).frame(camera)[..., :3]))
    print(f"Look at traced.png and baked.png in {out}, or turn it around: reflet view {out / 'pem'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
