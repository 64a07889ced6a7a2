// Opens a PEM's folder over HTTP: everything but its maps. FORMAT.md describes the files.

import type { ArrayDescription } from "../files/arrays";
import { codedPicture } from "../files/coded-light";
import { extensionOf, fetchFile, lightsOf, type Part, readParts, type SceneFile } from "../files/gltf";
import type { PunctualLight } from "../files/gltf-lights";
import { type Orbit, type OrbitDescription, readOrbit, type ViewPoint } from "../maths/camera";
import type { Geometry, Relief } from "../maths/geometry";
import { halfTexels } from "../maths/half";
import { type Axis, displacementDeg } from "../maths/parameter-space";
import { isParameterization, type ParameterizationName } from "../maths/parameterization";
import { type Irradiance, readIrradiance, type StoredIrradiance } from "./irradiance";
import { partsWithMaps, readSurface, type StoredSurface, type SurfaceLayer } from "./surface-layer";

const EXTENSION = "REFLET_parameterized_environment_map";
const VERSION = 3;
const MOST_HITS = 64;

export interface Layer {
  readonly name: string;
  readonly kind: "distant" | "local";
  readonly parts: readonly number[];
  readonly size: number;
  readonly parameterization: ParameterizationName;
  readonly geometry: Geometry;
  /** Metres from the origin between which a shell lies. */
  readonly begin: number;
  readonly end: number;
}

export interface Environment {
  readonly width: number;
  readonly height: number;
  /** Radiance in half-float RGBA. */
  readonly texels: Uint16Array<ArrayBuffer>;
}

export interface GgxTable {
  readonly rows: number;
  readonly columns: number;
  readonly values: Uint16Array;
}

export interface Pem {
  readonly parts: readonly Part[];
  readonly axes: readonly Axis[];
  readonly orbit: Orbit;
  readonly layers: readonly Layer[];
  /** Addresses of the map files, by sample and layer. */
  readonly maps: readonly (readonly string[])[];
  /** Those of maps of the distant layers that serve every viewpoint, or none. */
  readonly base: readonly string[];
  /** Degrees of displacement from the samples at which the base is all that is shown. */
  readonly fadeDeg: number;
  /** What the LOD is shifted by, in pictures of `sampleCount` samples a pixel. */
  readonly lodBias: number;
  readonly sampleCount: number;
  readonly onHull: Uint8Array;
  readonly colourGrids: Irradiance["colourGrids"];
  readonly radiosity: Irradiance["radiosity"];
  readonly gradient: Irradiance["gradient"];
  readonly visibility: Irradiance["visibility"];
  readonly lights: readonly PunctualLight[];
  /** What rough surfaces mirror of their own object, if any does. */
  readonly surface: SurfaceLayer | undefined;
  readonly environment: Environment | undefined;
  /** That of ggx_table.wgsl, where parts are rough: half floats, four an entry. */
  readonly ggxTable: GgxTable | undefined;
  /** How mirrored rays are traced through the mirrors' own meshes, if they are. */
  readonly traced: Traced | undefined;
}

export interface Traced {
  /** How many mirrors a ray may meet. */
  readonly mostHits: number;
  readonly bvh: Bvh;
}

/**
 * The tree of triangles that rays may meet without its boxes, and the directions in which they may meet some: see FORMAT.md.
 */
export interface Bvh {
  readonly order: Uint32Array;
  readonly leafCounts: Uint8Array;
  readonly directions: Uint32Array;
  /** Parts that do not reflect and are met all the same. */
  readonly companions?: readonly number[];
}

/** What is shown of a map laid flat; the distance is that of its relief, if it has one. */
export const MAP_SHOWS = ["radiance", "alpha", "distance"] as const;
export type MapShows = (typeof MAP_SHOWS)[number];

/** What is shown of the reflection. */
export interface Shown {
  diffuse: boolean;
  fresnel: boolean;
  distant: boolean;
  local: boolean;
}

type StoredGeometry =
  | Exclude<Geometry, Relief>
  | (Omit<Relief, "size" | "inverseDistance"> & { inverseDistance: ArrayDescription });

interface Extension {
  version: number;
  reflective: number[];
  parameterSpace: {
    axes: Axis[];
    orbit: OrbitDescription;
  };
  layers: (Omit<Layer, "parameterization" | "geometry" | "end"> & {
    parameterization?: string;
    geometry: StoredGeometry;
    end?: number;
  })[];
  base: string[];
  fadeDeg: number;
  samples: { maps: string[] }[];
  lodBias: number;
  sampleCount: number;
  onHull: ArrayDescription;
  irradiance: StoredIrradiance;
  ggxTable?: ArrayDescription;
  surface?: StoredSurface;
  /** Numbers of coated parts, share and roughness of their coats in the mean. */
  coats?: [number, number, number][];
  environment?: ArrayDescription | { uri: string; shape: number[] };
  traced?: { mostHits: number; companions?: number[] } & Record<Exclude<keyof Bvh, "companions">, ArrayDescription>;
}

