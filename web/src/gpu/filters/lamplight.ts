// An environment with a lamp in it, and its diffuse light, as often as the lamp changes: twin of reflet.render.filters.lamp, and
// of what reflet.render.filters.live_environment makes of it.

import type { Lamp } from "../../scene/lamp";
import { createEnvMap, type EnvMapTexture, levelView } from "../maps/env-map";
import { FacePasses } from "../maps/face-passes";
import { ProbePyramid } from "./probe-pyramid";

const HALF: GPUTextureFormat = "rgba16float";
const LAMP_BYTES = 32;
const PYRAMID_ROWS = 64; // of what diffuse light is summed from
const DIFFUSE_ROWS = 16;

/** A light: an environment, and the radiance of white diffuse surfaces in it by their normal. */
export interface Light {
  readonly environment: EnvMapTexture; // a half-float cube
  readonly diffuse: EnvMapTexture;
}

export class Lamplight implements Light {
  readonly environment: EnvMapTexture;
  readonly diffuse: EnvMapTexture;
  private readonly painting: FacePasses;
  private readonly uniform: GPUBuffer;
  private readonly pyramid: ProbePyramid;

  /** Adds lamps to this cube. */
  constructor(
    private readonly device: GPUDevice,
    private readonly alone: EnvMapTexture,
  ) {
    this.painting = new FacePasses(device, "lamp");
    this.uniform = device.createBuffer({ size: LAMP_BYTES, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    this.environment = createEnvMap(device, "cube", alone.size, alone.texture.mipLevelCount, HALF);
    this.pyramid = new ProbePyramid(device, PYRAMID_ROWS);
    this.diffuse = createEnvMap(device, "cube", DIFFUSE_ROWS, 1, HALF);
  }

  /** The passes that show this lamp. One a submission. */
  show(encoder: GPUCommandEncoder, { direction, squareChord, radiance }: Lamp): void {
    const data = new Float32Array([...direction, squareChord, ...radiance, 0]);
    this.device.queue.writeBuffer(this.uniform, 0, data);
    this.paint(encoder);
    this.pyramid.fill(encoder, this.environment.texture);
    this.pyramid.diffuse(encoder, this.diffuse);
  }

  private paint(encoder: GPUCommandEncoder): void {
    const { texture, size } = this.environment;
    for (let level = 0; level < texture.mipLevelCount; level++) {
      const bound: Record<number, GPUBindingResource> = {
        0: levelView(this.alone.texture, level),
        2: { buffer: this.uniform },
      };
      if (level > 0) bound[1] = levelView(texture, level - 1);
      const entryPoint = level > 0 ? "coarser" : "finest";
      this.painting.draw(encoder, entryPoint, { SIZE: size >> level }, texture, level, bound);
    }
  }
}
