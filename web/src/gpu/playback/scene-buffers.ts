// The scene on the device, and the bind groups of its draw calls: twin of reflet.render.playback.scene_buffers.

import type { Part, PictureTexture, Wrap } from "../../files/gltf";
import type { Geometry } from "../../maths/geometry";
import type { Layer, Pem } from "../../scene/pem";
import type { Stack } from "../../scene/stacks";
import { createMapArray, createPicture, createReliefs, fillMipLevels, mapArrayView } from "../device/textures";
import { createHitBuffers, type HitBuffers } from "./hit-buffers";
import {
  type BoundLayer,
  coatOf,
  coatPicturesOf,
  FRAME_BYTES,
  frameLayout,
  NORMALS,
  PART_BYTES,
  partLayout,
  partUniform,
  picturesOf,
  TRIANGLE_ON_HULL,
} from "./layouts";
import { type PicturePlace, pictureAtlas } from "./picture-atlas";
import { lightWords } from "./punctual-lights";
import { createSurfaceMaps, sitesOf } from "./surface-maps";

const NOWHERE: PicturePlace = [0, 0, 0, 0];

export class SceneBuffers {
  readonly frameUniform: GPUBuffer;
  readonly frameGroup: GPUBindGroup;
  readonly partGroups: readonly GPUBindGroup[];
  /** The cubes of distances that lookups of each stack search. */
  readonly reliefs: readonly GPUTexture[];
  readonly layouts: { readonly frame: GPUBindGroupLayout; readonly part: GPUBindGroupLayout };
  /** Number of the first triangle of each part, and at the end the number of all. */
  readonly triangleOffsets: readonly number[];
  /** All bits that materials of mirrors have, where rays are traced. */
  readonly hitBits: number;
  private readonly extras: readonly number[];
  private readonly coats: readonly (ReturnType<typeof pictureAtlas> | undefined)[];
  private readonly noCoat: GPUTexture;
  private readonly partUniforms: readonly GPUBuffer[];
  private readonly pictures = new Map<ImageBitmap | undefined, GPUTexture>();
  private readonly srgbPictures = new Map<ImageBitmap | undefined, GPUTexture>();

  /** `arrays` are the maps of the stacks. */
  constructor(
    private readonly device: GPUDevice,
    private readonly pem: Pem,
    private readonly stacks: readonly Stack[],
    arrays: readonly GPUTexture[],
  ) {
    this.layouts = { frame: frameLayout(device), part: partLayout(device) };
    let triangles = 0;
    this.triangleOffsets = [0, ...pem.parts.map((part) => (triangles += part.indices.length / 3))];
    this.frameUniform = this.uniform(FRAME_BYTES);
    const vertices = vertexTable(pem.parts);
    this.extras = vertices.extras;
    const hits = createHitBuffers(device, pem.parts, this.extras, pem.traced);
    this.hitBits = hits.bits;
    this.frameGroup = this.createFrameGroup(vertices.values, hits);
    this.partUniforms = pem.parts.map(() => this.uniform(PART_BYTES));
    this.reliefs = stacks.map(({ layers }) =>
      createReliefs(
        device,
        layers.flatMap((layer) => pem.layers[layer]?.geometry ?? []),
      ),
    );
    this.noCoat = pictureAtlas(device, []).texture;
    this.coats = pem.parts.map((part) => (coatOf(part) ? pictureAtlas(device, coatPicturesOf(part)) : undefined));
    this.partGroups = this.createPartGroups(arrays);
    this.setDistantGeometries(pem.layers.map((layer) => layer.geometry));
  }

  /** Lookups of distant layers meet these geometries (one for each layer; local layers keep their own). */
  setDistantGeometries(geometries: readonly Geometry[]): void {
    this.pem.parts.forEach((part, number) => {
      const bound = (kind: "distant" | "local"): BoundLayer[] =>
        (this.stacks[this.stackOf(number, kind)]?.layers ?? []).map((index) => {
          const layer = this.pem.layers[index] as Layer;
          return { layer, geometry: kind === "distant" ? (geometries[index] as Geometry) : layer.geometry };
        });
      const coatPlaces = coatPicturesOf(part).map(
        (picture) => (picture && this.coats[number]?.places.get(picture.image)) ?? NOWHERE,
      );
      const extras = this.extras[number] as number;
      const data = partUniform(part, bound("distant"), bound("local")[0], extras, coatPlaces);
      this.device.queue.writeBuffer(this.partUniforms[number] as GPUBuffer, 0, data);
    });
  }

  private stackOf(part: number, kind: "distant" | "local"): number {
    return this.stacks.findIndex((stack) => stack.kind === kind && stack.parts.includes(part));
  }

