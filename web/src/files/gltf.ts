// Scenes as reflet writes them in glTF, fetched over HTTP: meshes and materials. What makes a scene ours stands in an
// extension, which others read.

import { type Bounds, union, type Vec3 } from "../maths/vectors";
import { type ArrayDescription, type ArrayOf, arrayOf, type NumberArray } from "./arrays";
import { type LightsOfScene, type NodeOfLight, type PunctualLight, readLights } from "./gltf-lights";
import { fractions, type PackedView, unpacked } from "./packed-views";

/** How a picture goes on beyond its edges, in the order of the shaders' numbers; and glTF's. */
export const WRAPS = ["repeat", "clamp", "mirror"] as const;
export type Wrap = (typeof WRAPS)[number];
const WRAP_CODES = [10497, 33071, 33648];

export interface PictureTexture {
  readonly image: ImageBitmap;
  /** Along u and along v. */
  readonly wraps: readonly [Wrap, Wrap];
  /** Which of the mesh's sets of texture coordinates it is looked up by. */
  readonly coordinates: number;
}

/** What lets light through: twin of reflet.scene.material.Refraction. */
export interface Refraction {
  readonly index: number;
  readonly transmission: number;
  readonly absorption: Vec3;
  readonly thin: boolean;
}

/** A clear coat: the fields of reflet.scene.material.Material. */
export interface Coat {
  readonly share: number;
  /** Perceptual. */
  readonly roughness: number;
  readonly normalScale: number;
  readonly shareTexture: PictureTexture | undefined;
  readonly roughnessTexture: PictureTexture | undefined;
  readonly normalTexture: PictureTexture | undefined;
}

export interface Material {
  readonly baseColor: Vec3;
  readonly metallic: number;
  /** Perceptual. */
  readonly roughness: number;
  readonly emission: Vec3;
  readonly normalScale: number;
  readonly doubleSided: boolean;
  readonly baseColorTexture: PictureTexture | undefined;
  readonly metallicRoughnessTexture: PictureTexture | undefined;
  readonly normalTexture: PictureTexture | undefined;
  readonly emissionTexture: PictureTexture | undefined;
  readonly refraction: Refraction | undefined;
  readonly coat: Coat | undefined;
  readonly alpha: number;
  /** What alpha is compared with; below 0 it is blended, undefined where the material is opaque. */
  readonly cutoff: number | undefined;
  /** Of what is no metal: reflectance at normal incidence, and along the surface. */
  readonly dielectric: { readonly f0: Vec3; readonly f90: number };
  /** Whether its base colour is its emission. */
  readonly unlit: boolean;
}

export interface Part {
  readonly name: string;
  readonly reflective: boolean;
  readonly material: Material;
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly indices: Uint32Array;
  readonly uv: Float32Array | undefined;
  readonly tangents: Float32Array | undefined;
  /** Linear red, green, blue and alpha, which the base colour is multiplied by. */
  readonly colors: Float32Array | undefined;
  /** Further sets of texture coordinates, numbered from 1. */
  readonly moreUv: readonly Float32Array[];
  /** Whether its triangles have maps of local light. */
  readonly surfaceLight?: boolean;
  /** Share and roughness of its clear coat in the mean over its surface. */
  readonly coatMean?: readonly [number, number];
  readonly bounds: Bounds;
}

/** The box around everything, and that around what reflects. */
export const sceneBounds = ({ parts }: { readonly parts: readonly Part[] }): Bounds =>
  union(parts.map((part) => part.bounds));
export const reflectiveBounds = ({ parts }: { readonly parts: readonly Part[] }): Bounds =>
  union(parts.filter((part) => part.reflective).map((part) => part.bounds));

interface TextureSlot {
  index: number;
  texCoord?: number;
  scale?: number;
}

