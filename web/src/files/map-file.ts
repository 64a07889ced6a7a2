// The file of a map, coded or not: its suffix says which.

import type { MapShape } from "../maths/parameterization";
import { codedMapLevels } from "./coded-light";
import { mapLevels } from "./ktx2";

export const isCoded = (address: string): boolean => /\.avif(?:[?#]|$)/.test(address);

/** The mip levels of a map of 3 channels, or of 4, finest first; each holds all faces in half-float RGBA. */
export async function readMapLevels(
  file: ArrayBuffer,
  shape: MapShape,
  channels: 3 | 4,
  address: string,
): Promise<Uint8Array[]> {
  return isCoded(address) ? codedMapLevels(file, shape, channels, address) : mapLevels(file, shape, address);
}
