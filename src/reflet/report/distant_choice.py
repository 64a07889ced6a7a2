"""How a bake shows distant light, in words: what was chosen, and what the trials said."""

from collections.abc import Mapping
from typing import Any


def distant_choice(name: str, choice: Mapping[str, Any]) -> str:
    """One sentence on an object's shells: `DistantChoice` as a PEM's statistics hold it."""
    kinds, ends, trials = choice["kinds"], choice["ends"], choice["trials"]
    reach = [f"{_words(kind)} to {end:.3g} m" for kind, end in zip(kinds, ends, strict=False)]
    shells = ", then ".join([*reach, _words(kinds[-1]) + (" beyond" if ends else "")])
    told = f"{name}: {shells}"
    if not trials:
        return told
    best = next(trial for trial in trials if tuple(trial["kinds"]) == tuple(kinds))
    others = [trial for trial in trials if trial is not best]
    rest = ", ".join(f"{' + '.join(map(_words, trial['kinds']))} {trial['psnr']:.1f}" for trial in others)
    return f"{told}: {best['psnr']:.1f} dB by static maps at held-back viewpoints" + (f"; {rest}" if rest else "")


def base_choice(choice: Mapping[str, Any]) -> str:
    """What serves every viewpoint, as a `BaseChoice` in a PEM's statistics tells it."""
    static, joint = choice["static_psnr"], choice["joint_psnr"]
    if joint is None:
        return f"static maps: {static:.1f} dB at held-back viewpoints, so nothing was inferred"
    words = [("static maps", static), ("the joint set", joint)]
    (best, shows), (other, less) = words if choice["kind"] == "static" else reversed(words)
    return f"{best}: {shows:.1f} dB at held-back viewpoints; {other} {less:.1f}"


def _words(kind: str) -> str:
    return {"infinite_sphere": "infinitely far"}.get(kind, kind)
