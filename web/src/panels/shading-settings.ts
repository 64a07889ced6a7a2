// What the user can choose of a shaded mesh's picture.

import type { ToneCurve } from "../maths/tone";
import type { LampSettings } from "../scene/lamp";
import type { Shown } from "../scene/shaded-scene";

export interface ShadingSettings {
  material: Shown;
  /** Degrees by which the environment is turned about the vertical, counter-clockwise seen from above. */
  turn: number;
  /** Added to the environment; drawings do without. */
  lamp: LampSettings;
  backdrop: boolean;
  exposure: number;
  curve: ToneCurve;
}
