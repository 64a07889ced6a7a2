// The sum of pictures that a frame is made of: drawn into, added up, shown, read back.

import type { Adaptive } from "../../maths/sample-pattern";
import { TONE_CURVES, type Tone } from "../../maths/tone";
import { link } from "./shaders";
import { DEPTH, Target } from "./target";

const PICTURE: GPUTextureFormat = "rgba32float"; // of one sample a pixel

interface Pipelines {
  readonly accumulate: GPUComputePipeline;
  readonly accumulateSpread: GPUComputePipeline;
  readonly decide: GPUComputePipeline;
  readonly enough: GPURenderPipeline;
  readonly display: GPURenderPipeline;
}

/** Samples where they count, as seen on a screen. */
export interface Spared extends Adaptive {
  readonly tone: Tone;
}

export class PictureSum {
  /** Pictures in the sum. */
  count = 0;
  private target: Target | undefined;
  private readonly screenUniform: GPUBuffer;
  private readonly criterion: GPUBuffer;

  private constructor(
    private readonly device: GPUDevice,
    private readonly pipelines: Pipelines,
  ) {
    const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
    this.screenUniform = device.createBuffer({ size: 48, usage });
    this.criterion = device.createBuffer({ size: 16, usage });
  }

  static async create(device: GPUDevice, screen: GPUTextureFormat): Promise<PictureSum> {
    const module = device.createShaderModule({ code: link("accumulate"), label: "accumulate" });
    const computed = (entryPoint: string) =>
      device.createComputePipelineAsync({ layout: "auto", compute: { module, entryPoint } });
    const [accumulate, accumulateSpread, decide, enough, display] = await Promise.all([
      computed("accumulate"),
      computed("accumulate_spread"),
      computed("decide"),
      createEnoughPipeline(device),
      createScreenPipeline(device, "display", "vertex_display", "display_sum", screen),
    ]);
    return new PictureSum(device, { accumulate, accumulateSpread, decide, enough, display });
  }

  /**
   * Adds one picture, emptying the sum before the first: `draw` fills a pass into textures cleared to a colour, of four
   * samples a pixel in half float or of one in full. Depth is reversed. Where samples are `spared` nothing is drawn any more
   * once a pixel has enough; the clear colour, which is added then, must be 0.
   */
  add(
    { width, height }: { readonly width: number; readonly height: number },
    first: boolean,
    multi: boolean,
    clearValue: GPUColor,
    draw: (pass: GPURenderPassEncoder) => void,
    spared?: Spared,
  ): void {
    const target = this.sized(width, height);
    if (first) this.count = 0;
    const encoder = this.device.createCommandEncoder();
    if (this.count === 0) this.begin(encoder, target, spared);
    const format = multi ? "rgba16float" : PICTURE;
    const picture = target.texture(format);
    const pass = encoder.beginRenderPass({
      colorAttachments: [
        multi
          ? {
              view: target.texture(format, 4).createView(),
              resolveTarget: picture.createView(),
              clearValue,
              loadOp: "clear",
              storeOp: "discard",
            }
          : { view: picture.createView(), clearValue, loadOp: "clear", storeOp: "store" },
      ],
      depthStencilAttachment: {
        view: target.texture(DEPTH, multi ? 4 : 1).createView(),
        depthClearValue: 0,
        depthLoadOp: "clear",
        depthStoreOp: "discard",
      },
    });
    const decided = spared && this.count >= spared.first;
    if (decided) this.keepOut(pass, target);
    draw(pass);
    pass.end();
    this.sumUp(encoder, picture, target, spared !== undefined && !decided);
    if (this.count + 1 === spared?.first) this.decide(encoder, target);
    this.device.queue.submit([encoder.finish()]);
    this.count += 1;
  }

  /** Shows the mean. */
  display(screen: GPUTextureView, tone: Tone): void {
    const target = this.target as Target;
    const uniform = toneUniform(tone, target.width, this.count);
    this.fillScreen(screen, this.pipelines.display, uniform, { buffer: target.sum }, { buffer: target.enough });
  }

  /** Fills the screen by a pipeline that reads a uniform and other resources. */
  fillScreen(
    screen: GPUTextureView,
    pipeline: GPURenderPipeline,
    uniform: ArrayBuffer,
    ...shown: GPUBindingResource[]
  ): void {
    this.device.queue.writeBuffer(this.screenUniform, 0, uniform);
    const group = this.group(pipeline, [{ buffer: this.screenUniform }, ...shown]);
    const encoder = this.device.createCommandEncoder();
    const pass = encoder.beginRenderPass({ colorAttachments: [{ view: screen, loadOp: "clear", storeOp: "store" }] });
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    pass.draw(3);
    pass.end();
    this.device.queue.submit([encoder.finish()]);
  }

