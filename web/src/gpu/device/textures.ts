// Textures on the device: twin of reflet.render.device.textures.

import type { Geometry } from "../../maths/geometry";
import { levelCount, type MapShape, PARAMETERIZATIONS, type ParameterizationName } from "../../maths/parameterization";
import { link } from "./shaders";

/** Fills all mip levels from the finest, with the renderer's own filter. */
export function fillMipLevels(device: GPUDevice, texture: GPUTexture): void {
  if (texture.mipLevelCount === 1) return;
  const module = device.createShaderModule({ code: link("mipmap") });
  const pipeline = device.createRenderPipeline({
    layout: "auto",
    vertex: { module, entryPoint: "vertex_mipmap" },
    fragment: { module, entryPoint: "next_level", targets: [{ format: texture.format }] },
  });
  const sampler = device.createSampler({ magFilter: "linear", minFilter: "linear" });
  const encoder = device.createCommandEncoder();
  for (let level = 1; level < texture.mipLevelCount; level++) {
    const view = (baseMipLevel: number) => texture.createView({ baseMipLevel, mipLevelCount: 1 });
    const group = device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: [
        { binding: 0, resource: view(level - 1) },
        { binding: 1, resource: sampler },
      ],
    });
    const pass = encoder.beginRenderPass({
      colorAttachments: [{ view: view(level), loadOp: "clear", storeOp: "store" }],
    });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    pass.draw(3);
    pass.end();
  }
  device.queue.submit([encoder.finish()]);
}

/** An empty 2D texture; with all mip levels if asked. */
export function createPicture(
  device: GPUDevice,
  width: number,
  height: number,
  format: GPUTextureFormat,
  mipMapped: boolean,
): GPUTexture {
  const largest = device.limits.maxTextureDimension2D;
  if (Math.max(width, height) > largest) {
    throw new Error(`A texture of ${width}×${height} is larger than this device takes: at most ${largest}×${largest}.`);
  }
  return device.createTexture({
    size: [width, height],
    format,
    mipLevelCount: mipMapped ? Math.floor(Math.log2(Math.max(width, height))) + 1 : 1,
    usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST | GPUTextureUsage.RENDER_ATTACHMENT,
  });
}

/** An array of maps with all mip levels, empty; each face of each slot is an array layer. */
export function createMapArray(device: GPUDevice, shape: MapShape, slots: number): GPUTexture {
  const { size } = shape;
  const { aspect, faceCount } = PARAMETERIZATIONS[shape.parameterization];
  const largest = device.limits.maxTextureDimension2D;
  if (aspect * size > largest) {
    throw new Error(`A map of ${aspect * size}×${size} texels is larger than this device takes: at most ${largest}².`);
  }
  return device.createTexture({
    size: [aspect * size, size, faceCount * slots],
    format: "rgba16float",
    mipLevelCount: levelCount(shape),
    usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
  });
}

/** The view that shaders look maps up in: cubes have a texture kind of their own. */
export const mapArrayView = (texture: GPUTexture, parameterization: ParameterizationName): GPUTextureView =>
  texture.createView({ dimension: parameterization === "cube" ? "cube-array" : "2d-array" });

/** Writes a map with all its mip levels into a slot of an array. */
export function writeMap(
  device: GPUDevice,
  texture: GPUTexture,
  slot: number,
  { parameterization, size }: MapShape,
  levels: readonly Uint8Array[],
): void {
  const { aspect, faceCount } = PARAMETERIZATIONS[parameterization];
  levels.forEach((level, mipLevel) => {
    const rows = size >> mipLevel;
    device.queue.writeTexture(
      { texture, mipLevel, origin: [0, 0, faceCount * slot] },
      level as Uint8Array<ArrayBuffer>,
      { bytesPerRow: 8 * aspect * rows, rowsPerImage: rows },
      [aspect * rows, rows, faceCount],
    );
  });
}

/** The cubes that shaders search, one for each geometry, at least one: infinitely far where it is no relief. */
export function createReliefs(device: GPUDevice, geometries: readonly Geometry[]): GPUTexture {
  const reliefs = geometries.map((geometry) => (geometry.kind === "relief" ? geometry : undefined));
  const sizes = new Set(reliefs.flatMap((relief) => (relief ? [relief.size] : [])));
  if (sizes.size > 1) throw new Error(`The reliefs of one object have ${[...sizes].join(" and ")} rows.`);
  const [size = 1] = sizes;
  const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
  const count = Math.max(reliefs.length, 1);
  const texture = device.createTexture({ size: [size, size, 6 * count], format: "r16float", usage });
  reliefs.forEach((relief, shell) => {
    if (!relief) return; // textures begin as zeros
    const data = relief.inverseDistance as Uint16Array<ArrayBuffer>;
    const destination = { texture, origin: [0, 0, 6 * shell] };
    device.queue.writeTexture(destination, data, { bytesPerRow: 2 * size, rowsPerImage: size }, [size, size, 6]);
  });
  return texture;
}
