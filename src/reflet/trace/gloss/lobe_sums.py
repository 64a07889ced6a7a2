"""Layers of rough parts from their samples: weighted sums over each row, and what follows from them.

Over a row's samples, with W = Σw of their rays' weights,

    distant D = Σ w·L(through the object)/W,   local = Σ w·L(of the object, where it hides)/W,
    alpha = 1 - lum(Σ w·L(through, where nothing hides)/W)/lum D,

so that local + (1 - alpha)·distant is what arrives, in luminance: the object hides a share of *light*. A lamp that
fills a hundredth of the lobe may be all there is to hide. Likewise shell before shell. ``combined`` has Fresnel's term
at every sample's own half vector, as the surface truly reflects: Σ w·F·L/Σ w·F times the directional albedo.

**What emitters add** is scaled by W over the sum of the mean weights, the lobe's albedo for F = 1: W has the noise of
light that rays find, but not of this.
"""

import numpy as np
from jaxtyping import Float
from numba import njit, prange

from reflet.envmap.facts import LUMINANCE

NOTHING = 0xFFFFFFFF
ROUNDING = 1e-9  # of sums in another order
ALL_HIDDEN = 0.999  # of a lobe's weight: what shines past that is noise
# Flags of a sample: of its ray, of its emitter, and from these bits on of both for each shell.
HIDDEN, ROUGH, LIT, LIT_OWN = 1, 2, 4, 8
RAYS_SHELLS, EMITTERS_SHELLS, MOST_SHELLS = 8, 20, 12
# A sample's channels, after its diffuse light and Fresnel reflectance: what its ray weighs and would weigh in the mean,
# light of the object itself, what of light is reflected, an emitter's light, the same reflected, light shell by shell.
WEIGHT, ALBEDO, LOCAL, SHOWN, FOUND, FOUND_SHOWN, BEYOND = 6, 7, 8, 11, 14, 17, 20
# A row's sums, after the same two: of light, reflected light, its share and that of emitters, and of weights, of the
# luminance that nothing hides, of rough samples; then of each shell light, the luminance beyond that it leaves, weight.
S_DISTANT, S_LOCAL, S_SHOWN, S_SHARE, S_FOUND, S_WEIGHT, S_HIDDEN, S_SEEN = 6, 9, 12, 15, 18, 21, 22, 23
S_ROUGH, S_SHELLS, S_LEFT, S_HELD, S_SHELL = 24, 25, 3, 4, 5


