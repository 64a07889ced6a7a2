// Draws a PEM: twin of reflet.render.renderer, with the screen added.

import type { Camera } from "../camera";
import { PARAMETERIZATIONS } from "../parameterization";
import type { Layer, Pem } from "../pem";
import { type Blended, frameUniform, type Shown } from "./layouts";
import { createPipelines, type Pipelines } from "./pipelines";
import type { ResidentMaps } from "./resident-maps";
import { SceneBuffers } from "./scene-buffers";
import { Target } from "./target";

export const TONE_CURVES = ["exponential", "linear", "neutral"] as const;
export type ToneCurve = (typeof TONE_CURVES)[number];

export interface Tone {
  exposure: number;
  curve: ToneCurve;
}

/** What a frame shows: where from, which maps in which shares, which layers. */
export interface View {
  readonly camera: Camera;
  readonly blend: readonly Blended[];
  readonly shown: Shown;
}

export class Renderer {
  /** Pictures in the sum that `display` shows. */
  pictureCount = 0;
  private target: Target | undefined;
  private readonly screenUniform: GPUBuffer;

  private constructor(
    private readonly device: GPUDevice,
    private readonly pem: Pem,
    private readonly maps: ResidentMaps,
    readonly scene: SceneBuffers,
    private readonly pipelines: Pipelines,
  ) {
    this.screenUniform = device.createBuffer({ size: 32, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  }

  static async create(device: GPUDevice, pem: Pem, maps: ResidentMaps, screen: GPUTextureFormat): Promise<Renderer> {
    const scene = new SceneBuffers(device, pem, maps.arrays);
    const pipelines = await createPipelines(device, scene.layouts.frame, scene.layouts.part, screen, pem.layers);
    return new Renderer(device, pem, maps, scene, pipelines);
  }

  /** Draws four samples a pixel in one pass: the whole sum. */
  drawMultisampled(view: View): void {
    this.pictureCount = 0;
    this.draw(view, 4, 0, true);
  }

  /** Adds the next sub-sample of a picture of `sampleCount` to the sum, emptying it before the first. */
  drawNextSample(view: View, sampleCount: number, first: boolean): void {
    if (first) this.pictureCount = 0;
    this.draw(view, sampleCount, this.pictureCount, false);
  }

  /** Shows the sum. */
  display(screen: GPUTextureView, tone: Tone): void {
    const target = this.target as Target;
    const data = new ArrayBuffer(16);
    new Float32Array(data)[0] = tone.exposure / this.pictureCount;
    new Uint32Array(data).set([TONE_CURVES.indexOf(tone.curve), target.width], 1);
    this.fullScreen(screen, this.pipelines.display, data, { buffer: target.sum });
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
    this.fullScreen(screen, this.pipelines.mapView, data, maps.createView({ dimension: "2d-array" }));
  }

  /** The mean of the pictures in the sum: linear radiance, coverage in alpha, row by row from the top. */
  async read(): Promise<Float32Array> {
    const { sum } = this.target as Target;
    const count = this.pictureCount;
    const copy = this.device.createBuffer({ size: sum.size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = this.device.createCommandEncoder();
    encoder.copyBufferToBuffer(sum, 0, copy, 0, sum.size);
    this.device.queue.submit([encoder.finish()]);
    await copy.mapAsync(GPUMapMode.READ);
    const mean = new Float32Array(copy.getMappedRange()).map((value) => value / count);
    copy.destroy();
    return mean;
  }

  private draw(view: View, sampleCount: number, subSample: number, multi: boolean): void {
    const { camera, blend, shown } = view;
    const target = this.targetFor(camera);
    const data = frameUniform(camera, sampleCount, this.pem.lodBias, blend, shown);
    this.device.queue.writeBuffer(this.scene.frameUniform, 0, data);
    const encoder = this.device.createCommandEncoder();
    if (this.pictureCount === 0) encoder.clearBuffer(target.sum);
    const format = multi ? "rgba16float" : "rgba32float";
    const picture = target.texture(format);
    const pass = encoder.beginRenderPass({
      colorAttachments: [
        multi
          ? {
              view: target.texture(format, 4).createView(),
              resolveTarget: picture.createView(),
              loadOp: "clear",
              storeOp: "discard",
            }
          : { view: picture.createView(), loadOp: "clear", storeOp: "store" },
      ],
      depthStencilAttachment: {
        view: target.texture("depth32float", multi ? 4 : 1).createView(),
        depthClearValue: 0,
        depthLoadOp: "clear",
        depthStoreOp: "discard",
      },
    });
    const kind = multi ? "multi" : "single";
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
    pass.end();
    this.addToSum(encoder, picture, target);
    this.device.queue.submit([encoder.finish()]);
    this.pictureCount += 1;
  }

  private addToSum(encoder: GPUCommandEncoder, picture: GPUTexture, target: Target): void {
    const group = this.device.createBindGroup({
      layout: this.pipelines.accumulate.getBindGroupLayout(0),
      entries: [
        { binding: 0, resource: picture.createView() },
        { binding: 1, resource: { buffer: target.sum } },
      ],
    });
    const pass = encoder.beginComputePass();
    pass.setPipeline(this.pipelines.accumulate);
    pass.setBindGroup(0, group);
    pass.dispatchWorkgroups(Math.ceil(target.width / 8), Math.ceil(target.height / 8));
    pass.end();
  }

  private fullScreen(
    screen: GPUTextureView,
    pipeline: GPURenderPipeline,
    uniform: ArrayBuffer,
    shown: GPUBindingResource,
  ): void {
    this.device.queue.writeBuffer(this.screenUniform, 0, uniform);
    const group = this.device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: [
        { binding: 0, resource: { buffer: this.screenUniform } },
        { binding: 1, resource: shown },
      ],
    });
    const encoder = this.device.createCommandEncoder();
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view: screen, loadOp: "clear", storeOp: "store" }] });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    pass.draw(3);
    pass.end();
    this.device.queue.submit([encoder.finish()]);
  }

  private targetFor({ width, height }: Camera): Target {
    if (this.target?.width !== width || this.target.height !== height) {
      this.target?.destroy();
      this.target = new Target(this.device, width, height);
      this.pictureCount = 0;
    }
    return this.target;
  }
}
