// Irradiance as mesh colours: floats, or whole numbers on a logarithmic scale. Twin of reflet.pem.irradiance_json.

import type { ArrayDescription } from "../files/arrays";
import type { SceneFile } from "../files/gltf";

/** Mesh colours of all triangles: where each begins, in what resolution, and their irradiance/π. */
export interface Irradiance {
  readonly colourGrids: { readonly resolution: Uint32Array; readonly offset: Uint32Array };
  readonly radiosity: Float32Array;
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
}

export async function readIrradiance(stored: StoredIrradiance, files: SceneFile["files"]): Promise<Irradiance> {
  const { toe, step, tintStep } = stored.radiosity;
  const coded = toe !== undefined && step !== undefined && tintStep !== undefined;
  const [resolution, offset, radiosity] = await Promise.all([
    files.array(Uint32Array, stored.resolution),
    files.array(Uint32Array, stored.offset),
    coded
      ? files.array(Int16Array, stored.radiosity).then((codes) => decodedRadiosity(codes, { toe, step, tintStep }))
      : files.array(Float32Array, stored.radiosity),
  ]);
  return { colourGrids: { resolution, offset }, radiosity };
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
