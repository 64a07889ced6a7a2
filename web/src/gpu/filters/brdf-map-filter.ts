// The maps of a measured BRDF's lobes, as often as the light changes: twin of reflet.render.filters.brdf_map_filter.

import type { BrdfMap } from "../../scene/shaded-scene";
import { createEnvMap, type EnvMapTexture } from "../maps/env-map";
import { lobesBuffer, ProbePyramid } from "./probe-pyramid";

const LEAST = 4; // rows of the last mip level
const LEAST_PYRAMID = 16;

export class BrdfMapFilter {
  /** All slices of all lobes in a row, as large as those of the table's file. */
  readonly result: EnvMapTexture;
  private readonly pyramid: ProbePyramid;
  private readonly lobes: GPUBuffer | undefined; // none where all is diffuse

  constructor(device: GPUDevice, { parameterization, size, slices, taps }: BrdfMap) {
    this.pyramid = new ProbePyramid(device, Math.max(size, LEAST_PYRAMID));
    const levels = Math.floor(Math.log2(size / LEAST)) + 1;
    this.result = createEnvMap(device, parameterization, size, levels, "rgba16float", slices);
    this.lobes = taps.length > 0 ? lobesBuffer(device, this.pyramid.size, taps) : undefined;
  }

  /** The passes that filter a half-float cube, with mip levels if it is larger, into `result`. */
  refilter(encoder: GPUCommandEncoder, source: GPUTexture): void {
    const { pyramid, lobes, result } = this;
    if (lobes === undefined) return;
    pyramid.fill(encoder, source);
    pyramid.filter(encoder, lobes, result);
    pyramid.coarser(encoder, result);
  }
}
