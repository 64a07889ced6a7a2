// Prefiltering by Phong's lobe as often as its exponent changes: twin of reflet.render.filters.phong_paraboloid.

import { PARAMETERIZATIONS } from "../../maths/parameterization";
import { type PlaneFilter, phongPlaneFilters } from "../../maths/plane-filter";
import { createEnvMap, type EnvMapTexture, levelView } from "../maps/env-map";
import { FacePasses } from "../maps/face-passes";

const WEIGHTS_BYTES = 208;
const FULL: GPUTextureFormat = "rgba32float";

export class PhongParaboloidFilter {
  readonly result: EnvMapTexture;
  private readonly passes: FacePasses;
  private readonly flux: GPUTexture;
  private readonly filtered: readonly [GPUTexture, GPUTexture]; // for the middle and for the rim
  private readonly weights: readonly [GPUBuffer, GPUBuffer];
  private readonly border: number;

  /** Faces have `size` rows, a power of two from 16. */
  constructor(
    private readonly device: GPUDevice,
    private readonly size: number,
  ) {
    this.passes = new FacePasses(device, "phong_paraboloid");
    this.border = size / 4;
    const levels = Math.log2(size) - 1; // filters shrink at most so far
    const texture = () => createEnvMap(device, "dual_paraboloid", size + 2 * this.border, levels, FULL).texture;
    this.flux = texture();
    this.filtered = [texture(), texture()];
    const buffer = () =>
      device.createBuffer({ size: WEIGHTS_BYTES, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    this.weights = [buffer(), buffer()];
    this.result = createEnvMap(device, "dual_paraboloid", size, 1, FULL);
  }

  /** The passes that filter a map into `result`. One refilter a submission. */
  refilter(encoder: GPUCommandEncoder, source: EnvMapTexture, exponent: number): void {
    const { device, passes, flux, size, border } = this;
    const KIND = PARAMETERIZATIONS[source.parameterization].kind;
    const constants = { SIZE: size, BORDER: border, KIND };
    const filters = phongPlaneFilters(exponent, size);
    passes.draw(encoder, "with_border", constants, flux, 0, {
      0: source.texture.createView({ dimension: "2d-array" }),
    });
    const coarsest = Math.max(...filters.map((filter) => filter.shrinkLevel));
    for (let level = 1; level <= coarsest; level++) {
      passes.draw(encoder, "halved", constants, flux, level, { 1: levelView(flux, level - 1) });
    }
    const shown = ([0, 1] as const).map((k) => {
      const { shrinkLevel, weights } = filters[k] as PlaneFilter;
      const texture = this.filtered[k];
      device.queue.writeBuffer(this.weights[k], 0, new Float32Array(weights));
      const bound = { 1: levelView(flux, shrinkLevel), 2: { buffer: this.weights[k] } };
      passes.draw(encoder, "filtered", constants, texture, shrinkLevel, bound);
      return levelView(texture, shrinkLevel);
    }) as [GPUTextureView, GPUTextureView];
    passes.draw(encoder, "blended", constants, this.result.texture, 0, { 3: shown[0], 4: shown[1] });
  }
}
