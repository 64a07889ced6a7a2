// The host's side of the shaders' bind groups, described in frame.wgsl and part.wgsl: twin of reflet.render.playback.layouts.

import type { Part } from "../../files/gltf";
import { clipFromWorld, pixelFromView, rayBasis } from "../../maths/camera";
import { type Geometry, pack } from "../../maths/geometry";
import { PARAMETERIZATIONS } from "../../maths/parameterization";
import { samplePositions } from "../../maths/sample-pattern";
import type { Layer, Shown } from "../../scene/pem";
import type { View } from "./view";

const SWITCHES: Record<keyof Shown, number> = { diffuse: 1, fresnel: 2, distant: 4, local: 8 };

const HIDE_SHELL = 32; // the nearest; the others' bits follow

export const TRIANGLE_ON_HULL = 1;
const LARGEST_BLEND = 8; // behind them in the frame's arrays stands the base
export const FRAME_BYTES = 1856;
export const PART_BYTES = 304;

const [REFLECTIVE, DOUBLE_SIDED, HAS_LOCAL] = [1, 2, 4];
const [BASE_COLOR_TEXTURE, METALLIC_ROUGHNESS_TEXTURE, NORMAL_TEXTURE, EMISSION_TEXTURE] = [8, 16, 32, 64];
const [BASE_COLOR_CLAMPS, METALLIC_ROUGHNESS_CLAMPS, NORMAL_CLAMPS, METAL] = [128, 256, 512, 1024];

export function frameUniform(view: View, sampleCount: number, lodBias: number): ArrayBuffer {
  const { camera, blend, base, shown, hiddenShells } = view;
  const data = new ArrayBuffer(FRAME_BYTES);
  const floats = new Float32Array(data);
  const basis = rayBasis(camera);
  const { corner, dx, dy } = basis;
  floats.set(clipFromWorld(camera), 0);
  floats.set([...camera.position, lodBias], 16);
  floats.set([...corner, -0.5 * Math.log2(sampleCount)], 20);
  floats.set([...dx, camera.width], 24);
  floats.set([...dy, camera.height], 28);
  samplePositions(sampleCount).forEach((position, k) => {
    floats.set(position, 32 + 4 * k);
  });
  for (const [k, { slot, weight, mapFromWorld }] of [...blend.entries(), [LARGEST_BLEND, base] as const]) {
    floats.set([weight, slot], 288 + 4 * k);
    mapFromWorld.forEach((row, i) => {
      row.forEach((value, column) => {
        floats[356 + 12 * k + 4 * column + i] = value;
      });
    });
  }
  // What float32 rounds off stands 16 bytes a vector later on: the exact path reckons with both.
  const rest = (values: readonly number[]) => values.map((value) => value - Math.fround(value));
  floats.set(rest(camera.position), 328);
  pixelFromView(basis).forEach((row, k) => {
    floats.set(row, 332 + 4 * k);
    floats.set(rest(row), 344 + 4 * k);
  });
  const bits = [
    ...(Object.keys(SWITCHES) as (keyof Shown)[]).filter((name) => shown[name]).map((name) => SWITCHES[name]),
    ...hiddenShells.map((shell) => HIDE_SHELL << shell),
  ];
  const switches = bits.reduce((sum, bit) => sum | bit, 0);
  new Uint32Array(data).set([blend.length, switches], 324);
  return data;
}

/** A layer as a part looks it up; the geometry may be another than the maps were inferred with. */
export interface BoundLayer {
  readonly layer: Layer;
  readonly geometry: Geometry;
}

/** The nearest shell first. */
export function partUniform(part: Part, shells: readonly BoundLayer[], local: BoundLayer | undefined): ArrayBuffer {
  const data = new ArrayBuffer(PART_BYTES);
  const floats = new Float32Array(data);
  for (const [place, { layer, geometry }] of [...shells.entries(), ...(local ? [[3, local] as const] : [])]) {
    const { size, parameterization } = layer;
    floats.set([...pack(geometry), size, Math.log2(size)], 16 * place);
    new Uint32Array(data)[16 * place + 14] = PARAMETERIZATIONS[parameterization].kind;
  }
  const { material } = part;
  floats.set([...material.baseColor, material.metallic], 64);
  floats.set([...material.emission, material.normalScale], 68);
  let bits = part.reflective ? REFLECTIVE : 0;
  bits |= material.doubleSided ? DOUBLE_SIDED : 0;
  bits |= local ? HAS_LOCAL : 0;
  const hasUv = part.uv !== undefined;
  for (const [texture, present, clamps, usable] of [
    [material.baseColorTexture, BASE_COLOR_TEXTURE, BASE_COLOR_CLAMPS, hasUv],
    [material.metallicRoughnessTexture, METALLIC_ROUGHNESS_TEXTURE, METALLIC_ROUGHNESS_CLAMPS, hasUv],
    [material.normalTexture, NORMAL_TEXTURE, NORMAL_CLAMPS, hasUv && part.tangents !== undefined],
    [material.emissionTexture, EMISSION_TEXTURE, 0, hasUv],
  ] as const) {
    if (texture && usable) bits |= present | (texture.clamp ? clamps : 0);
  }
  if (material.metallic === 1 && !(bits & METALLIC_ROUGHNESS_TEXTURE)) bits |= METAL;
  new Uint32Array(data).set([bits, shells.length], 72);
  return data;
}

export function frameLayout(device: GPUDevice): GPUBindGroupLayout {
  const fragment = GPUShaderStage.FRAGMENT;
  const both = GPUShaderStage.VERTEX | fragment;
  const storage: GPUBufferBindingLayout = { type: "read-only-storage" };
  return device.createBindGroupLayout({
    entries: [
      { binding: 0, visibility: both, buffer: {} },
      { binding: 1, visibility: both, buffer: storage },
      { binding: 2, visibility: both, buffer: storage },
      { binding: 3, visibility: fragment, buffer: storage },
      { binding: 4, visibility: fragment, buffer: storage },
      { binding: 5, visibility: fragment, texture: {} },
      { binding: 6, visibility: fragment, sampler: {} },
    ],
  });
}

export function partLayout(device: GPUDevice): GPUBindGroupLayout {
  const visibility = GPUShaderStage.FRAGMENT;
  const cubes: GPUTextureBindingLayout = { viewDimension: "cube-array" };
  const maps: GPUTextureBindingLayout = { viewDimension: "2d-array" };
  return device.createBindGroupLayout({
    entries: [
      { binding: 0, visibility, buffer: {} },
      ...[1, 2, 3, 4].map((binding) => ({ binding, visibility, texture: {} })),
      ...[5, 6, 9].map((binding) => ({ binding, visibility, sampler: {} })),
      ...[7, 8].map((binding) => ({ binding, visibility, texture: cubes })),
      ...[10, 11].map((binding) => ({ binding, visibility, texture: maps })),
      { binding: 12, visibility, texture: { viewDimension: "cube-array" as const } },
    ],
  });
}
