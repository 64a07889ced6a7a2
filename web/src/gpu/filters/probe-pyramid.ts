// The smooth pyramid that maps are prefiltered from, as often as the light changes: twin of reflet.render.filters.probe_pyramid.

import { PARAMETERIZATIONS } from "../../maths/parameterization";
import type { LobeTaps } from "../../scene/shaded-scene";
import { createEnvMap, type EnvMapTexture, levelView } from "../maps/env-map";
import { FacePasses } from "../maps/face-passes";

const MOST_TAPS = 64;
const TAP_FLOATS = 8;
const LOBE_FLOATS = 4 + TAP_FLOATS * MOST_TAPS;
const LISTED = 7; // numbers a tap in files
const HALF: GPUTextureFormat = "rgba16float";
const DIFFUSE_SOURCE = 16; // rows of the level that diffuse maps sum
const BLUR_OF_TEXELS = 0.6; // standard deviation, in texels, of what a lookup sees of a level

/** `lobes` of probe_filter.wgsl, for a pyramid of `size` rows. */
export function lobesBuffer(device: GPUDevice, size: number, lobes: readonly LobeTaps[]): GPUBuffer {
  const data = new ArrayBuffer(4 * LOBE_FLOATS * lobes.length);
  lobes.forEach((lobe, k) => {
    const floats = new Float32Array(data, 4 * LOBE_FLOATS * k, LOBE_FLOATS);
    const count = lobe.length / LISTED;
    const reflected = [0, 0, 0] as [number, number, number];
    for (let t = 0; t < count; t++) {
      const tap = lobe.subarray(LISTED * t, LISTED * (t + 1));
      const [blur] = tap.subarray(3) as unknown as [number];
      const weight = tap.subarray(4) as unknown as [number, number, number];
      const at = 4 + TAP_FLOATS * t;
      floats.set(tap.subarray(0, 3), at);
      floats[at + 3] = Math.log2((blur / BLUR_OF_TEXELS) * ((2 * size) / Math.PI));
      floats.set(weight, at + 4);
      for (const c of [0, 1, 2] as const) reflected[c] += weight[c];
    }
    floats.set(reflected);
    new Uint32Array(data, 4 * LOBE_FLOATS * k)[3] = count;
  });
  const usage = GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST;
  const buffer = device.createBuffer({ size: data.byteLength, usage });
  device.queue.writeBuffer(buffer, 0, data);
  return buffer;
}

export class ProbePyramid {
  private readonly passes: FacePasses;
  private readonly sampler: GPUSampler;
  private readonly texture: GPUTexture;

  /** `size` rows, a power of two. */
  constructor(
    readonly device: GPUDevice,
    readonly size: number,
  ) {
    this.passes = new FacePasses(device, "probe_filter");
    this.sampler = device.createSampler({ magFilter: "linear", minFilter: "linear", mipmapFilter: "linear" });
    this.texture = createEnvMap(device, "cube", size, Math.log2(size) + 1, HALF).texture;
  }

  /** The passes that fill the pyramid from a half-float cube, with mip levels if it is larger. */
  fill(encoder: GPUCommandEncoder, source: GPUTexture): void {
    const { passes, texture } = this;
    passes.draw(encoder, "first_level", { SIZE: this.size }, texture, 0, this.cube(source));
    for (let level = 1; level < texture.mipLevelCount; level++) {
      passes.draw(encoder, "next_level", {}, texture, level, { 2: levelView(texture, level - 1) });
    }
  }

  /** A level of a cube with what the source itself holds. */
  mirror(encoder: GPUCommandEncoder, source: GPUTexture, target: EnvMapTexture, level = 0): void {
    this.passes.draw(encoder, "mirrored", { SIZE: target.size >> level }, target.texture, level, this.cube(source));
  }

  /** A level of a map filtered with a lobe, or of several maps in a row with a lobe each. */
  filter(encoder: GPUCommandEncoder, lobes: GPUBuffer, target: EnvMapTexture, level = 0): void {
    const constants = { SIZE: target.size >> level, KIND: PARAMETERIZATIONS[target.parameterization].kind };
    const bound = { ...this.cube(this.texture), 3: { buffer: lobes } };
    this.passes.draw(encoder, "prefiltered", constants, target.texture, level, bound);
  }

  /** All other mip levels of such maps. */
  coarser(encoder: GPUCommandEncoder, { texture, parameterization }: EnvMapTexture): void {
    const { kind } = PARAMETERIZATIONS[parameterization];
    for (let level = 1; level < texture.mipLevelCount; level++) {
      const bound = { 2: levelView(texture, level - 1) };
      this.passes.draw(encoder, "coarser_map", { KIND: kind }, texture, level, bound);
    }
  }

  /** A level of a cube with irradiance/π by the normal. */
  diffuse(encoder: GPUCommandEncoder, target: EnvMapTexture, level = 0): void {
    const summed = levelView(this.texture, Math.max(Math.log2(this.size / DIFFUSE_SOURCE), 0));
    this.passes.draw(encoder, "diffuse", { SIZE: target.size >> level }, target.texture, level, { 2: summed });
  }

  private cube(texture: GPUTexture): Record<number, GPUBindingResource> {
    return { 0: texture.createView({ dimension: "cube" }), 1: this.sampler };
  }
}
