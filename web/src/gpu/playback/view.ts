// What a frame shows: where from, which maps in which shares, which layers.

import type { Camera } from "../../maths/camera";
import type { Vec3 } from "../../maths/vectors";
import type { Shown } from "../../scene/pem";

/** A sample of the parameter space as a frame shows it, or the base. */
export interface Blended {
  readonly slot: number; // in the arrays of maps
  readonly weight: number; // of the samples; the base's is its share of the distant light
  readonly mapFromWorld: readonly [Vec3, Vec3, Vec3]; // rows: the frame of its view-dependent maps
}

export interface View {
  readonly camera: Camera;
  readonly blend: readonly Blended[];
  readonly base: Blended;
  readonly shown: Shown;
  /** Numbers of shells that are left out; the nearest is 0. */
  readonly hiddenShells: readonly number[];
  /** Mirrored light in the colour of where it comes from. */
  readonly byOrigin: boolean;
}