interface MaterialExtensions {
  KHR_materials_clearcoat?: {
    clearcoatFactor: number;
    clearcoatRoughnessFactor: number;
    clearcoatTexture?: TextureSlot;
    clearcoatRoughnessTexture?: TextureSlot;
    clearcoatNormalTexture?: TextureSlot;
  };
  KHR_materials_emissive_strength?: { emissiveStrength: number };
  KHR_materials_ior?: { ior: number };
  KHR_materials_specular?: { specularFactor: number; specularColorFactor: number[] };
  KHR_materials_unlit?: Record<string, never>;
  KHR_materials_transmission?: { transmissionFactor: number };
  KHR_materials_volume?: { attenuationColor?: number[]; attenuationDistance?: number };
}

// The parts of scene.gltf that reflet writes and this viewer reads.
interface Document {
  nodes: ({ name: string; mesh?: number } & NodeOfLight)[];
  meshes: { primitives: [{ attributes: Record<string, number>; indices: number; material: number }] }[];
  accessors: {
    bufferView: number;
    count: number;
    type: string;
    min?: number[];
    max?: number[];
    normalized?: boolean;
  }[];
  bufferViews: { buffer: number; byteOffset: number; extensions?: { EXT_meshopt_compression?: PackedView } }[];
  buffers: { uri: string }[];
  images?: { uri: string }[];
  samplers?: { wrapS: number; wrapT: number }[];
  textures?: { source?: number; sampler: number; extensions?: { EXT_texture_webp?: { source: number } } }[];
  materials: {
    pbrMetallicRoughness: {
      baseColorFactor: number[];
      metallicFactor: number;
      roughnessFactor: number;
      baseColorTexture?: TextureSlot;
      metallicRoughnessTexture?: TextureSlot;
    };
    normalTexture?: TextureSlot;
    emissiveTexture?: TextureSlot;
    emissiveFactor?: number[];
    alphaMode?: string;
    alphaCutoff?: number;
    doubleSided?: boolean;
    extensions?: MaterialExtensions;
  }[];
  extensions?: Record<string, unknown> & { KHR_lights_punctual?: LightsOfScene };
}

const MORE_UV = ["TEXCOORD_1", "TEXCOORD_2", "TEXCOORD_3"];
const COMPONENTS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

/** Fetches a file; rejects with one sentence. */
export async function fetchFile(address: string, signal?: AbortSignal): Promise<Response> {
  const response = await fetch(address, signal ? { signal } : {}).catch((error: unknown) => {
    if (signal?.aborted) throw error;
    const { protocol, origin } = new URL(address, document.baseURI);
    if (protocol === "file:") {
      throw new Error(
        `${address} cannot be read: browsers let no page read files of the disk. Serve their folder, such as by: ` +
          "python3 -m http.server",
      );
    }
    const foreign = origin === location.origin ? "" : ", or that server does not let pages of others read it (CORS)";
    throw new Error(`${address} cannot be reached${foreign}.`);
  });
  if (!response.ok) throw new Error(`${address} cannot be read: the server says ${response.status}.`);
  return response;
}

/** A scene.gltf, and the files that it names. */
export interface SceneFile {
  readonly address: string;
  readonly gltf: Document;
  readonly files: Files;
}

/** Fetches a scene.gltf. Rejects with one sentence where it is none. */
export async function openSceneFile(address: string, signal?: AbortSignal): Promise<SceneFile> {
  const base = new URL(address, document.baseURI);
  const response = await fetchFile(base.href, signal);
  const gltf: Document = await response.json().catch(() => {
    throw new Error(`${base.href} is truncated or no glTF file.`);
  });
  return { address, gltf, files: new Files((uri) => new URL(uri, base).href) };
}

/** What an extension of ours says; undefined where the scene lacks it. */
export function extensionOf<T extends { version: number }>(
  { address, gltf }: SceneFile,
  name: string,
  version: number,
): T | undefined {
  const extension = gltf.extensions?.[name] as T | undefined;
  if (extension !== undefined && extension.version !== version) {
    throw new Error(`${address} is of format version ${extension.version}; this viewer reads version ${version}.`);
  }
  return extension;
}

