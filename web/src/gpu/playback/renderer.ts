// Draws a PEM: twin of reflet.render.playback.renderer, with the flat view of its maps added.

import type { Camera } from "../../maths/camera";
import { PARAMETERIZATIONS } from "../../maths/parameterization";
import { TONE_CURVES, type Tone } from "../../maths/tone";
import type { Layer, Pem, Shown } from "../../scene/pem";
import { PictureSum } from "../device/picture-sum";
import { type Blended, frameUniform } from "./layouts";
import { createPipelines, type Pipelines } from "./pipelines";
import type { ResidentMaps } from "./resident-maps";
import { SceneBuffers } from "./scene-buffers";

/** What a frame shows: where from, which maps in which shares, which layers. */
export interface View {
  readonly camera: Camera;
  readonly blend: readonly Blended[];
  readonly shown: Shown;
}

const NOTHING: GPUColor = { r: 0, g: 0, b: 0, a: 0 };

export class Renderer {
  private constructor(
    private readonly device: GPUDevice,
    private readonly pem: Pem,
    private readonly maps: ResidentMaps,
    readonly scene: SceneBuffers,
    private readonly pipelines: Pipelines,
    readonly sum: PictureSum,
  ) {}

  static async create(device: GPUDevice, pem: Pem, maps: ResidentMaps, screen: GPUTextureFormat): Promise<Renderer> {
    const scene = new SceneBuffers(device, pem, maps.arrays);
    const [pipelines, sum] = await Promise.all([
      createPipelines(device, scene.layouts.frame, scene.layouts.part, screen, pem.layers),
      PictureSum.create(device, screen),
    ]);
    return new Renderer(device, pem, maps, scene, pipelines, sum);
  }

  /** Draws four samples a pixel in one pass: the whole sum. */
  drawMultisampled(view: View): void {
    this.draw(view, 4, 0, true);
  }

  /** Adds the next sub-sample of a picture of `sampleCount` to the sum, emptying it before the first. */
  drawNextSample(view: View, sampleCount: number, first: boolean): void {
    this.draw(view, sampleCount, first ? 0 : this.sum.count, false);
  }

  /** Shows one layer's map in a slot, all faces and levels, as in [Hakura01, Figure 5]. */
  displayMap(screen: GPUTextureView, tone: Tone, layer: number, slot: number, width: number, height: number): void {
    const maps = this.maps.arrays[layer] as GPUTexture;
    const { faceCount, aspect } = PARAMETERIZATIONS[(this.pem.layers[layer] as Layer).parameterization];
    const across = faceCount * aspect;
    const faceSize = Math.min(width / (across + 0.5), height / 2.5);
    const data = new ArrayBuffer(32);
    const origin = [(width - across * faceSize) / 2, (height - 2 * faceSize) / 2].map(Math.round);
    new Float32Array(data).set([...origin, faceSize, tone.exposure]);
    new Uint32Array(data).set([TONE_CURVES.indexOf(tone.curve), slot, maps.mipLevelCount, faceCount], 4);
    this.sum.fillScreen(screen, this.pipelines.mapView, data, maps.createView({ dimension: "2d-array" }));
  }

  private draw(view: View, sampleCount: number, subSample: number, multi: boolean): void {
    const { camera, blend, shown } = view;
    const data = frameUniform(camera, sampleCount, this.pem.lodBias, blend, shown);
    this.device.queue.writeBuffer(this.scene.frameUniform, 0, data);
    const kind = multi ? "multi" : "single";
    this.sum.add(camera, subSample === 0, multi, NOTHING, (pass) => {
      pass.setPipeline(this.pipelines.picture[kind]);
      pass.setBindGroup(0, this.scene.frameGroup);
      this.scene.partGroups.forEach((group, part) => {
        const [first, end] = this.scene.triangleOffsets.slice(part, part + 2) as [number, number];
        pass.setBindGroup(1, group);
        pass.draw(3 * (end - first), 1, 3 * first, subSample);
      });
      if (this.pem.environment) {
        pass.setPipeline(this.pipelines.backdrop[kind]);
        pass.draw(3, 1, 0, subSample);
      }
    });
  }
}
