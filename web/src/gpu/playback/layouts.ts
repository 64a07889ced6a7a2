// The host's side of the shaders' bind groups, described in frame.wgsl and part.wgsl: twin of reflet.render.playback.layouts.

import { type Coat, type Part, type PictureTexture, WRAPS } from "../../files/gltf";
import { clipFromWorld, pixelFromView, rayBasis } from "../../maths/camera";
import { type Geometry, pack } from "../../maths/geometry";
import { PARAMETERIZATIONS } from "../../maths/parameterization";
import { samplePositions } from "../../maths/sample-pattern";
import type { Layer, Shown } from "../../scene/pem";
import type { PicturePlace } from "./picture-atlas";
import type { View } from "./view";

const SWITCHES: Record<keyof Shown, number> = { diffuse: 1, fresnel: 2, distant: 4, local: 8 };

const HIDE_SHELL = 32; // the nearest; the others' bits follow
const BY_ORIGIN = 256;

export const TRIANGLE_ON_HULL = 1;
const LARGEST_BLEND = 8; // behind them in the frame's arrays stands the base
export const FRAME_BYTES = 1856;
export const PART_BYTES = 416;

const [REFLECTIVE, DOUBLE_SIDED] = [1, 2];
export const HAS_LOCAL = 4;
const METALLIC_ROUGHNESS_TEXTURE = 16;
const PICTURES = [8, METALLIC_ROUGHNESS_TEXTURE, 32, 64]; // base colour, metallic-roughness, normals, emission
export const NORMALS = 2; // their place among these
const [COLORS, MORE_UV, HOLES, UNLIT] = [128, 256, 512, 4096];
export const METAL = 1024;
export const REFRACTIVE = 8192;
const [THIN, ROUGH, SURFACE] = [16384, 32768, 65536];
const [COAT, COAT_TEXTURES] = [131072, 262144];
const LEAST_ROUGHNESS = 0.03; // smoother parts are mirrors

export function frameUniform(view: View, sampleCount: number, lodBias: number): ArrayBuffer {
  const { camera, blend, base, shown, hiddenShells, byOrigin } = view;
  const data = new ArrayBuffer(FRAME_BYTES);
  const floats = new Float32Array(data);
  const basis = rayBasis(camera);
  const { corner, dx, dy } = basis;
  floats.set(clipFromWorld(camera), 0);
  floats.set([...camera.position, lodBias], 16);
  floats.set([...corner, -0.5 * Math.log2(sampleCount)], 20);
  floats.set([...dx, camera.width], 24);
  floats.set([...dy, camera.height], 28);
  for (const [k, position] of samplePositions(sampleCount).slice(0, 64).entries()) floats.set(position, 32 + 4 * k);
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
    ...(byOrigin ? [BY_ORIGIN] : []),
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

/** The nearest shell first; `extras` is where the extras of the part's vertices lie, `coatPlaces` the pictures of its coat. */
export function partUniform(
  part: Part,
  shells: readonly BoundLayer[],
  local: BoundLayer | undefined,
  extras: number,
  coatPlaces: readonly PicturePlace[],
): ArrayBuffer {
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
  new Uint32Array(data).set([partBits(part) | (local ? HAS_LOCAL : 0), shells.length], 72);
  floats[75] = material.roughness;
  const { refraction } = material;
  if (refraction) {
    floats[74] = refraction.transmission;
    floats.set([...refraction.absorption, refraction.index], 76);
  }
  new Uint32Array(data).set([sampling(part), extras], 80);
  floats.set([material.alpha, material.cutoff ?? 0, ...material.dielectric.f0, material.dielectric.f90], 82);
  const coat = coatOf(part);
  if (coat) {
    floats.set([coat.share, coat.roughness, coat.normalScale], 88);
    new Uint32Array(data)[91] = samplingOf(coatPicturesOf(part));
    coatPlaces.forEach((place, k) => {
      new Uint32Array(data).set(place, 92 + 4 * k);
    });
  }
  return data;
}

/** The coat of a part that reflects and is no glass, if it has one. */
export function coatOf({ reflective, material }: Part): Coat | undefined {
  return reflective && !material.refraction ? material.coat : undefined;
}

/** Of its coat: its share, its roughness, its normals. */
export function coatPicturesOf(part: Part): readonly (PictureTexture | undefined)[] {
  const coat = part.uv && coatOf(part);
  return [coat?.shareTexture, coat?.roughnessTexture, part.tangents && coat?.normalTexture];
}

/** Base colour, metallic-roughness, normals and emission, as far as the part's mesh can be textured by them. */
export function picturesOf({ material, uv, tangents }: Part): readonly (PictureTexture | undefined)[] {
  if (uv === undefined) return [undefined, undefined, undefined, undefined];
  const { baseColorTexture, metallicRoughnessTexture, normalTexture, emissionTexture } = material;
  return [baseColorTexture, metallicRoughnessTexture, tangents && normalTexture, emissionTexture];
}

/** A byte for each texture: how it wraps, and its set of texture coordinates. */
export const sampling = (part: Part): number => samplingOf(picturesOf(part));

function samplingOf(textures: readonly (PictureTexture | undefined)[]): number {
  const bytes = textures.map((texture, k) => {
    if (!texture) return 0;
    const [along, across] = texture.wraps.map((wrap) => WRAPS.indexOf(wrap)) as [number, number];
    return (along | (across << 2) | (texture.coordinates << 4)) << (8 * k);
  });
  return bytes.reduce((sum, byte) => sum | byte, 0) >>> 0;
}

/** What a part's own bits say, whatever it looks up. */
export function partBits(part: Part): number {
  let bits = (part.reflective ? REFLECTIVE : 0) | (part.material.doubleSided ? DOUBLE_SIDED : 0);
  picturesOf(part).forEach((texture, k) => {
    if (texture) bits |= PICTURES[k] as number;
  });
  bits |= (part.material.cutoff !== undefined ? HOLES : 0) | (part.material.unlit ? UNLIT : 0);
  bits |= (part.colors ? COLORS : 0) | (part.moreUv.length > 0 ? MORE_UV : 0);
  const refraction = part.reflective ? part.material.refraction : undefined;
  if (refraction) return bits | REFRACTIVE | (refraction.thin ? THIN : 0) | (refraction.transmission >= 1 ? METAL : 0);
  const coat = coatOf(part);
  if (part.reflective && (part.material.roughness >= LEAST_ROUGHNESS || coat)) bits |= ROUGH;
  bits |= (coat ? COAT : 0) | (coatPicturesOf(part).some(Boolean) ? COAT_TEXTURES : 0);
  if (part.surfaceLight) bits |= SURFACE;
  if (part.material.metallic === 1 && !(bits & METALLIC_ROUGHNESS_TEXTURE)) bits |= METAL;
  return bits;
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
      ...[7, 8, 9].map((binding) => ({ binding, visibility: fragment, buffer: storage })),
      { binding: 10, visibility: fragment, texture: { viewDimension: "2d-array" } },
      { binding: 11, visibility: fragment, texture: {} },
      { binding: 12, visibility: fragment, texture: { viewDimension: "2d-array" } },
      { binding: 13, visibility: fragment, buffer: storage },
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
      { binding: 13, visibility, texture: maps },
    ],
  });
}