def sum_lobes(
    part: np.ndarray, slot_of_part: np.ndarray, channels: list[np.ndarray], spp: int, pixels: int, parts: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums over each pixel's samples, apart for each part, in the samples' order: the same on every run."""
    flags, *values = channels
    shells = (len(values) - BEYOND) // 3
    sums = np.zeros((pixels, parts, S_SHELLS + S_SHELL * shells))
    counts = np.zeros((pixels, parts), np.int32)
    _sum_samples(part, slot_of_part, flags, np.stack(values), spp, sums, counts)  # one type however many shells
    return sums, counts


@njit(parallel=True, cache=True)
def _sum_samples(part, slot_of_part, flags, channels, spp, sums, counts):  # type: ignore[no-untyped-def]
    shells = (len(channels) - BEYOND) // 3
    for p in prange(len(counts)):
        mean_weight, light = np.zeros(counts.shape[1]), np.zeros(3)
        for k in range(p * spp, (p + 1) * spp):
            if part[k] != NOTHING:
                slot = slot_of_part[part[k]]
                counts[p, slot] += 1
                sums[p, slot, S_WEIGHT] += channels[WEIGHT, k]
                mean_weight[slot] += channels[ALBEDO, k]
        for k in range(p * spp, (p + 1) * spp):
            if part[k] == NOTHING:
                continue
            slot = slot_of_part[part[k]]
            row, flag, weight = sums[p, slot], flags[k], channels[WEIGHT, k]
            hidden = 1.0 if flag & HIDDEN else 0.0
            row[S_ROUGH] += 1.0 if flag & ROUGH else 0.0
            row[S_HIDDEN] += weight * hidden
            for c in range(6):
                row[c] += channels[c, k]
            # the ray: from the farthest shell to the nearest, what arrives if all before is taken away
            light[:] = 0.0
            for s in range(shells - 1, -1, -1):
                at = S_SHELLS + S_SHELL * s
                if flag >> (RAYS_SHELLS + s) & 1:
                    for c in range(3):
                        light[c] = channels[BEYOND + 3 * s + c, k]
                        row[at + c] += weight * light[c]
                    row[at + S_HELD] += weight
                else:
                    row[at + S_LEFT] += weight * _luminance(light[0], light[1], light[2])
            row[S_SEEN] += weight * (1.0 - hidden) * _luminance(light[0], light[1], light[2])
            for c in range(3):
                local, shown = channels[LOCAL + c, k], weight * channels[SHOWN + c, k]
                row[S_DISTANT + c] += weight * light[c]
                row[S_LOCAL + c] += weight * local
                row[S_SHOWN + c] += shown * (local + (1.0 - hidden) * light[c])
                row[S_SHARE + c] += shown
            # the emitter, as if its light had the weights of the rays
            scale = row[S_WEIGHT] / max(mean_weight[slot], 1e-30)
            for c in range(3):
                light[c] = scale * channels[FOUND + c, k]
                row[S_FOUND + c] += channels[FOUND_SHOWN + c, k] if flag & (LIT | LIT_OWN) else 0.0
                row[S_LOCAL + c] += light[c] if flag & LIT_OWN else 0.0
                row[S_DISTANT + c] += light[c] if flag >> EMITTERS_SHELLS & 1 else 0.0
            luminance = _luminance(light[0], light[1], light[2])
            row[S_SEEN] += luminance if flag & LIT else 0.0
            farthest = -1
            for s in range(shells):
                if flag >> (EMITTERS_SHELLS + s) & 1:
                    farthest = s
            for s in range(farthest):
                row[S_SHELLS + S_SHELL * s + S_LEFT] += luminance if flag >> (EMITTERS_SHELLS + s) & 1 else 0.0
            if farthest >= 0:
                for c in range(3):
                    row[S_SHELLS + S_SHELL * farthest + c] += light[c]


@njit(cache=True)
def _luminance(r, g, b):  # type: ignore[no-untyped-def]
    return LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b


def lobe_rows(
    sums: Float[np.ndarray, "rows sums"], counts: Float[np.ndarray, "rows"]
) -> Float[np.ndarray, "rows channels"]:
    """Layers from sums: diffuse, fresnel, distant, local, combined (3 each), alpha, and four more a shell."""
    count, weight = counts[:, None], np.maximum(sums[:, S_WEIGHT, None], 1e-30)
    rough = sums[:, S_ROUGH] > 0.0
    diffuse, fresnel = sums[:, :3] / count, sums[:, 3:6] / count
    distant, local = sums[:, S_DISTANT : S_DISTANT + 3] / weight, sums[:, S_LOCAL : S_LOCAL + 3] / weight
    shown, share, found = (sums[:, at : at + 3] for at in (S_SHOWN, S_SHARE, S_FOUND))
    combined = fresnel * shown / np.maximum(share, 1e-30) + found / count
    alpha = _hiding(rough, sums[:, S_HIDDEN] / weight[:, 0], sums[:, S_SEEN] / weight[:, 0], distant @ LUMINANCE)
    shell_count = (sums.shape[1] - S_SHELLS) // S_SHELL
    shells = sums[:, S_SHELLS:].reshape(len(sums), shell_count, S_SHELL) / weight[:, None]
    beyond = np.zeros(len(sums))
    for number in range(shells.shape[1] - 1, -1, -1):
        shell = shells[:, number]
        passes, held = shell[:, S_LEFT].copy(), shell[:, S_HELD]
        last = number == shells.shape[1] - 1
        shell[:, 3] = 1.0 if last else _hiding(rough, held, passes, beyond)
        beyond = shell[:, :3] @ LUMINANCE + passes
    return np.concatenate(
        [
            diffuse,
            fresnel,
            distant,
            local,
            combined,
            alpha[:, None],
            shells[..., :4].reshape(len(sums), 4 * shell_count),
        ],
        1,
    )


def _hiding(rough: np.ndarray, share: np.ndarray, seen: np.ndarray, luminance: np.ndarray) -> Float[np.ndarray, "rows"]:
    """Alpha of what hides a ``share`` of the weight and leaves ``seen`` of the ``luminance`` behind it: by light where
    the row is rough and there is any, by weight where not."""
    by_light = rough & (luminance > 0.0) & (share <= ALL_HIDDEN)
    hidden = np.clip(1.0 - seen / np.where(luminance > 0.0, luminance, 1.0), 0.0, 1.0)
    hidden[hidden < ROUNDING] = 0.0
    return np.where(by_light, hidden, np.where(rough & (share > ALL_HIDDEN), 1.0, share))
