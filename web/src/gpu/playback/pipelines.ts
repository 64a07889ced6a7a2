// All pipelines of PEM playback, compiled once when the viewer opens.

import { PARAMETERIZATIONS } from "../../maths/parameterization";
import type { Pem } from "../../scene/pem";
import type { Stack } from "../../scene/stacks";
import { createScreenPipeline } from "../device/picture-sum";
import { link } from "../device/shaders";
import { DEPTH } from "../device/target";
import { HAS_LOCAL, partBits, REFRACTIVE } from "./layouts";
import { lightCount } from "./punctual-lights";

export interface Pipelines {
  /** Pictures of one sub-sample a pixel into rgba32float, exact, and of four at once into rgba16float, on the fast path. */
  readonly picture: { readonly single: GPURenderPipeline; readonly multi: GPURenderPipeline };
  /** The same of mirrors: they may meet each other. */
  readonly mirrors: { readonly single: GPURenderPipeline; readonly multi: GPURenderPipeline };
  readonly backdrop: { readonly single: GPURenderPipeline; readonly multi: GPURenderPipeline };
  readonly mapView: GPURenderPipeline;
}

export async function createPipelines(
  device: GPUDevice,
  frame: GPUBindGroupLayout,
  part: GPUBindGroupLayout,
  screen: GPUTextureFormat,
  pem: Pem,
  stacks: readonly Stack[],
  hitBits: number,
): Promise<Pipelines> {
  const module = (name: string) => device.createShaderModule({ code: link(name), label: name });
  const picture = module("picture");
  const backdrop = module("backdrop");

  // Code for other parameterizations than the layers' own, for more shells or a base costs nothing then.
  const constants: Record<string, number> = {};
  for (const kind of ["distant", "local"] as const) {
    const names = new Set(stacks.filter((stack) => stack.kind === kind).map(({ shape }) => shape.parameterization));
    const [name = "cube"] = names;
    if (names.size <= 1) constants[`${kind.toUpperCase()}_PARAMETERIZATION`] = PARAMETERIZATIONS[name].kind;
  }
  const counts = new Set(stacks.filter(({ kind }) => kind === "distant").map(({ layers }) => layers.length));
  const [count = 0] = counts;
  if (counts.size <= 1) constants.SHELL_COUNT = count; // parts that do not reflect never ask
  if (pem.base.length === 0) constants.BASE = 0;
  constants.LIGHT_COUNT = lightCount(pem);
  constants.ANY_BITS = pem.parts.reduce((bits, part) => bits | partBits(part), HAS_LOCAL);

  const traced = pem.traced && {
    shader: module("traced_picture"),
    constants: { ...constants, MOST_HITS: pem.traced.mostHits, HIT_BITS: hitBits },
  };
  // Where mirrors have pipelines of their own, the others' need no code of theirs; that of glass changes diffuse light too.
  if (traced) {
    constants.ANY_BITS = pem.parts.reduce((bits, part) => {
      const its = partBits(part);
      return bits | (part.reflective ? its & REFRACTIVE : its);
    }, 0);
  }

  const drawn = (shader: GPUShaderModule, name: "picture" | "backdrop", multi: boolean, its = constants) =>
    device.createRenderPipelineAsync({
      layout: device.createPipelineLayout({ bindGroupLayouts: name === "picture" ? [frame, part] : [frame] }),
      vertex: {
        module: shader,
        entryPoint: name === "backdrop" ? "vertex_backdrop" : multi ? "vertex_multi_fast" : "vertex_single",
      },
      fragment: {
        module: shader,
        entryPoint: `${name}_${!multi ? "single" : name === "picture" ? "multi_fast" : "multi"}`,
        targets: [{ format: multi ? "rgba16float" : "rgba32float" }],
        ...(name === "picture" ? { constants: its } : {}),
      },
      multisample: { count: multi ? 4 : 1 },
      depthStencil: {
        format: DEPTH,
        depthWriteEnabled: name === "picture",
        depthCompare: name === "picture" ? "greater" : "greater-equal",
      },
    });

  const mirrors =
    traced &&
    Promise.all([false, true].map((multi) => drawn(traced.shader, "picture", multi, traced.constants))).then(
      ([single, multi]) => ({ single: single as GPURenderPipeline, multi: multi as GPURenderPipeline }),
    );
  const [single, multi, backdropSingle, backdropMulti, mapView] = await Promise.all([
    drawn(picture, "picture", false),
    drawn(picture, "picture", true),
    drawn(backdrop, "backdrop", false),
    drawn(backdrop, "backdrop", true),
    createScreenPipeline(device, "map_view", "vertex_map_view", "map_view", screen),
  ]);
  return {
    picture: { single, multi },
    mirrors: (await mirrors) ?? { single, multi },
    backdrop: { single: backdropSingle, multi: backdropMulti },
    mapView,
  };
}