  private uniform(size: number): GPUBuffer {
    return this.device.createBuffer({ size, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  }

  private createFrameGroup(vertices: Float32Array, hits: HitBuffers): GPUBindGroup {
    const { colourGrids, parts, onHull } = this.pem;
    const behind = this.pem.surface ? sitesOf(this.pem.surface) : [];
    const grids = new Uint32Array(2 * colourGrids.resolution.length + behind.length);
    grids.set(behind, 2 * colourGrids.resolution.length);
    colourGrids.resolution.forEach((resolution, k) => {
      grids.set([resolution, colourGrids.offset[k] as number], 2 * k);
    });
    const buffers = [vertices, packTriangles(parts, onHull), grids, radiosityOf(this.pem)];
    const sampler = this.device.createSampler({
      ...{ addressModeU: "repeat", magFilter: "linear", minFilter: "linear", mipmapFilter: "linear" },
    });
    return this.device.createBindGroup({
      layout: this.layouts.frame,
      entries: [
        { binding: 0, resource: { buffer: this.frameUniform } },
        ...buffers.map((data, k) => ({ binding: 1 + k, resource: { buffer: this.storage(data) } })),
        { binding: 5, resource: this.environment().createView() },
        { binding: 6, resource: sampler },
        ...[hits.bvh, hits.directions, hits.materials].map((data, k) => ({
          binding: 7 + k,
          resource: { buffer: this.storage(data) },
        })),
        { binding: 10, resource: hits.pictures.createView({ dimension: "2d-array" }) },
        { binding: 11, resource: this.ggxTable().createView() },
        {
          binding: 12,
          resource: createSurfaceMaps(this.device, this.pem.surface).createView({ dimension: "2d-array" }),
        },
        { binding: 13, resource: { buffer: this.storage(lightWords(this.pem)) } },
      ],
    });
  }

  private storage(data: Float32Array | Uint32Array): GPUBuffer {
    // A binding may not be empty; a scene without mesh colours is allowed.
    const buffer = this.device.createBuffer({
      size: Math.max(data.byteLength, 16),
      usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST,
    });
    this.device.queue.writeBuffer(buffer, 0, data as Float32Array<ArrayBuffer>);
    return buffer;
  }

  private ggxTable(): GPUTexture {
    const { rows, columns, values } = this.pem.ggxTable ?? { rows: 1, columns: 1, values: new Uint16Array(4) };
    const texture = createPicture(this.device, columns, rows, "rgba16float", false);
    this.device.queue.writeTexture({ texture }, values as Uint16Array<ArrayBuffer>, { bytesPerRow: 8 * columns }, [
      columns,
      rows,
    ]);
    return texture;
  }

  private environment(): GPUTexture {
    const { width, height, texels } = this.pem.environment ?? { width: 1, height: 1, texels: new Uint16Array(4) };
    const texture = createPicture(this.device, width, height, "rgba16float", true);
    this.device.queue.writeTexture({ texture }, texels, { bytesPerRow: 8 * width }, [width, height]);
    fillMipLevels(this.device, texture);
    return texture;
  }

  private createPartGroups(arrays: readonly GPUTexture[]): GPUBindGroup[] {
    const none = createMapArray(this.device, { parameterization: "cube", size: 1 }, 1); // six layers: any view fits
    // A stack's maps if they are cubes, or if they are not; else a map of one black texel.
    const maps = (stack: number, cubes: boolean): GPUTextureView => {
      const parameterization = this.stacks[stack]?.shape.parameterization;
      return parameterization !== undefined && (parameterization === "cube") === cubes
        ? mapArrayView(arrays[stack] as GPUTexture, parameterization)
        : none.createView({ dimension: cubes ? "cube-array" : "2d-array" });
    };
    const noRelief = createReliefs(this.device, []);
    const samplers = new Map<string, GPUSampler>();
    const sampler = (wraps: readonly [Wrap, Wrap]): GPUSampler => {
      const known = samplers.get(wraps.join());
      if (known) return known;
      const [addressModeU, addressModeV] = wraps.map((wrap) => ADDRESS_MODES[wrap]) as [GPUAddressMode, GPUAddressMode];
      const made = this.device.createSampler({
        ...{ addressModeU, addressModeV },
        ...{ magFilter: "linear", minFilter: "linear", mipmapFilter: "linear" },
      });
      samplers.set(wraps.join(), made);
      return made;
    };
    const samplerOf = (texture: PictureTexture | undefined) => sampler(texture?.wraps ?? ["repeat", "repeat"]);
    return this.pem.parts.map((part, number) => {
      const [distant, local] = [this.stackOf(number, "distant"), this.stackOf(number, "local")];
      const { baseColorTexture, metallicRoughnessTexture, normalTexture, emissionTexture } = part.material;
      const resources: GPUBindingResource[] = [
        { buffer: this.partUniforms[number] as GPUBuffer },
        this.picture(baseColorTexture, true),
        this.picture(metallicRoughnessTexture, false),
        this.picture(normalTexture, false),
        this.picture(emissionTexture, true),
        samplerOf(baseColorTexture),
        samplerOf(emissionTexture),
        maps(distant, true),
        maps(local, true),
        sampler(["clamp", "clamp"]),
        maps(distant, false),
        maps(local, false),
        (this.reliefs[distant] ?? noRelief).createView({ dimension: "cube-array" }),
        (this.coats[number]?.texture ?? this.noCoat).createView({ dimension: "2d-array" }),
      ];
      const entries = resources.map((resource, binding) => ({ binding, resource }));
      return this.device.createBindGroup({ layout: this.layouts.part, entries });
    });
  }

  private picture(texture: PictureTexture | undefined, srgb: boolean): GPUTextureView {
    const pictures = srgb ? this.srgbPictures : this.pictures;
    let picture = pictures.get(texture?.image);
    if (picture === undefined) {
      picture = this.uploadPicture(texture?.image, srgb);
      pictures.set(texture?.image, picture);
    }
    return picture.createView();
  }

  private uploadPicture(image: ImageBitmap | undefined, srgb: boolean): GPUTexture {
    const format = srgb ? "rgba8unorm-srgb" : "rgba8unorm";
    const [width, height] = image ? [image.width, image.height] : [1, 1];
    const texture = createPicture(this.device, width, height, format, srgb);
    if (image) {
      this.device.queue.copyExternalImageToTexture({ source: image }, { texture }, [width, height]);
    } else {
      this.device.queue.writeTexture({ texture }, new Uint8Array(4).fill(255), {}, [1, 1]);
    }
    fillMipLevels(this.device, texture);
    return texture;
  }
}

const ADDRESS_MODES: Record<Wrap, GPUAddressMode> = {
  ...{ repeat: "repeat", clamp: "clamp-to-edge", mirror: "mirror-repeat" },
};

/** Three vec4f a vertex, (position, u) (normal, v) (tangent), and behind them the extras of parts that have any: twin of
reflet.render.playback.vertex_table. `extras` are where those of a vertex 0 would lie, modulo 2³². */
function vertexTable(parts: readonly Part[]): { values: Float32Array; extras: number[] } {
  const widths = parts.map(({ colors, moreUv }) => (moreUv.length > 0 ? 3 : colors ? 1 : 0));
  const counts = parts.map((part) => part.positions.length / 3);
  const count = counts.reduce((sum, its) => sum + its, 0);
  const more = counts.reduce((sum, its, k) => sum + its * (widths[k] as number), 0);
  const out = new Float32Array(12 * count + 4 * more);
  let at = 0;
  for (const { positions, normals, uv, tangents } of parts) {
    for (let k = 0; k < positions.length / 3; k++, at += 12) {
      out.set(positions.subarray(3 * k, 3 * k + 3), at);
      out.set(normals.subarray(3 * k, 3 * k + 3), at + 4);
      if (uv) [out[at + 3], out[at + 7]] = [uv[2 * k] as number, uv[2 * k + 1] as number];
      if (tangents) out.set(tangents.subarray(4 * k, 4 * k + 4), at + 8);
    }
  }
  let first = 0;
  const extras = parts.map(({ colors, moreUv }, number) => {
    const [its, width] = [counts[number] as number, widths[number] as number];
    const place = at / 4 - first * width;
    for (let k = 0; k < (width ? its : 0); k++, at += 4 * width) {
      out.set(colors?.subarray(4 * k, 4 * k + 4) ?? [1, 1, 1, 1], at);
      moreUv.forEach((uv, which) => {
        out.set(uv.subarray(2 * k, 2 * k + 2), at + 4 + 2 * which);
      });
    }
    first += its;
    return place >>> 0;
  });
  return { values: out, extras };
}

/** Of all samples, and behind it, where normals are bent, their gradients; 0 where there are none. */
function radiosityOf({ parts, radiosity, gradient }: Pem): Float32Array {
  if (!parts.some((part) => picturesOf(part)[NORMALS])) return radiosity;
  const out = new Float32Array(2 * radiosity.length);
  out.set(radiosity);
  if (gradient) out.set(gradient, radiosity.length);
  return out;
}

/** One vec4u a triangle: three vertex numbers through all parts, bits. */
function packTriangles(parts: readonly Part[], onHull: Uint8Array): Uint32Array {
  const out = new Uint32Array(4 * onHull.length);
  let [firstVertex, triangle] = [0, 0];
  for (const { indices, positions } of parts) {
    for (let k = 0; k < indices.length; k += 3, triangle++) {
      for (let corner = 0; corner < 3; corner++) {
        out[4 * triangle + corner] = firstVertex + (indices[k + corner] as number);
      }
      out[4 * triangle + 3] = 2 * triangle + (onHull[triangle] ? TRIANGLE_ON_HULL : 0);
    }
    firstVertex += positions.length / 3;
  }
  return out;
}
