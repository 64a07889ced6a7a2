// Irradiance as mesh colours: floats, or whole numbers on a logarithmic scale. Twin of reflet.pem.irradiance_json.

import type { ArrayDescription } from "../files/arrays";
import type { SceneFile } from "../files/gltf";

/** Mesh colours of all triangles: where each begins, in what resolution, and their irradiance/π. */
export interface Irradiance {
  readonly colourGrids: { readonly resolution: Uint32Array; readonly offset: Uint32Array };
  readonly radiosity: Float32Array;
  /** How the luminance of each changes with the normal; only where normal maps bend any. */
  readonly gradient: Float32Array | undefined;
  /** Of each sample the share of each light without extent that is seen from there, as a byte. */
  readonly visibility: Uint8Array;
}

interface Scale {
  toe: number;
  step: number;
  tintStep: number;
}

export interface StoredIrradiance {
  resolution: ArrayDescription;
  offset: ArrayDescription;
  radiosity: ArrayDescription & Partial<Scale>;
  gradient?: ArrayDescription & Partial<Pick<Scale, "toe" | "step">>;
  visibility?: ArrayDescription;
}

export async function readIrradiance(stored: StoredIrradiance, files: SceneFile["files"]): Promise<Irradiance> {
  const { toe, step, tintStep } = stored.radiosity;
  const coded = toe !== undefined && step !== undefined && tintStep !== undefined;
  const [resolution, offset, radiosity, visibility] = await Promise.all([
    files.array(Uint32Array, stored.resolution),
    files.array(Uint32Array, stored.offset),
    coded
      ? files.array(Int16Array, stored.radiosity).then((codes) => decodedRadiosity(codes, { toe, step, tintStep }))
      : files.array(Float32Array, stored.radiosity),
    stored.visibility ? files.array(Uint8Array, stored.visibility) : new Uint8Array(0),
  ]);
  const gradient = stored.gradient && (await readGradient(stored.gradient, radiosity, files));
  return { colourGrids: { resolution, offset }, radiosity, gradient, visibility };
}

async function readGradient(
  stored: NonNullable<StoredIrradiance["gradient"]>,
  radiosity: Float32Array,
  files: SceneFile["files"],
): Promise<Float32Array> {
  const { toe, step } = stored;
  const gradient =
    toe !== undefined && step !== undefined
      ? decodedGradient(await files.array(Int16Array, stored), radiosity, { toe, step })
      : await files.array(Float32Array, stored);
  if (gradient.length !== radiosity.length) {
    throw new Error("surface.bin is damaged: irradiance and its gradients are of two sizes; copy it again.");
  }
  return gradient;
}

/** Three numbers of each sample, stored by their ratio to the luminance: all first ones, then the second, the third. */
export function decodedGradient(
  codes: ArrayLike<number>,
  radiosity: ArrayLike<number>,
  { toe, step }: Pick<Scale, "toe" | "step">,
): Float32Array {
  const count = codes.length / 3;
  const value = (at: number) => radiosity[at] as number;
  const out = new Float32Array(codes.length);
  for (let k = 0; k < count; k++) {
    const luminance = 0.2126 * value(3 * k) + 0.7152 * value(3 * k + 1) + 0.0722 * value(3 * k + 2);
    for (let axis = 0; axis < 3; axis++) {
      const logarithm = (codes[axis * count + k] as number) * step;
      const ratio = Math.sign(logarithm) * toe * Math.expm1(Math.min(Math.abs(logarithm), 80));
      out[3 * k + axis] = ratio * luminance;
    }
  }
  return out;
}

/** RGB of each sample: all greens come first, then reds and blues by their distance from green. */
export function decodedRadiosity(codes: ArrayLike<number>, { toe, step, tintStep }: Scale): Float32Array {
  const count = codes.length / 3;
  const value = (logarithm: number) => toe * Math.expm1(Math.min(Math.max(logarithm, 0), 80));
  const out = new Float32Array(codes.length);
  for (let k = 0; k < count; k++) {
    const green = (codes[k] as number) * step;
    out[3 * k] = value(green + (codes[count + k] as number) * tintStep);
    out[3 * k + 1] = value(green);
    out[3 * k + 2] = value(green + (codes[2 * count + k] as number) * tintStep);
  }
  return out;
}
