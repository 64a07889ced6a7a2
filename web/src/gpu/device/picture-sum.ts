// The sum of pictures that a frame is made of: drawn into, added up, shown, read back.

import { TONE_CURVES, type Tone } from "../../maths/tone";
import { link } from "./shaders";
import { DEPTH, Target } from "./target";

export class PictureSum {
  /** Pictures in the sum. */
  count = 0;
  private target: Target | undefined;
  private readonly screenUniform: GPUBuffer;

  private constructor(
    private readonly device: GPUDevice,
    private readonly accumulate: GPUComputePipeline,
    private readonly displaySum: GPURenderPipeline,
  ) {
    this.screenUniform = device.createBuffer({ size: 48, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  }

  static async create(device: GPUDevice, screen: GPUTextureFormat): Promise<PictureSum> {
    const summed = device.createBindGroupLayout({
      entries: [
        { binding: 0, visibility: GPUShaderStage.COMPUTE, texture: { sampleType: "unfilterable-float" } },
        { binding: 1, visibility: GPUShaderStage.COMPUTE, buffer: { type: "storage" } },
      ],
    });
    const [accumulate, display] = await Promise.all([
      device.createComputePipelineAsync({
        layout: device.createPipelineLayout({ bindGroupLayouts: [summed] }),
        compute: {
          module: device.createShaderModule({ code: link("accumulate"), label: "accumulate" }),
          entryPoint: "accumulate",
        },
      }),
      createScreenPipeline(device, "display", "vertex_display", "display_sum", screen),
    ]);
    return new PictureSum(device, accumulate, display);
  }

  /**
   * Adds one picture, emptying the sum before the first: `draw` fills a pass into textures cleared to a colour, of four
   * samples a pixel in half float or of one in full. Depth is reversed.
   */
  add(
    { width, height }: { readonly width: number; readonly height: number },
    first: boolean,
    multi: boolean,
    clearValue: GPUColor,
    draw: (pass: GPURenderPassEncoder) => void,
  ): void {
    const target = this.sized(width, height);
    if (first) this.count = 0;
    const encoder = this.device.createCommandEncoder();
    if (this.count === 0) encoder.clearBuffer(target.sum);
    const format = multi ? "rgba16float" : "rgba32float";
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
    draw(pass);
    pass.end();
    this.sumUp(encoder, picture, target);
    this.device.queue.submit([encoder.finish()]);
    this.count += 1;
  }

  /** Shows the mean. */
  display(screen: GPUTextureView, tone: Tone): void {
    const target = this.target as Target;
    const data = new ArrayBuffer(16);
    new Float32Array(data)[0] = tone.exposure / this.count;
    new Uint32Array(data).set([TONE_CURVES.indexOf(tone.curve), target.width], 1);
    this.fillScreen(screen, this.displaySum, data, { buffer: target.sum });
  }

  /** Fills the screen by a pipeline that reads a uniform and one resource. */
  fillScreen(
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

  /** The mean of the pictures: linear radiance, coverage in alpha, row by row from the top. */
  async read(): Promise<Float32Array> {
    const { sum } = this.target as Target;
    const { count } = this;
    const copy = this.device.createBuffer({ size: sum.size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = this.device.createCommandEncoder();
    encoder.copyBufferToBuffer(sum, 0, copy, 0, sum.size);
    this.device.queue.submit([encoder.finish()]);
    await copy.mapAsync(GPUMapMode.READ);
    const mean = new Float32Array(copy.getMappedRange()).map((value) => value / count);
    copy.destroy();
    return mean;
  }

  private sumUp(encoder: GPUCommandEncoder, picture: GPUTexture, target: Target): void {
    const group = this.device.createBindGroup({
      layout: this.accumulate.getBindGroupLayout(0),
      entries: [
        { binding: 0, resource: picture.createView() },
        { binding: 1, resource: { buffer: target.sum } },
      ],
    });
    const pass = encoder.beginComputePass();
    pass.setPipeline(this.accumulate);
    pass.setBindGroup(0, group);
    pass.dispatchWorkgroups(Math.ceil(target.width / 8), Math.ceil(target.height / 8));
    pass.end();
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
