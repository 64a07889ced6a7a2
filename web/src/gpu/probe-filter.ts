// Prefiltering a cube by lobes, a mip level for each: twin of reflet.render.probe_filter.

import { createEnvMap, type EnvMapTexture, levelView } from "./env-map";
import { FacePasses } from "./face-passes";

const MOST_TAPS = 64;
const TAP_FLOATS = 8;
const HALF: GPUTextureFormat = "rgba16float";
const DIFFUSE_SOURCE = 16; // rows of the level that the diffuse level sums
const BLUR_OF_TEXELS = 0.6; // standard deviation, in texels, of what a lookup sees of a level

/** A lobe as taps: x, y, z around +z, blur in radians, weight; five numbers each (reflet.reflectance.lobe_taps). */
export type LobeTaps = Float32Array;

/** The uniform `Taps` of probe_filter.wgsl, for a cube of `size` rows. */
export function lobeUniform(lobe: LobeTaps, size: number): ArrayBuffer {
  const data = new ArrayBuffer(16 + 4 * TAP_FLOATS * MOST_TAPS);
  const floats = new Float32Array(data, 16);
  const count = lobe.length / 5;
  new Uint32Array(data)[0] = count;
  for (let k = 0; k < count; k++) {
    const [x, y, z, blur, weight] = lobe.subarray(5 * k, 5 * k + 5) as unknown as [
      number,
      number,
      number,
      number,
      number,
    ];
    floats.set([x, y, z, Math.log2((blur / BLUR_OF_TEXELS) * ((2 * size) / Math.PI)), weight], TAP_FLOATS * k);
  }
  return data;
}

export class ProbeFilter {
  /** Level 0 mirrors, level k is filtered with the lobe k - 1, the last one diffusely, as GGX of roughness 1 is. */
  readonly result: EnvMapTexture;
  private readonly passes: FacePasses;
  private readonly pyramid: GPUTexture;
  private readonly lobes: readonly GPUBuffer[];
  private readonly sampler: GPUSampler;

  /** `size` rows, a power of two. */
  constructor(
    device: GPUDevice,
    private readonly size: number,
    lobes: readonly LobeTaps[],
  ) {
    this.passes = new FacePasses(device, "probe_filter");
    this.sampler = device.createSampler({ magFilter: "linear", minFilter: "linear", mipmapFilter: "linear" });
    this.pyramid = createEnvMap(device, "cube", size, Math.log2(size) + 1, HALF).texture;
    this.result = createEnvMap(device, "cube", size, lobes.length + 2, HALF);
    this.lobes = lobes.map((lobe) => {
      const data = lobeUniform(lobe, size);
      const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
      const buffer = device.createBuffer({ size: data.byteLength, usage });
      device.queue.writeBuffer(buffer, 0, data);
      return buffer;
    });
  }

  /** The passes that filter a half-float cube, with mip levels if it is larger, into `result`. */
  refilter(encoder: GPUCommandEncoder, source: GPUTexture): void {
    const { passes, pyramid, sampler } = this;
    const at = (mipLevel: number) => ({ SIZE: this.size >> mipLevel });
    const incoming = { 0: source.createView({ dimension: "cube" }), 1: sampler };
    passes.draw(encoder, "first_level", at(0), pyramid, 0, incoming);
    for (let level = 1; level < pyramid.mipLevelCount; level++) {
      passes.draw(encoder, "next_level", at(level), pyramid, level, { 2: levelView(pyramid, level - 1) });
    }
    passes.draw(encoder, "mirrored", at(0), this.result.texture, 0, incoming);
    const last = this.lobes.length + 1;
    const summed = levelView(pyramid, Math.max(Math.log2(this.size / DIFFUSE_SOURCE), 0));
    passes.draw(encoder, "diffuse", at(last), this.result.texture, last, { 2: summed });
    const smooth = { 0: pyramid.createView({ dimension: "cube" }), 1: sampler };
    this.lobes.forEach((buffer, k) => {
      passes.draw(encoder, "prefiltered", at(k + 1), this.result.texture, k + 1, { ...smooth, 3: { buffer } });
    });
  }
}
