// Pipelines that draw a mesh before an env map, and that map behind it: twin of reflet.render.materials.material_programs.

import { PARAMETERIZATIONS, type ParameterizationName } from "../../maths/parameterization";
import { LOOKUPS, type LookupDirection } from "../../scene/material";
import { link } from "../device/shaders";
import { DEPTH } from "../device/target";
import { byHardware, type EnvMapGroup, type EnvMapTexture, envMapLayout } from "../maps/env-map";

/** What the mesh's pipelines are built for, beside its map. */
export interface MeshVariant {
  readonly diffuseMap: ParameterizationName | undefined; // of the diffuse map, where it is used
  readonly lookup: LookupDirection;
  readonly byLobes: boolean; // whether the map holds a BRDF's lobes
}

type Program = "mesh" | "lobes" | "backdrop";

export class MaterialPrograms {
  readonly viewLayout: GPUBindGroupLayout;
  readonly mapLayout: GPUBindGroupLayout;
  readonly materialLayout: GPUBindGroupLayout;
  private readonly module: GPUShaderModule;
  private readonly pipelines = new Map<string, GPURenderPipeline>();

  constructor(private readonly device: GPUDevice) {
    const { VERTEX, FRAGMENT } = GPUShaderStage;
    this.module = device.createShaderModule({ code: link("material_picture"), label: "material_picture" });
    this.viewLayout = device.createBindGroupLayout({
      entries: [
        { binding: 0, visibility: VERTEX | FRAGMENT, buffer: {} },
        { binding: 1, visibility: VERTEX, buffer: { type: "read-only-storage" } },
      ],
    });
    this.mapLayout = envMapLayout(device);
    const table = (viewDimension: GPUTextureViewDimension): GPUTextureBindingLayout => ({
      sampleType: "unfilterable-float",
      viewDimension,
    });
    this.materialLayout = device.createBindGroupLayout({
      entries: [
        { binding: 0, visibility: FRAGMENT, buffer: {} },
        { binding: 1, visibility: FRAGMENT, texture: table("2d-array") },
        { binding: 2, visibility: FRAGMENT, texture: table("2d") },
      ],
    });
  }

  /** Sets what draws a mesh that looks up this map; its first bind group is set. */
  setMesh(
    pass: GPURenderPassEncoder,
    map: EnvMapGroup,
    material: GPUBindGroup,
    { diffuseMap, lookup, byLobes }: MeshVariant,
    multi: boolean,
  ): void {
    pass.setPipeline(
      this.pipeline(byLobes ? "lobes" : "mesh", multi, {
        ...mapConstants(map.map),
        DIFFUSES: diffuseMap ? 1 : 0,
        DIFFUSE_KIND: diffuseMap ? PARAMETERIZATIONS[diffuseMap].kind : 0,
        LOOKUP: LOOKUPS.indexOf(lookup),
      }),
    );
    pass.setBindGroup(1, map.group);
    pass.setBindGroup(2, material);
  }

  /** Draws a map behind everything; the first bind group is set. */
  drawBackdrop(pass: GPURenderPassEncoder, map: EnvMapGroup, multi: boolean): void {
    pass.setPipeline(this.pipeline("backdrop", multi, mapConstants(map.map)));
    pass.setBindGroup(1, map.group);
    pass.draw(3);
  }

  private pipeline(what: Program, multi: boolean, constants: Record<string, number>): GPURenderPipeline {
    const key = JSON.stringify([what, multi, constants]);
    let pipeline = this.pipelines.get(key);
    if (pipeline === undefined) {
      pipeline = this.build(what, multi, constants);
      this.pipelines.set(key, pipeline);
    }
    return pipeline;
  }

  private build(what: Program, multi: boolean, constants: Record<string, number>): GPURenderPipeline {
    const mesh = what !== "backdrop";
    const groups = [this.viewLayout, this.mapLayout, ...(mesh ? [this.materialLayout] : [])];
    return this.device.createRenderPipeline({
      label: `material ${what}`,
      layout: this.device.createPipelineLayout({ bindGroupLayouts: groups }),
      vertex: {
        module: this.module,
        entryPoint: mesh ? "vertex_material" : "vertex_backdrop",
        buffers: mesh ? [VERTICES] : [],
      },
      fragment: {
        module: this.module,
        entryPoint: `material_${what}`,
        constants,
        targets: [{ format: multi ? "rgba16float" : "rgba32float" }],
      },
      multisample: { count: multi ? 4 : 1 },
      depthStencil: {
        format: DEPTH,
        depthWriteEnabled: mesh,
        depthCompare: mesh ? "greater" : "greater-equal",
      },
    });
  }
}

/** Floats of a vertex: position, normal, uv. */
export const VERTEX_FLOATS = 8;

const VERTICES: GPUVertexBufferLayout = {
  arrayStride: 4 * VERTEX_FLOATS,
  attributes: [
    { shaderLocation: 0, offset: 0, format: "float32x3" },
    { shaderLocation: 1, offset: 12, format: "float32x3" },
    { shaderLocation: 2, offset: 24, format: "float32x2" },
  ],
};

const mapConstants = (map: EnvMapTexture): Record<string, number> => ({
  KIND: PARAMETERIZATIONS[map.parameterization].kind,
  BY_HARDWARE: byHardware(map) ? 1 : 0,
});
