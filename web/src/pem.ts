// Opens a PEM's folder over HTTP: everything but its maps. FORMAT.md describes the files.

import type { Orbit } from "./camera";
import type { Geometry } from "./geometry";
import type { Axis } from "./parameter-space";
import { isParameterization, type ParameterizationName } from "./parameterization";
import { type Bounds, union, type Vec3 } from "./vectors";

const EXTENSION = "REFLET_parameterized_environment_map";
const VERSION = 1;
const CLAMP_TO_EDGE = 33071;

export interface Layer {
  readonly name: string;
  readonly kind: "distant" | "local";
  readonly parts: readonly number[];
  readonly size: number;
  readonly parameterization: ParameterizationName;
  readonly geometry: Geometry;
}

export interface PemTexture {
  readonly image: ImageBitmap;
  readonly clamp: boolean;
}

export interface Material {
  readonly baseColor: Vec3;
  readonly metallic: number;
  readonly emission: Vec3;
  readonly normalScale: number;
  readonly doubleSided: boolean;
  readonly baseColorTexture: PemTexture | undefined;
  readonly metallicRoughnessTexture: PemTexture | undefined;
  readonly normalTexture: PemTexture | undefined;
  readonly emissionTexture: PemTexture | undefined;
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
  readonly bounds: Bounds;
}

export interface Environment {
  readonly width: number;
  readonly height: number;
  readonly radiance: Float32Array;
}

export interface Pem {
  readonly parts: readonly Part[];
  readonly axes: readonly Axis[];
  readonly orbit: Orbit;
  readonly layers: readonly Layer[];
  /** Addresses of the map files, by sample and layer. */
  readonly maps: readonly (readonly string[])[];
  readonly lodBias: number;
  readonly sampleCount: number;
  readonly onHull: Uint8Array;
  readonly colourGrids: { readonly resolution: Uint32Array; readonly offset: Uint32Array };
  readonly radiosity: Float32Array;
  readonly environment: Environment | undefined;
}

/** The box around everything, and that around what reflects. */
export const sceneBounds = (pem: Pem): Bounds => union(pem.parts.map((part) => part.bounds));
export const reflectiveBounds = (pem: Pem): Bounds =>
  union(pem.parts.filter((part) => part.reflective).map((part) => part.bounds));

interface ArrayDescription {
  uri: string;
  byteOffset: number;
  shape: number[];
}

interface TextureSlot {
  index: number;
  scale?: number;
}

// The parts of scene.gltf that reflet writes and this viewer reads.
interface Document {
  nodes: { name: string; mesh: number }[];
  meshes: { primitives: [{ attributes: Record<string, number>; indices: number; material: number }] }[];
  accessors: { bufferView: number; count: number; type: string; min?: number[]; max?: number[] }[];
  bufferViews: { buffer: number; byteOffset: number }[];
  buffers: { uri: string }[];
  images?: { uri: string }[];
  samplers?: { wrapS: number }[];
  textures?: { source: number; sampler: number }[];
  materials: {
    pbrMetallicRoughness: {
      baseColorFactor: number[];
      metallicFactor: number;
      baseColorTexture?: TextureSlot;
      metallicRoughnessTexture?: TextureSlot;
    };
    normalTexture?: TextureSlot;
    emissiveTexture?: TextureSlot;
    emissiveFactor?: number[];
    doubleSided?: boolean;
    extensions?: { KHR_materials_emissive_strength?: { emissiveStrength: number } };
  }[];
  extensions?: { [EXTENSION]?: Extension };
}

interface Extension {
  version: number;
  reflective: number[];
  parameterSpace: {
    axes: Axis[];
    orbit: { target: number[]; azimuthDeg: number; elevationDeg: number; distance: number; fovDeg: number };
  };
  layers: (Omit<Layer, "parameterization"> & { parameterization?: string })[];
  samples: { maps: string[] }[];
  lodBias: number;
  sampleCount: number;
  onHull: ArrayDescription;
  irradiance: { resolution: ArrayDescription; offset: ArrayDescription; radiosity: ArrayDescription };
  environment?: ArrayDescription;
}

const COMPONENTS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

/** Opens the PEM whose scene.gltf lies at an address. Rejects with one sentence where that cannot be done. */
export async function openPem(address: string): Promise<Pem> {
  const base = new URL(address, document.baseURI);
  const gltf = await readDocument(base);
  const extension = gltf.extensions?.[EXTENSION];
  if (extension === undefined) throw new Error(`${address} is a plain glTF file, not a parameterized environment map.`);
  if (extension.version !== VERSION) {
    throw new Error(`${address} is of format version ${extension.version}; this viewer reads version ${VERSION}.`);
  }
  const resolve = (uri: string): string => new URL(uri, base).href;
  const files = new Files(resolve);
  const [parts, onHull, resolution, offset, radiosity, environment] = await Promise.all([
    readParts(gltf, new Set(extension.reflective), files),
    files.array(Uint8Array, extension.onHull),
    files.array(Uint32Array, extension.irradiance.resolution),
    files.array(Uint32Array, extension.irradiance.offset),
    files.array(Float32Array, extension.irradiance.radiosity),
    extension.environment && files.array(Float32Array, extension.environment),
  ]);
  const [height, width] = extension.environment?.shape ?? [];
  const { orbit } = extension.parameterSpace;
  return {
    parts,
    axes: extension.parameterSpace.axes,
    orbit: { ...orbit, target: vec3(orbit.target) },
    layers: extension.layers.map(readLayer),
    maps: extension.samples.map((sample) => sample.maps.map(resolve)),
    lodBias: extension.lodBias,
    sampleCount: extension.sampleCount,
    onHull,
    colourGrids: { resolution, offset },
    radiosity,
    environment: environment && { width: width as number, height: height as number, radiance: environment },
  };
}