  /** The mean of the pictures: linear radiance, coverage in alpha, row by row from the top. */
  async read(): Promise<Float32Array> {
    const { sum, enough } = this.target as Target;
    const { count } = this;
    const usage = GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST;
    const copy = this.device.createBuffer({ size: sum.size + enough.size, usage });
    const encoder = this.device.createCommandEncoder();
    encoder.copyBufferToBuffer(sum, 0, copy, 0, sum.size);
    encoder.copyBufferToBuffer(enough, 0, copy, sum.size, enough.size);
    this.device.queue.submit([encoder.finish()]);
    await copy.mapAsync(GPUMapMode.READ);
    const counts = new Uint32Array(copy.getMappedRange(sum.size));
    const mean = new Float32Array(copy.getMappedRange(0, sum.size)).map(
      (value, k) => value / (counts[k >> 2] || count),
    );
    copy.destroy();
    return mean;
  }

  private begin(encoder: GPUCommandEncoder, target: Target, spared: Spared | undefined): void {
    encoder.clearBuffer(target.sum);
    encoder.clearBuffer(target.enough);
    if (spared === undefined) return;
    encoder.clearBuffer(target.spread);
    this.device.queue.writeBuffer(this.criterion, 0, toneUniform(spared.tone, target.width, spared.first));
  }

  private keepOut(pass: GPURenderPassEncoder, target: Target): void {
    const { enough } = this.pipelines;
    pass.setPipeline(enough);
    pass.setBindGroup(0, this.group(enough, [{ buffer: this.criterion }, { buffer: target.enough }]));
    pass.draw(3);
  }

  private sumUp(encoder: GPUCommandEncoder, picture: GPUTexture, target: Target, spread: boolean): void {
    const { accumulate, accumulateSpread } = this.pipelines;
    const bound = [picture.createView(), { buffer: target.sum }];
    const kept = spread ? [{ buffer: this.criterion }, { buffer: target.spread }] : [];
    this.dispatch(encoder, spread ? accumulateSpread : accumulate, [...bound, ...kept], target);
  }

  private decide(encoder: GPUCommandEncoder, target: Target): void {
    const bound = [this.criterion, target.spread, target.enough].map((buffer) => ({ buffer }));
    this.dispatch(encoder, this.pipelines.decide, bound, target, 2);
  }

  private dispatch(
    encoder: GPUCommandEncoder,
    pipeline: GPUComputePipeline,
    bound: readonly GPUBindingResource[],
    target: Target,
    firstBinding = 0,
  ): void {
    const pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, this.group(pipeline, bound, firstBinding));
    pass.dispatchWorkgroups(Math.ceil(target.width / 8), Math.ceil(target.height / 8));
    pass.end();
  }

  private group(
    pipeline: GPUComputePipeline | GPURenderPipeline,
    bound: readonly GPUBindingResource[],
    firstBinding = 0,
  ): GPUBindGroup {
    return this.device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: bound.map((resource, k) => ({ binding: firstBinding + k, resource })),
    });
  }

  private sized(width: number, height: number): Target {
    if (this.target?.width !== width || this.target.height !== height) {
      this.target?.destroy();
      this.target = new Target(this.device, width, height);
      this.count = 0;
    }
    return this.target;
  }
}

/** The uniform of accumulate.wgsl, enough.wgsl and display.wgsl. */
function toneUniform(tone: Tone, width: number, count: number): ArrayBuffer {
  const data = new ArrayBuffer(16);
  new Float32Array(data)[0] = tone.exposure;
  new Uint32Array(data).set([TONE_CURVES.indexOf(tone.curve), width, count], 1);
  return data;
}

/** Keeps what has enough samples out of a pass. */
function createEnoughPipeline(device: GPUDevice): Promise<GPURenderPipeline> {
  const module = device.createShaderModule({ code: link("enough"), label: "enough" });
  return device.createRenderPipelineAsync({
    layout: "auto",
    vertex: { module, entryPoint: "vertex_enough" },
    fragment: { module, entryPoint: "enough_single", targets: [{ format: PICTURE, writeMask: 0 }] },
    depthStencil: { format: DEPTH, depthWriteEnabled: true, depthCompare: "always" },
  });
}

/** A pipeline that fills the screen. */
export function createScreenPipeline(
  device: GPUDevice,
  program: string,
  vertex: string,
  fragment: string,
  screen: GPUTextureFormat,
): Promise<GPURenderPipeline> {
  const module = device.createShaderModule({ code: link(program), label: program });
  return device.createRenderPipelineAsync({
    layout: "auto",
    vertex: { module, entryPoint: vertex },
    fragment: { module, entryPoint: fragment, targets: [{ format: screen }] },
  });
}
