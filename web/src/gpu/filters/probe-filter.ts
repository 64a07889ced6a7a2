// Prefiltering a cube by lobes, a mip level for each: twin of reflet.render.filters.probe_filter.

import type { LobeTaps } from "../../scene/shaded-scene";
import { createEnvMap, type EnvMapTexture } from "../maps/env-map";
import { lobesBuffer, ProbePyramid } from "./probe-pyramid";

export class ProbeFilter {
  /** Level 0 mirrors, level k is filtered with the lobe k - 1, the last one diffusely, as GGX of roughness 1 is. */
  readonly result: EnvMapTexture;
  private readonly pyramid: ProbePyramid;
  private readonly lobes: readonly GPUBuffer[];

  /** `size` rows, a power of two. */
  constructor(device: GPUDevice, size: number, lobes: readonly LobeTaps[]) {
    this.pyramid = new ProbePyramid(device, size);
    this.result = createEnvMap(device, "cube", size, lobes.length + 2, "rgba16float");
    this.lobes = lobes.map((lobe) => lobesBuffer(device, size, [lobe]));
  }

  /** The passes that filter a half-float cube, with mip levels if it is larger, into `result`. */
  refilter(encoder: GPUCommandEncoder, source: GPUTexture): void {
    const { pyramid, result } = this;
    pyramid.fill(encoder, source);
    pyramid.mirror(encoder, source, result);
    pyramid.diffuse(encoder, result, this.lobes.length + 1);
    this.lobes.forEach((lobe, k) => {
      pyramid.filter(encoder, lobe, result, k + 1);
    });
  }
}
