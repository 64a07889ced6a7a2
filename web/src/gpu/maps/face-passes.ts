// Passes that fill maps, face by face, from others: what prefilters are made of.

import { link } from "../device/shaders";
import { faceView } from "./env-map";

export class FacePasses {
  private readonly module: GPUShaderModule;
  private readonly pipelines = new Map<string, GPURenderPipeline>();

  constructor(
    private readonly device: GPUDevice,
    program: string,
  ) {
    this.module = device.createShaderModule({ code: link(program), label: program });
  }

  /** Fills a level of all faces of a texture by an entry point that reads these resources, by binding. */
  draw(
    encoder: GPUCommandEncoder,
    entryPoint: string,
    constants: Record<string, number>,
    texture: GPUTexture,
    mipLevel: number,
    bound: Record<number, GPUBindingResource>,
  ): void {
    const pipeline = this.pipeline(entryPoint, constants, texture.format);
    const group = this.device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: Object.entries(bound).map(([binding, resource]) => ({ binding: Number(binding), resource })),
    });
    for (let face = 0; face < texture.depthOrArrayLayers; face++) {
      const pass = encoder.beginRenderPass({
        colorAttachments: [{ view: faceView(texture, face, mipLevel), loadOp: "clear", storeOp: "store" }],
      });
      pass.setPipeline(pipeline);
      pass.setBindGroup(0, group);
      pass.draw(3, 1, 0, face);
      pass.end();
    }
  }

  private pipeline(entryPoint: string, constants: Record<string, number>, format: GPUTextureFormat): GPURenderPipeline {
    const key = JSON.stringify([entryPoint, constants, format]);
    let pipeline = this.pipelines.get(key);
    if (pipeline === undefined) {
      const { module } = this;
      pipeline = this.device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "vertex_face" },
        fragment: { module, entryPoint, constants, targets: [{ format }] },
      });
      this.pipelines.set(key, pipeline);
    }
    return pipeline;
  }
}
