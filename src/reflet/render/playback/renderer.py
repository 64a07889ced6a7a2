"""The target graphics system: draws PEMs."""

from collections.abc import Collection, Mapping, Sequence
from typing import Literal

import numpy as np
import wgpu
from jaxtyping import Float32, UInt32

from reflet.errors import RefletError
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.render.device.device import shared_device
from reflet.render.playback.layouts import (
    LARGEST_BLEND,
    SWITCHES,
    Blended,
    Shown,
    base_state,
    frame_uniform,
    switch_bits,
)
from reflet.render.playback.passes import Passes
from reflet.render.playback.resident_maps import ResidentMaps
from reflet.render.playback.scene_buffers import SceneBuffers
from reflet.render.playback.stacks import stacks_of
from reflet.render.playback.target import Target
from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import Adaptive, Samples, resolved_samples

ALL_SHOWN: frozenset[Shown] = frozenset(SWITCHES)


class Renderer:
    """Draws one PEM. Maps go to the device when a picture needs them.

    A PEM without local layers, or of one sample or none, is drawn by the same rules: that is how plain, static env maps
    are shown.
    """

    def __init__(
        self, pem: ParameterizedEnvironmentMap, device: wgpu.GPUDevice | None = None, map_memory: int = 256 * 2**20
    ) -> None:
        """``map_memory`` bounds the maps on the device, in bytes."""
        if pem.distant_layers and not len(pem.maps) and not pem.base:
            raise RefletError("This PEM has neither viewpoints nor maps that serve all; bake it again.")
        self.pem = pem
        self.stacks = stacks_of(pem.layers)
        self.device = device or shared_device()
        self._buffers = SceneBuffers(self.device, pem, self.stacks)
        self._passes = Passes(self.device)
        self._maps = ResidentMaps(self.device, pem, self.stacks, map_memory)
        self._part_groups = self._buffers.part_groups(self._maps.arrays)
        self._target: Target | None = None
        self._taken: int | Adaptive = 1
        self._constants: dict[str, float] = {}

    def frame(
        self,
        camera: Camera,
        *,
        samples: Samples | None = None,
        blend: bool = True,
        layers: Collection[Shown] = ALL_SHOWN,
        what: Literal["picture", "object"] = "picture",
        point: Mapping[str, float] | None = None,
        shells: Collection[int] | None = None,
        base: float | None = None,
        by_origin: bool = False,
        multisampled: bool = False,
        exact: bool = True,
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance, and coverage in alpha.

        ``samples`` a pixel (1, 4, 16, 64 or 256) are by default those that the maps were inferred for; "adaptive" takes
        16, and 256 where those or a neighbour's disagree ("quick" 16 and 64, "motion" 4 and 16, and any `Adaptive`).
        ``blend`` mixes the maps around the camera's point of the parameter space, else the nearest are shown; ``point``
        names another. ``layers`` may leave out any of "diffuse", "fresnel" (reflectance is then 1), "distant" and
        "local": what local maps hold or, of a PEM with hits, what mirrors that are met send and reflect; ``shells`` are
        the numbers of those distant layers of an object that are shown, the nearest is 0. ``base`` is the share of the
        distant light that comes from the maps that serve every viewpoint, by default `base_share` of the point: 0 shows
        the samples alone, 1 the base alone. ``by_origin`` shows mirrored light in the colour of where it comes from,
        with its own luminance: orange from the object's own mesh or local maps, blue from the last shell, green from
        the nearest before it and yellow from one between them. The "object" is what fronts of reflective parts show,
        multiplied by its coverage. ``multisampled`` draws four samples in one pass with half-float radiance, as viewers
        do in motion.
        Unless ``exact``, surfaces are interpolated by the rasterizer, which is faster, and a little different on every
        driver.
        """
        samples = self._asked(samples)
        if multisampled and samples != 4:
            raise RefletError(f"Multi-sampled pictures have 4 samples a pixel, not {samples}.")
        switches = switch_bits(layers, what == "object", shells, by_origin)
        shown = self._blend(camera, blend, point, base, "local" in layers)
        entry_point = f"picture_{'multi' if multisampled else 'single'}{'' if exact else '_fast'}"
        backdrop = what == "picture" and self.pem.scene.environment is not None
        return self._mean(camera, samples, switches, *shown, "picture.wgsl", entry_point, backdrop)

    def layer_image(
        self,
        camera: Camera,
        kind: Literal["distant", "local"],
        *,
        samples: Samples | None = None,
        blend: bool = True,
        point: Mapping[str, float] | None = None,
        shells: Collection[int] | None = None,
        base: float | None = None,
    ) -> Float32[np.ndarray, "height width 4"]:
        """What the maps of one kind alone say, without Fresnel: the mean over all sub-samples of their lookups.

        Distant ones are the shells, each over the next, with alpha 1 (so alpha is the object's coverage) unless the
        last is left out; local ones are premultiplied and bring their own alpha. Where nothing is looked up all four
        are 0. ``point``, ``shells`` and ``base`` are those of `frame`.
        """
        shown = self._blend(camera, blend, point, base, kind == "local")
        return self._mean(
            camera, self._asked(samples), switch_bits((), False, shells), *shown, "probe.wgsl", f"probe_{kind}", False
        )

    def samples_taken(self) -> UInt32[np.ndarray, "height width"]:
        """How many samples each pixel of the last picture took."""
        if self._target is None:
            raise RefletError("No picture is drawn yet; ask for a frame first.")
        samples = self._taken
        if isinstance(samples, Adaptive):
            return self._passes.sums.read_counts(self._target, samples.most)
        width, height = self._target.size
        return np.full((height, width), samples, np.uint32)

    def visible_triangles(
        self, camera: Camera, sample_count: int, sub_sample: int
    ) -> UInt32[np.ndarray, "height width"]:
        """1 + the number of the triangle that a sub-sample of each pixel sees, where it reflects; else 0."""
        self._write_frame(camera, sample_count, 0, [], self._base(0.0))
        target = self._target_for(camera)
        encoder = self.device.create_command_encoder()
        picture = self._draw(encoder, target, "probe.wgsl", "probe_triangle", sub_sample, False, self._part_groups)
        self.device.queue.submit([encoder.finish()])
        return self._passes.read(picture, np.uint32)[..., 0]

    def met_triangles(self, camera: Camera, sample_count: int, sub_sample: int) -> UInt32[np.ndarray, "height width 4"]:
        """1 + the numbers of the first four triangles that the mirrored ray of a sub-sample of each pixel meets, one
        after the other; 0 for none."""
        self._write_frame(camera, sample_count, 0, [], self._base(0.0))
        target = self._target_for(camera)
        encoder = self.device.create_command_encoder()
        picture = self._draw(encoder, target, "traced_probe.wgsl", "probe_hits", sub_sample, False, self._part_groups)
        self.device.queue.submit([encoder.finish()])
        return self._passes.read(picture, np.uint32)

    def raw_lookup(
        self,
        camera: Camera,
        kind: Literal["distant", "local"],
        sample_count: int,
        sub_sample: int,
        part_groups: Sequence[wgpu.GPUBindGroup],
        shell: int = 0,
    ) -> Float32[np.ndarray, "height width 4"]:
        """The four channels that one sub-sample of each pixel looks up in slot 0 of maps bound by `bind_maps`, of
        distant ones in one shell alone.

        View-dependent maps are those of the camera itself.
        """
        blend = [Blended(0, 1.0, camera.view_from_world())]
        self._write_frame(camera, sample_count, switch_bits((), False, [shell]), blend, self._base(0.0))
        target = self._target_for(camera)
        encoder = self.device.create_command_encoder()
        picture = self._draw(encoder, target, "probe.wgsl", f"probe_{kind}", sub_sample, False, part_groups)
        self.device.queue.submit([encoder.finish()])
        return self._passes.read(picture, np.float32)

    def bind_maps(self, arrays: Sequence[wgpu.GPUTexture]) -> list[wgpu.GPUBindGroup]:
        """Part bind groups with other maps: one array for each of ``stacks``."""
        return self._buffers.part_groups(arrays)

    def _asked(self, samples: Samples | None) -> int | Adaptive:
        return self.pem.sample_count if samples is None else resolved_samples(samples)

    def _blend(
        self, camera: Camera, blend: bool, point: Mapping[str, float] | None, share: float | None, local: bool
    ) -> tuple[list[Blended], Blended]:
        """The samples that a frame shows, with or without local maps, and the base."""
        space = self.pem.space
        point = space.orbit.point_of(camera) if point is None else point
        base = self._base(self.pem.base_share(point) if share is None else self._checked_share(share))
        local = local and not self.pem.most_hits and any(stack.kind == "local" for stack in self.stacks)
        if base.weight >= 1.0 and not local:
            return [], base
        weights = space.blend_weights(point)
        if weights and not blend:
            weights = {max(weights, key=lambda sample: (weights[sample], -sample)): 1.0}
        if len(weights) > LARGEST_BLEND:
            raise RefletError(f"At most {LARGEST_BLEND} samples can be blended, not {len(weights)}; show the nearest.")
        slots = self._maps.slots(list(weights))
        return [
            Blended(slot, weight, space.camera(sample).view_from_world())
            for slot, (sample, weight) in zip(slots, weights.items(), strict=True)
        ], base

    def _base(self, share: float) -> Blended:
        return Blended(self._maps.base_slot, share, self.pem.space.orbit.camera().view_from_world())

    def _checked_share(self, share: float) -> float:
        least, most = float(not len(self.pem.maps)), float(bool(self.pem.base))
        if not least <= share <= most:
            raise RefletError(
                f"The base of this PEM can have a share between {least:g} and {most:g} of the distant light, not "
                f"{share}."
            )
        return share

    def _write_frame(
        self, camera: Camera, samples: int, switches: int, blend: Sequence[Blended], base: Blended
    ) -> None:
        data = frame_uniform(camera, samples, self.pem.lod_bias_at(samples), blend, base, switches)
        self.device.queue.write_buffer(self._buffers.frame_uniform, 0, data.tobytes())
        self._constants = {"SWITCHES": switches, "BLEND_COUNT": len(blend), "BASE": base_state(base.weight)}

    def _target_for(self, camera: Camera) -> Target:
        size = camera.width, camera.height
        if self._target is None or self._target.size != size:
            self._target = Target(self.device, *size)
        return self._target

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        program: str,
        entry_point: str,
        sub_sample: int,
        backdrop: bool,
        part_groups: Sequence[wgpu.GPUBindGroup],
        *,
        keeps_out: bool = False,
    ) -> wgpu.GPUTexture:
        return self._passes.draw(
            encoder, target, program, entry_point, sub_sample, backdrop, self._constants,
            self._buffers.frame_group, part_groups, self._buffers.draws, keeps_out=keeps_out,
        )  # fmt: skip

    def _mean(
        self,
        camera: Camera,
        samples: int | Adaptive,
        switches: int,
        blend: Sequence[Blended],
        base: Blended,
        program: str,
        entry_point: str,
        backdrop: bool,
    ) -> Float32[np.ndarray, "height width 4"]:
        """The mean of all sub-samples of each pixel."""
        target, sums = self._target_for(camera), self._passes.sums
        adaptive = isinstance(samples, Adaptive)
        first = samples.first if isinstance(samples, Adaptive) else samples
        pictures = 1 if "multi" in entry_point else first  # of one sub-sample, or of four at once
        self._write_frame(camera, first, switches, blend, base)
        encoder = self.device.create_command_encoder()
        sums.begin(encoder, target, first if adaptive else None)
        for k in range(pictures):
            picture = self._draw(encoder, target, program, entry_point, k, backdrop, self._part_groups)
            sums.add(encoder, picture, target, spread=adaptive)
        if isinstance(samples, Adaptive):
            sums.decide(encoder, target)
            self.device.queue.submit([encoder.finish()])
            self._write_frame(camera, samples.most, switches, blend, base)  # what follows has other LODs
            encoder = self.device.create_command_encoder()
            for k in range(first, samples.most):
                picture = self._draw(
                    encoder, target, program, entry_point, k, backdrop, self._part_groups, keeps_out=True
                )
                sums.add(encoder, picture, target)
        self.device.queue.submit([encoder.finish()])
        self._taken = samples
        counts = self.samples_taken()[..., None] if adaptive else np.float32(pictures)
        return sums.read(target) / np.asarray(counts, np.float32)
