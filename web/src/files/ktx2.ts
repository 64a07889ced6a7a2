// KTX 2.0 maps in half float, as reflet.files.textures.ktx2 writes them.

import { read, VK_FORMAT_R16G16B16A16_SFLOAT } from "ktx-parse";
import { levelBytes, levelCount, type MapShape, PARAMETERIZATIONS } from "../maths/parameterization";

/** The mip levels of a map, or of `count` in a row, finest first; each holds all faces in half-float RGBA. */
export function mapLevels(file: ArrayBuffer, shape: MapShape, name: string, count = 1): Uint8Array[] {
  let container: ReturnType<typeof read>;
  try {
    container = read(new Uint8Array(file));
  } catch {
    throw new Error(`${name} is not a KTX 2.0 file, or is truncated.`);
  }
  const { faceCount, layerCount, levels, pixelHeight, pixelWidth, supercompressionScheme, vkFormat } = container;
  const { size, parameterization } = shape;
  const { aspect, faceCount: faces } = PARAMETERIZATIONS[parameterization];
  if (vkFormat !== VK_FORMAT_R16G16B16A16_SFLOAT || supercompressionScheme !== 0) {
    throw new Error(`${name} is not a map of half-float texels.`);
  }
  if (faceCount * Math.max(layerCount, 1) !== count * faces || pixelHeight !== size || pixelWidth !== aspect * size) {
    throw new Error(
      `${name} does not hold what scene.gltf says: ${count} of ${parameterization} maps of ${size} rows.`,
    );
  }
  const complete = levels.every((level, i) => level.levelData.byteLength === count * levelBytes(shape, i));
  if (levels.length !== levelCount(shape) || !complete) {
    throw new Error(`${name} does not hold all its mip levels.`);
  }
  return levels.map((level) => level.levelData as Uint8Array);
}
