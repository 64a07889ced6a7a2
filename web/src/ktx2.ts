// KTX 2.0 cube maps in half float, as reflet.files.ktx2 writes them.

import { read, VK_FORMAT_R16G16B16A16_SFLOAT } from "ktx-parse";

/** The mip levels of a cube map, finest first; each holds six faces of half-float RGBA. */
export function cubeLevels(file: ArrayBuffer, size: number, name: string): Uint8Array[] {
  let container: ReturnType<typeof read>;
  try {
    container = read(new Uint8Array(file));
  } catch {
    throw new Error(`${name} is not a KTX 2.0 file, or is truncated.`);
  }
  const { faceCount, levels, pixelWidth, supercompressionScheme, vkFormat } = container;
  const complete = levels.every((level, i) => level.levelData.byteLength === 48 * Math.max(size >> i, 1) ** 2);
  const count = Math.log2(size) + 1;
  if (vkFormat !== VK_FORMAT_R16G16B16A16_SFLOAT || faceCount !== 6 || supercompressionScheme !== 0 || !complete) {
    throw new Error(`${name} is not a whole cube map of half-float texels.`);
  }
  if (pixelWidth !== size || levels.length !== count) {
    throw new Error(`${name} has ${pixelWidth}² texels a face and ${levels.length} levels, not ${size}² and ${count}.`);
  }
  return levels.map((level) => level.levelData as Uint8Array);
}
