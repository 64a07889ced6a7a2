// Pictures of materials in the layers of one array texture: twin of reflet.render.playback.picture_atlas, and of its atlas.

import type { PictureTexture } from "../../files/gltf";

const MOST_LAYERS = 256; // of an array texture, WebGPU's default

/** Where a picture lies: column, row, layer, width + 65536 height. */
export type PicturePlace = readonly [number, number, number, number];

/** The texture, one texel where there are no pictures, and where each lies. */
export function pictureAtlas(
  device: GPUDevice,
  textures: readonly (PictureTexture | undefined)[],
): { texture: GPUTexture; places: ReadonlyMap<ImageBitmap, PicturePlace> } {
  const images = [...new Set(textures.flatMap((texture) => texture?.image ?? []))];
  const { places, size } = atlasOf(images);
  const largest = device.limits.maxTextureDimension2D;
  if (Math.max(size[0], size[1]) > largest) {
    throw new Error(
      `A texture of ${size[0]}×${size[1]} is larger than this device takes: at most ${largest}×${largest}.`,
    );
  }
  const texture = device.createTexture({
    size,
    format: "rgba8unorm",
    usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST | GPUTextureUsage.RENDER_ATTACHMENT,
  });
  images.forEach((source, k) => {
    const destination = { texture, origin: places[k] as Place };
    device.queue.copyExternalImageToTexture({ source }, destination, [source.width, source.height]);
  });
  const placeOf = images.map((image, k): [ImageBitmap, PicturePlace] => {
    const [column, row, layer] = places[k] as Place;
    return [image, [column, row, layer, image.width + 65536 * image.height]];
  });
  return { texture, places: new Map(placeOf) };
}

/** Column, row and layer. */
type Place = readonly [number, number, number];

interface Atlas {
  readonly places: readonly Place[];
  readonly size: Place;
}

/** Where pictures lie in the layers of an array texture: twin of reflet.render.playback.atlas. */
function atlasOf(images: readonly ImageBitmap[]): Atlas {
  const most = (side: "width" | "height") => Math.max(1, ...images.map((image) => image[side]));
  let [width, height] = [most("width"), most("height")];
  for (;;) {
    const atlas = onShelves(images, width, height);
    if (atlas.size[2] <= MOST_LAYERS) return atlas;
    if (width <= height) width *= 2;
    else height *= 2;
  }
}

/** The highest pictures first. */
function onShelves(images: readonly ImageBitmap[], width: number, height: number): Atlas {
  const places: Place[] = images.map(() => [0, 0, 0]);
  let [x, y, layer, shelf] = [0, 0, 0, 0];
  const numbered = [...images.entries()].sort(([, a], [, b]) => b.height - a.height || b.width - a.width);
  for (const [k, image] of numbered) {
    if (x + image.width > width) [x, y, shelf] = [0, y + shelf, 0];
    if (y + image.height > height) [x, y, layer, shelf] = [0, 0, layer + 1, 0];
    places[k] = [x, y, layer];
    x += image.width;
    shelf = Math.max(shelf, image.height);
  }
  return { places, size: [width, height, layer + 1] };
}