/** Fetches a file; rejects with one sentence. */
export async function fetchFile(address: string, signal?: AbortSignal): Promise<Response> {
  const response = await fetch(address, signal ? { signal } : {}).catch((error: unknown) => {
    if (signal?.aborted) throw error;
    throw new Error(`${address} cannot be reached.`);
  });
  if (!response.ok) throw new Error(`${address} cannot be read: the server says ${response.status}.`);
  return response;
}

async function readDocument(address: URL): Promise<Document> {
  const response = await fetchFile(address.href);
  return response.json().catch(() => {
    throw new Error(`${address.href} is truncated or no glTF file.`);
  });
}

type NumberArray = Uint8Array | Uint32Array | Float32Array;
interface ArrayOf<T extends NumberArray> {
  new (buffer: ArrayBuffer, byteOffset: number, length: number): T;
  readonly BYTES_PER_ELEMENT: number;
}

/** Binary files, each fetched once. */
class Files {
  private readonly buffers = new Map<string, Promise<ArrayBuffer>>();

  constructor(readonly resolve: (uri: string) => string) {}

  async array<T extends NumberArray>(type: ArrayOf<T>, at: ArrayDescription): Promise<T> {
    const count = at.shape.reduce((a, b) => a * b, 1);
    let buffer = this.buffers.get(at.uri);
    if (buffer === undefined) {
      buffer = fetchFile(this.resolve(at.uri)).then((response) => response.arrayBuffer());
      this.buffers.set(at.uri, buffer);
    }
    const data = await buffer;
    if (at.byteOffset + count * type.BYTES_PER_ELEMENT > data.byteLength) throw new Error(`${at.uri} is truncated.`);
    return new type(data, at.byteOffset, count);
  }

  async image(uri: string): Promise<ImageBitmap> {
    const blob = await (await fetchFile(this.resolve(uri))).blob();
    return createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" }).catch(() => {
      throw new Error(`${uri} is damaged.`);
    });
  }
}

async function readParts(gltf: Document, reflective: Set<number>, files: Files): Promise<Part[]> {
  const images = await Promise.all((gltf.images ?? []).map((image) => files.image(image.uri)));
  const textures = (gltf.textures ?? []).map((texture) => ({
    image: images[texture.source] as ImageBitmap,
    clamp: gltf.samplers?.[texture.sampler]?.wrapS === CLAMP_TO_EDGE,
  }));
  const materials = gltf.materials.map((item) => readMaterial(item, textures));
  const accessor = <T extends NumberArray>(type: ArrayOf<T>, number: number): Promise<T> => {
    const item = at(gltf.accessors, number);
    const view = at(gltf.bufferViews, item.bufferView);
    const shape = [item.count, COMPONENTS[item.type] ?? 1];
    return files.array(type, { uri: at(gltf.buffers, view.buffer).uri, byteOffset: view.byteOffset, shape });
  };
  return Promise.all(
    gltf.nodes.map(async (node, number) => {
      const { attributes, indices, material } = at(gltf.meshes, node.mesh).primitives[0];
      const floats = (name: string) => {
        const index = attributes[name];
        return index === undefined ? undefined : accessor(Float32Array, index);
      };
      const { min, max } = at(gltf.accessors, attributes.POSITION as number);
      return {
        name: node.name,
        reflective: reflective.has(number),
        material: at(materials, material),
        positions: (await floats("POSITION")) as Float32Array,
        normals: (await floats("NORMAL")) as Float32Array,
        indices: await accessor(Uint32Array, indices),
        uv: await floats("TEXCOORD_0"),
        tangents: await floats("TANGENT"),
        bounds: { lower: vec3(min as number[]), upper: vec3(max as number[]) },
      };
    }),
  );
}

function readLayer(item: Extension["layers"][number]): Layer {
  const { parameterization = "cube" } = item; // written since there are others
  if (!isParameterization(parameterization)) {
    throw new Error(`The maps of ${item.name} are ${parameterization} maps, which this viewer does not know.`);
  }
  return { ...item, parameterization };
}

function readMaterial(item: Document["materials"][number], textures: PemTexture[]): Material {
  const surface = item.pbrMetallicRoughness;
  const strength = item.extensions?.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
  const texture = (slot: TextureSlot | undefined) => (slot === undefined ? undefined : textures[slot.index]);
  return {
    baseColor: vec3(surface.baseColorFactor),
    metallic: surface.metallicFactor,
    emission: vec3((item.emissiveFactor ?? [0, 0, 0]).map((e) => e * strength)),
    normalScale: item.normalTexture?.scale ?? 1,
    doubleSided: item.doubleSided ?? false,
    baseColorTexture: texture(surface.baseColorTexture),
    metallicRoughnessTexture: texture(surface.metallicRoughnessTexture),
    normalTexture: texture(item.normalTexture),
    emissionTexture: texture(item.emissiveTexture),
  };
}

function at<T>(items: readonly T[], index: number): T {
  const item = items[index];
  if (item === undefined) throw new Error("scene.gltf is damaged: it names something that it does not hold.");
  return item;
}

const vec3 = (values: readonly number[]): Vec3 => [values[0] as number, values[1] as number, values[2] as number];
