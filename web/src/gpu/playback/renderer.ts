// Draws a PEM: twin of reflet.render.playback.renderer, with the flat view of its maps added.

import { nearestInverse } from "../../maths/geometry";
import { PARAMETERIZATIONS } from "../../maths/parameterization";
import type { Samples } from "../../maths/sample-pattern";
import { NORMAL_EXPOSURE, TONE_CURVES, type Tone } from "../../maths/tone";
import { lodBiasAt, type MapShows, type Pem } from "../../scene/pem";
import type { Stack } from "../../scene/stacks";
import { PictureSum, type Spared } from "../device/picture-sum";
import { frameUniform } from "./layouts";
import { createPipelines, type Pipelines } from "./pipelines";
import type { ResidentMaps } from "./resident-maps";
import { SceneBuffers } from "./scene-buffers";
import type { View } from "./view";

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
    const scene = new SceneBuffers(device, pem, maps.stacks, maps.arrays);
    const [pipelines, sum] = await Promise.all([
      createPipelines(device, scene.layouts.frame, scene.layouts.part, screen, pem, maps.stacks, scene.hitBits),
      PictureSum.create(device, screen),
    ]);
    return new Renderer(device, pem, maps, scene, pipelines, sum);
  }

  /** Draws four samples a pixel in one pass: the whole sum. */
  drawMultisampled(view: View): void {
    this.draw(view, 4, 0, true);
  }

  /**
   * Adds the next sub-sample of a picture of `samples` to the sum, emptying it before the first. Where they count depends on
   * how it is shown.
   */
  drawNextSample(view: View, samples: Samples, first: boolean, tone: Tone): void {
    const subSample = first ? 0 : this.sum.count;
    if (typeof samples === "number") this.draw(view, samples, subSample, false);
    else {
      // Those beyond the first have the LODs of the most.
      const sampleCount = subSample < samples.first ? samples.first : samples.most;
      this.draw(view, sampleCount, subSample, false, { ...samples, tone });
    }
  }

  /**
   * Shows one layer's map in a slot, all faces and levels, as in [Hakura01, Figure 5]: its radiance over a board, its
   * alpha, or the relief that it is looked up on, which has one level.
   */
  displayMap(
    screen: GPUTextureView,
    tone: Tone,
    layer: number,
    slot: number,
    shows: MapShows,
    width: number,
    height: number,
  ): void {
    const number = this.maps.stacks.findIndex(({ layers }) => layers.includes(layer));
    const { layers, shape } = this.maps.stacks[number] as Stack;
    const relief = this.pem.layers[layer]?.geometry;
    const ofRelief = shows === "distance" && relief?.kind === "relief";
    const maps = (ofRelief ? this.scene.reliefs : this.maps.arrays)[number] as GPUTexture;
    const { faceCount, aspect } = PARAMETERIZATIONS[ofRelief ? "cube" : shape.parameterization];
    const across = faceCount * aspect;
    const faceSize = Math.min(width / (across + 0.5), height / 2.5);
    const shell = layers.indexOf(layer);
    const data = new ArrayBuffer(48);
    const origin = [(width - across * faceSize) / 2, (height - 2 * faceSize) / 2].map(Math.round);
    // Of the distances' inverses the largest is white, at normal exposure.
    const brightness = ofRelief ? 1 / (NORMAL_EXPOSURE * nearestInverse(relief)) : 1;
    new Float32Array(data).set([...origin, faceSize, brightness * tone.exposure]);
    new Uint32Array(data).set(
      [
        TONE_CURVES.indexOf(tone.curve),
        ofRelief ? shell : slot * layers.length + shell,
        maps.mipLevelCount,
        faceCount,
        ofRelief ? 2 : Number(shows === "alpha"),
      ],
      4,
    );
    this.sum.fillScreen(screen, this.pipelines.mapView, data, maps.createView({ dimension: "2d-array" }));
  }

  private draw(view: View, sampleCount: number, subSample: number, multi: boolean, spared?: Spared): void {
    const data = frameUniform(view, sampleCount, lodBiasAt(this.pem, sampleCount));
    this.device.queue.writeBuffer(this.scene.frameUniform, 0, data);
    const kind = multi ? "multi" : "single";
    const draw = (pass: GPURenderPassEncoder) => {
      pass.setBindGroup(0, this.scene.frameGroup);
      this.scene.partGroups.forEach((group, part) => {
        const [first, end] = this.scene.triangleOffsets.slice(part, part + 2) as [number, number];
        pass.setPipeline(this.pipelines[this.pem.parts[part]?.reflective ? "mirrors" : "picture"][kind]);
        pass.setBindGroup(1, group);
        pass.draw(3 * (end - first), 1, 3 * first, subSample);
      });
      if (this.pem.environment) {
        pass.setPipeline(this.pipelines.backdrop[kind]);
        pass.draw(3, 1, 0, subSample);
      }
    };
    this.sum.add(view.camera, subSample === 0, multi, NOTHING, draw, spared);
  }
}
