// Local light of rough surfaces: mesh colours that depend on direction. Twin of reflet.pem.surface_json.

import type { ArrayDescription } from "../files/arrays";
import type { SceneFile } from "../files/gltf";
import { halfFromFloat } from "../maths/half";

const LARGEST = 65504; // that half floats hold
const ALPHA_STEPS = 128;

/** Samples of all triangles: where each begins, in what resolution, and their sites, whose maps are rows of side² texels. */
export interface SurfaceLayer {
  readonly side: number;
  readonly resolution: Uint32Array;
  readonly offset: Uint32Array;
  readonly site: Uint32Array;
  /** Half floats: radiance and alpha. */
  readonly light: Uint16Array;
}

interface Scale {
  toe: number;
  step: number;
}

export interface StoredSurface {
  side: number;
  resolution: ArrayDescription;
  offset: ArrayDescription;
  site: ArrayDescription;
  light: ArrayDescription & Partial<Scale>;
}

export async function readSurface(stored: StoredSurface, files: SceneFile["files"]): Promise<SurfaceLayer> {
  const { side } = stored;
  const { toe, step, uri } = stored.light;
  const [resolution, offset, site, light] = await Promise.all([
    files.array(Uint32Array, stored.resolution),
    files.array(Uint32Array, stored.offset),
    files.array(Uint32Array, stored.site),
    toe !== undefined && step !== undefined
      ? files.array(Int16Array, stored.light).then((codes) => decodedLight(codes, side ** 2, { toe, step }))
      : files.array(Uint16Array, stored.light),
  ]);
  if (!(side > 0) || light.length % (4 * side ** 2) !== 0) {
    throw new Error(`${uri} holds maps on surfaces of another size; bake again.`);
  }
  return { side, resolution, offset, site, light };
}

/** RGBA of each site's texels: greens come first, then reds and blues by their codes' distance from green, and alphas; in
 * each the first texels of all sites, then the second ones. */
export function decodedLight(codes: Int16Array, texels: number, { toe, step }: Scale): Uint16Array {
  const count = codes.length / 4;
  const half = (code: number, magnitude: number) => halfFromFloat(magnitude) | (code < 0 ? 0x8000 : 0);
  const known = new Map<number, number>(); // codes are few
  const radiance = (code: number): number => {
    let value = known.get(code);
    if (value === undefined) {
      value = half(code, Math.min(toe * Math.expm1(Math.min(Math.abs(code) * step, 80)), LARGEST));
      known.set(code, value);
    }
    return value;
  };
  const out = new Uint16Array(codes.length);
  for (let texel = 0, from = 0; texel < texels; texel++) {
    for (let at = 4 * texel; at < out.length; at += 4 * texels, from++) {
      const green = codes[from] as number;
      out[at] = radiance(green + (codes[count + from] as number));
      out[at + 1] = radiance(green);
      out[at + 2] = radiance(green + (codes[2 * count + from] as number));
      const alpha = codes[3 * count + from] as number;
      out[at + 3] = half(alpha, Math.abs(alpha) / ALPHA_STEPS);
    }
  }
  return out;
}

/** Each part told whether its triangles have maps. */
export function partsWithMaps<P extends { readonly indices: Uint32Array }>(
  parts: readonly P[],
  surface: SurfaceLayer | undefined,
): readonly P[] {
  if (!surface) return parts;
  let first = 0;
  return parts.map((part) => {
    const end = first + part.indices.length / 3;
    const surfaceLight = surface.resolution.subarray(first, end).some((resolution) => resolution > 0);
    first = end;
    return { ...part, surfaceLight };
  });
}
