// What the user can choose of a PEM's picture.

import type { Kind } from "../maths/geometry";
import { NORMAL_EXPOSURE, type ToneCurve } from "../maths/tone";
import type { MapShows, Shown } from "../scene/pem";

export interface Settings {
  view: "picture" | "maps";
  /** Layer whose maps are shown flat. */
  layer: number;
  /** Those of the nearest viewpoint, or the one that serves all, where there is one. */
  mapOf: "viewpoint" | "base";
  mapShows: MapShows;
  /** Blend the samples around the view, or show the nearest alone. */
  blend: boolean;
  shown: Shown;
  /** Numbers of shells that are left out of the distant light; the nearest is 0. */
  hiddenShells: readonly number[];
  /** Colour mirrored light by where it comes from. */
  byOrigin: boolean;
  /** Geometry that lookups of the distant maps meet, and its size relative to that of the bake. */
  geometry: Kind | "baked";
  growth: number;
  exposure: number;
  curve: ToneCurve;
}

export const defaultSettings = (): Settings => ({
  view: "picture",
  layer: 0,
  mapOf: "viewpoint",
  mapShows: "radiance",
  blend: true,
  shown: { diffuse: true, fresnel: true, distant: true, local: true },
  hiddenShells: [],
  byOrigin: false,
  geometry: "baked",
  growth: 1,
  exposure: NORMAL_EXPOSURE,
  curve: "exponential",
});