/** The PEM in a scene.gltf; undefined where it holds none. Rejects with one sentence where it cannot be read. */
export async function readPem(scene: SceneFile): Promise<Pem | undefined> {
  const extension = extensionOf<Extension>(scene, EXTENSION, VERSION);
  if (extension === undefined) return undefined;
  const { files } = scene;
  const [parts, layers, onHull, irradiance, ggxTable, surface, environment, traced] = await Promise.all([
    readParts(scene, new Set(extension.reflective)),
    Promise.all(extension.layers.map((layer) => readLayer(layer, files))),
    files.array(Uint8Array, extension.onHull),
    readIrradiance(extension.irradiance, files),
    extension.ggxTable && readTable(extension.ggxTable, files),
    extension.surface && readSurface(extension.surface, files),
    extension.environment && readEnvironment(extension.environment, files),
    extension.traced && readTraced(extension.traced, files),
  ]);
  return {
    parts: partsWithMaps(ggxTable ? withCoats(parts, extension.coats ?? []) : parts.map(smooth), surface),
    axes: extension.parameterSpace.axes,
    orbit: readOrbit(extension.parameterSpace.orbit),
    layers,
    maps: extension.samples.map((sample) => sample.maps.map(files.resolve)),
    base: extension.base.map(files.resolve),
    fadeDeg: extension.fadeDeg,
    lodBias: extension.lodBias,
    sampleCount: extension.sampleCount,
    onHull,
    ...irradiance,
    lights: lightsOf(scene),
    ggxTable,
    surface,
    environment,
    traced,
  };
}

const FINEST_SAMPLES = 64; // finer levels than theirs show texels, which crawl as the camera moves

/** What the LOD of env maps is shifted by at so many samples a pixel. */
export function lodBiasAt(pem: Pick<Pem, "lodBias" | "sampleCount" | "traced">, samples: number): number {
  return pem.lodBias - (pem.traced ? 0.5 * Math.log2(Math.min(samples, FINEST_SAMPLES) / pem.sampleCount) : 0);
}

/** How much of the distant light comes from the base at a point, from 0 to 1. */
export function baseShare(
  { axes, orbit, maps, base, fadeDeg }: Pick<Pem, "axes" | "orbit" | "maps" | "base" | "fadeDeg">,
  point: ViewPoint,
): number {
  if (base.length === 0) return 0;
  if (maps.length === 0) return 1;
  const away = displacementDeg(axes, orbit, point);
  return fadeDeg > 0 ? Math.min(away / fadeDeg, 1) : Number(away > 0);
}

async function readTable(stored: ArrayDescription, files: SceneFile["files"]): Promise<GgxTable> {
  const [rows, columns] = stored.shape as [number, number, number];
  return { rows, columns, values: await files.array(Uint16Array, stored) };
}

/** A part without roughness and coat. */
const smooth = (part: Part): Part => ({ ...part, material: { ...part.material, roughness: 0, coat: undefined } });

function withCoats(parts: readonly Part[], coats: NonNullable<Extension["coats"]>): Part[] {
  const means = new Map(coats.map(([number, share, roughness]) => [number, [share, roughness] as const]));
  return parts.map((part, number) => {
    const coatMean = means.get(number);
    return coatMean ? { ...part, coatMean } : part;
  });
}

async function readTraced(stored: NonNullable<Extension["traced"]>, files: SceneFile["files"]): Promise<Traced> {
  if (!(stored.mostHits >= 1 && stored.mostHits <= MOST_HITS)) {
    throw new Error(`Rays of this scene meet ${stored.mostHits} mirrors, not 1 to ${MOST_HITS}; bake it again.`);
  }
  const [order, leafCounts, directions] = await Promise.all([
    files.array(Uint32Array, stored.order),
    files.array(Uint8Array, stored.leafCounts),
    files.array(Uint32Array, stored.directions),
  ]);
  return { mostHits: stored.mostHits, bvh: { order, leafCounts, directions, companions: stored.companions ?? [] } };
}

/** Coded, or an array of floats. */
async function readEnvironment(
  stored: NonNullable<Extension["environment"]>,
  files: SceneFile["files"],
): Promise<Environment> {
  const [height, width] = stored.shape as [number, number, number];
  if ("byteOffset" in stored) return { width, height, texels: halfTexels(await files.array(Float32Array, stored)) };
  const file = await fetchFile(files.resolve(stored.uri));
  return {
    width,
    height,
    texels: await codedPicture(await file.arrayBuffer(), { rows: height, columns: width }, stored.uri),
  };
}

/** Of a layer's maps: radiance, and alpha where something may be seen behind it. */
export const channelsOf = ({ kind, end }: Layer): 3 | 4 =>
  kind === "distant" && end === Number.POSITIVE_INFINITY ? 3 : 4;

async function readLayer(item: Extension["layers"][number], files: SceneFile["files"]): Promise<Layer> {
  const { parameterization = "cube", end = Number.POSITIVE_INFINITY } = item;
  if (!isParameterization(parameterization)) {
    throw new Error(`The maps of ${item.name} are ${parameterization} maps, which this viewer does not know.`);
  }
  return { ...item, end, parameterization, geometry: await readGeometry(item.geometry, files) };
}

async function readGeometry(stored: StoredGeometry, files: SceneFile["files"]): Promise<Geometry> {
  if (stored.kind !== "relief") return stored;
  const size = stored.inverseDistance.shape[1] as number;
  return { ...stored, size, inverseDistance: await files.array(Uint16Array, stored.inverseDistance) };
}
