// Plain env maps on the device: twin of reflet.render.maps.env_map_texture.

import { PARAMETERIZATIONS, type ParameterizationName } from "../../maths/parameterization";
import type { Vec3 } from "../../maths/vectors";

const ENV_MAP_BYTES = 64;

export interface EnvMapTexture {
  readonly parameterization: ParameterizationName;
  readonly size: number; // rows of a face
  readonly texture: GPUTexture;
}

/** Rows of a rotation. */
export type Rotation = readonly [Vec3, Vec3, Vec3];

/** How a map is looked up: turned, sharper or blurrier, by roughness where its levels are filtered for that. */
export interface Lookup {
  readonly mapFromWorld: Rotation;
  readonly lodBias: number;
  readonly roughness: number | undefined;
}

/** Whether the hardware's cube sampler serves: of cubes in half float, which all devices can filter. */
export const byHardware = ({ parameterization, texture }: EnvMapTexture): boolean =>
  parameterization === "cube" && texture.format === "rgba16float";

/** An empty env map, or several of one kind, one after the other in the texture's layers. */
export function createEnvMap(
  device: GPUDevice,
  parameterization: ParameterizationName,
  size: number,
  mipLevelCount: number,
  format: GPUTextureFormat,
  mapCount = 1,
): EnvMapTexture {
  const { aspect, faceCount } = PARAMETERIZATIONS[parameterization];
  const texture = device.createTexture({
    size: [aspect * size, size, mapCount * faceCount],
    mipLevelCount,
    format,
    usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST | GPUTextureUsage.RENDER_ATTACHMENT,
  });
  return { parameterization, size, texture };
}

/** A mip level alone, all faces. */
export const levelView = (texture: GPUTexture, baseMipLevel: number): GPUTextureView =>
  texture.createView({ dimension: "2d-array", baseMipLevel, mipLevelCount: 1 });

/** One face of a mip level, to draw into. */
export const faceView = (texture: GPUTexture, face: number, baseMipLevel: number): GPUTextureView =>
  texture.createView({ dimension: "2d", baseArrayLayer: face, arrayLayerCount: 1, baseMipLevel, mipLevelCount: 1 });

/** Bind group 1. */
export function envMapLayout(device: GPUDevice): GPUBindGroupLayout {
  const visibility = GPUShaderStage.FRAGMENT;
  return device.createBindGroupLayout({
    entries: [
      { binding: 0, visibility, buffer: {} },
      { binding: 1, visibility, texture: { sampleType: "unfilterable-float", viewDimension: "2d-array" } },
      { binding: 2, visibility, texture: { viewDimension: "cube" } },
      { binding: 3, visibility, sampler: {} },
    ],
  });
}

/** Bind groups of maps as they are looked up, made once for each map; `write` changes how. */
export class EnvMapGroup {
  readonly group: GPUBindGroup;
  private readonly uniform: GPUBuffer;

  constructor(
    private readonly device: GPUDevice,
    layout: GPUBindGroupLayout,
    readonly map: EnvMapTexture,
  ) {
    this.uniform = device.createBuffer({
      size: ENV_MAP_BYTES,
      usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST,
    });
    const cube = byHardware(map) ? map : createEnvMap(device, "cube", 1, 1, "rgba16float");
    const filters = { magFilter: "linear", minFilter: "linear", mipmapFilter: "linear" } as const;
    this.group = device.createBindGroup({
      layout,
      entries: [
        { binding: 0, resource: { buffer: this.uniform } },
        { binding: 1, resource: map.texture.createView({ dimension: "2d-array" }) },
        { binding: 2, resource: cube.texture.createView({ dimension: "cube" }) },
        { binding: 3, resource: device.createSampler(filters) },
      ],
    });
  }

  write({ mapFromWorld, lodBias, roughness }: Lookup): void {
    const data = new Float32Array(ENV_MAP_BYTES / 4);
    mapFromWorld.forEach((row, i) => {
      row.forEach((value, column) => {
        data[4 * column + i] = value;
      });
    });
    data.set([this.map.size, this.map.texture.mipLevelCount - 1, lodBias, roughness ?? -1], 12);
    this.device.queue.writeBuffer(this.uniform, 0, data);
  }
}