/** Binary files, each fetched once. */
export class Files {
  private readonly buffers = new Map<string, Promise<ArrayBuffer>>();

  constructor(readonly resolve: (uri: string) => string) {}

  buffer(uri: string): Promise<ArrayBuffer> {
    let buffer = this.buffers.get(uri);
    if (buffer === undefined) {
      buffer = fetchFile(this.resolve(uri)).then((response) => response.arrayBuffer());
      this.buffers.set(uri, buffer);
    }
    return buffer;
  }

  async array<T extends NumberArray>(type: ArrayOf<T>, at: ArrayDescription): Promise<T> {
    return arrayOf(type, at, await this.buffer(at.uri));
  }

  async image(uri: string): Promise<ImageBitmap> {
    const blob = await (await fetchFile(this.resolve(uri))).blob();
    return createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" }).catch(() => {
      throw new Error(`${uri} is damaged.`);
    });
  }
}

/** All parts of a scene; `reflective` are the numbers of those that reflect. */
export async function readParts({ gltf, files }: SceneFile, reflective: Set<number>): Promise<Part[]> {
  const images = await Promise.all((gltf.images ?? []).map((image) => files.image(image.uri)));
  const textures = (gltf.textures ?? []).map((texture) => ({
    image: at(images, texture.extensions?.EXT_texture_webp?.source ?? texture.source ?? -1),
    wraps: wrapsOf(gltf.samplers?.[texture.sampler]),
    coordinates: 0,
  }));
  const materials = gltf.materials.map((item) => readMaterial(item, textures));
  const accessor = async <T extends NumberArray>(type: ArrayOf<T>, number: number): Promise<T | Float32Array> => {
    const item = at(gltf.accessors, number);
    const view = at(gltf.bufferViews, item.bufferView);
    const width = COMPONENTS[item.type] ?? 1;
    const packed = view.extensions?.EXT_meshopt_compression;
    const { uri } = at(gltf.buffers, packed?.buffer ?? view.buffer);
    const shape = [item.count, width];
    if (packed === undefined) return files.array(type, { uri, byteOffset: view.byteOffset, shape });
    const data = await unpacked(packed, await files.buffer(uri), uri);
    if (item.normalized) return fractions(data, item.count, width);
    return arrayOf(type, { uri, byteOffset: 0, shape }, data);
  };
  return Promise.all(
    partNodes(gltf).map(async (node, number) => {
      const { attributes, indices, material } = at(gltf.meshes, node.mesh ?? -1).primitives[0];
      const floats = (name: string) => {
        const index = attributes[name];
        return index === undefined ? undefined : (accessor(Float32Array, index) as Promise<Float32Array>);
      };
      const { min, max } = at(gltf.accessors, attributes.POSITION as number);
      return {
        name: node.name,
        reflective: reflective.has(number),
        material: at(materials, material),
        positions: (await floats("POSITION")) as Float32Array,
        normals: (await floats("NORMAL")) as Float32Array,
        indices: (await accessor(Uint32Array, indices)) as Uint32Array,
        uv: await floats("TEXCOORD_0"),
        tangents: await floats("TANGENT"),
        colors: await floats("COLOR_0"),
        moreUv: (await Promise.all(MORE_UV.map(floats))).filter((uv) => uv !== undefined),
        bounds: { lower: vec3(min as number[]), upper: vec3(max as number[]) },
      };
    }),
  );
}

/** The lights without extent of a scene. */
export const lightsOf = ({ gltf }: SceneFile): PunctualLight[] =>
  readLights(gltf.nodes, gltf.extensions?.KHR_lights_punctual);

const partNodes = (gltf: Document) => gltf.nodes.filter((node) => node.mesh !== undefined);

function readMaterial(item: Document["materials"][number], textures: PictureTexture[]): Material {
  const surface = item.pbrMetallicRoughness;
  const strength = item.extensions?.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
  const texture = (slot: TextureSlot | undefined): PictureTexture | undefined =>
    slot && { ...at(textures, slot.index), coordinates: slot.texCoord ?? 0 };
  return {
    baseColor: vec3(surface.baseColorFactor),
    metallic: surface.metallicFactor,
    roughness: surface.roughnessFactor,
    emission: vec3((item.emissiveFactor ?? [0, 0, 0]).map((e) => e * strength)),
    normalScale: item.normalTexture?.scale ?? 1,
    doubleSided: item.doubleSided ?? false,
    baseColorTexture: texture(surface.baseColorTexture),
    metallicRoughnessTexture: texture(surface.metallicRoughnessTexture),
    normalTexture: texture(item.normalTexture),
    emissionTexture: texture(item.emissiveTexture),
    refraction: readRefraction(item.extensions ?? {}),
    coat: readCoat(item.extensions ?? {}, texture),
    alpha: surface.baseColorFactor[3] ?? 1,
    cutoff: item.alphaMode === "MASK" ? (item.alphaCutoff ?? 0.5) : item.alphaMode === "BLEND" ? -1 : undefined,
    dielectric: dielectricOf(item.extensions ?? {}),
    unlit: item.extensions?.KHR_materials_unlit !== undefined,
  };
}

/** Twin of reflet.scene.material.Material.dielectric_f0. */
function dielectricOf(extensions: MaterialExtensions): { f0: Vec3; f90: number } {
  const ior = extensions.KHR_materials_ior?.ior ?? 1.5;
  const { specularFactor = 1, specularColorFactor = [1, 1, 1] } = extensions.KHR_materials_specular ?? {};
  const facing = ior === 0 ? 1 : ((ior - 1) / (ior + 1)) ** 2;
  return { f0: vec3(specularColorFactor.map((c) => specularFactor * Math.min(facing * c, 1))), f90: specularFactor };
}

function readCoat(
  { KHR_materials_clearcoat: coat, KHR_materials_unlit: unlit }: MaterialExtensions,
  texture: (slot: TextureSlot | undefined) => PictureTexture | undefined,
): Coat | undefined {
  if (!coat || unlit || coat.clearcoatFactor <= 0) return undefined;
  return {
    share: coat.clearcoatFactor,
    roughness: coat.clearcoatRoughnessFactor,
    normalScale: coat.clearcoatNormalTexture?.scale ?? 1,
    shareTexture: texture(coat.clearcoatTexture),
    roughnessTexture: texture(coat.clearcoatRoughnessTexture),
    normalTexture: texture(coat.clearcoatNormalTexture),
  };
}

const LEAST_ATTENUATION = 1e-6; // of a channel over the attenuation distance: black would be infinitely dense

function readRefraction(extensions: MaterialExtensions): Refraction | undefined {
  const { KHR_materials_ior: ior, KHR_materials_transmission: transmission, KHR_materials_volume: volume } = extensions;
  if (!ior || !transmission) return undefined;
  const { attenuationColor = [1, 1, 1], attenuationDistance = Number.POSITIVE_INFINITY } = volume ?? {};
  return {
    index: ior.ior,
    transmission: transmission.transmissionFactor,
    absorption: vec3(attenuationColor.map((c) => Math.log(1 / Math.max(c, LEAST_ATTENUATION)) / attenuationDistance)),
    thin: volume === undefined,
  };
}

function wrapsOf(sampler: { wrapS: number; wrapT: number } | undefined): [Wrap, Wrap] {
  const wrap = (code: number | undefined) => WRAPS[WRAP_CODES.indexOf(code ?? 10497)] ?? "repeat";
  return [wrap(sampler?.wrapS), wrap(sampler?.wrapT)];
}

function at<T>(items: readonly T[], index: number): T {
  const item = items[index];
  if (item === undefined) throw new Error("scene.gltf is damaged: it names something that it does not hold.");
  return item;
}

const vec3 = (values: readonly number[]): Vec3 => [values[0] as number, values[1] as number, values[2] as number];
