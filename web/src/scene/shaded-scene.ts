// Opens a mesh in an environment over HTTP: what reflet.view.shaded_scene writes.

import type { ArrayDescription } from "../files/arrays";
import { extensionOf, fetchFile, type Part, readParts, type SceneFile } from "../files/gltf";
import { mapLevels } from "../files/ktx2";
import { type Orbit, type OrbitDescription, readOrbit } from "../maths/camera";
import { isParameterization, type MapShape } from "../maths/parameterization";
import type { Vec3 } from "../maths/vectors";
import { LOOKUPS, type LookupDirection, type Material } from "./material";

const EXTENSION = "REFLET_environment_mapped_material";
const VERSION = 2;

/** A map with all its mip levels, in half float. */
export interface LoadedMap extends MapShape {
  readonly levels: readonly Uint8Array[];
}

/** A map that is shown as it is, as a material. */
export interface NamedMap extends LoadedMap {
  readonly name: string;
  readonly lookup: LookupDirection;
}

/** A small table of shaders: so many values an entry as fit, of at most four. */
export interface Table {
  readonly rows: number;
  readonly columns: number;
  readonly values: Float32Array;
}

/** A lobe as taps: x, y, z around +z, blur in radians, weights of red, green and blue (reflet.view.brdf_map_files). */
export type LobeTaps = Float32Array;

/** A measured BRDF as the maps of its lobes (lobes.wgsl): slices one after the other, in one file. */
export interface BrdfMap extends LoadedMap {
  readonly name: string;
  readonly slices: number;
  readonly lobes: Table;
  /** Of each slice, to filter other light. */
  readonly taps: readonly LobeTaps[];
}

/** A metal's complex index of refraction n - ik. */
export interface Metal {
  readonly name: string;
  readonly n: Vec3;
  readonly k: Vec3;
}

/** A material as the viewer opens with it: one of the kinds, or a map or a BRDF's table by name. */
export type Shown =
  | Material
  | { readonly kind: "map"; readonly map: string }
  | { readonly kind: "table"; readonly table: string };

export interface ShadedScene {
  readonly parts: readonly Part[];
  readonly orbit: Orbit;
  readonly environment: LoadedMap; // a cube
  readonly diffuse: LoadedMap;
  /** What GGX's weights and lobe follow from (material.wgsl): rows by perceptual_roughness, columns by n·v. */
  readonly dfg: Table;
  /** Lobes that levels 1 to the last but one of the GGX cube are filtered with, and the rows of its level 0. */
  readonly ggx: { readonly lobes: readonly LobeTaps[]; readonly size: number };
  readonly phongSize: number;
  readonly metals: readonly Metal[];
  readonly maps: readonly NamedMap[];
  readonly tables: readonly BrdfMap[];
  /** The first of their kinds; the viewer opens with the first of all. */
  readonly materials: readonly [Shown, ...Shown[]];
}

interface MapDescription {
  uri: string;
  parameterization: string;
  size: number;
}

interface Extension {
  version: number;
  orbit: OrbitDescription;
  environment: MapDescription;
  diffuse: MapDescription;
  dfg: ArrayDescription;
  ggx: { size: number; lobes: ArrayDescription[] };
  phongSize: number;
  metals: Metal[];
  maps: (MapDescription & { name: string; lookup: string })[];
  tables: (MapDescription & { name: string; slices: number; lobes: ArrayDescription; taps: ArrayDescription[] })[];
  materials: [Shown, ...Shown[]];
}

/** The mesh and environment in a scene.gltf; undefined where it holds none. Rejects with one sentence. */
export async function readShadedScene(scene: SceneFile): Promise<ShadedScene | undefined> {
  const extension = extensionOf<Extension>(scene, EXTENSION, VERSION);
  if (extension === undefined) return undefined;
  const { files } = scene;
  const map = async ({ uri, parameterization, size }: MapDescription, count = 1): Promise<LoadedMap> => {
    if (!isParameterization(parameterization)) {
      throw new Error(`${uri} is a ${parameterization} map, which this viewer does not know.`);
    }
    const file = await (await fetchFile(files.resolve(uri))).arrayBuffer();
    return { parameterization, size, levels: mapLevels(file, { parameterization, size }, uri, count) };
  };
  const table = async (array: ArrayDescription): Promise<Table> => {
    const [rows, columns] = array.shape as [number, number];
    return { rows, columns, values: await files.array(Float32Array, array) };
  };
  const lists = (of: ArrayDescription[]) => Promise.all(of.map((each) => files.array(Float32Array, each)));
  const [parts, environment, diffuse, dfg, lobes, maps, tables] = await Promise.all([
    readParts(scene, new Set([0])),
    map(extension.environment),
    map(extension.diffuse),
    table(extension.dfg),
    lists(extension.ggx.lobes),
    Promise.all(
      extension.maps.map(async ({ name, lookup, ...rest }) => {
        const direction = LOOKUPS.find((known) => known === lookup);
        if (direction === undefined) throw new Error(`${name} is looked up by ${lookup}, which this viewer cannot do.`);
        return { ...(await map(rest)), name, lookup: direction };
      }),
    ),
    Promise.all(
      extension.tables.map(async ({ name, slices, lobes: axes, taps, ...rest }) => {
        const [slicesOf, lobesOf, tapsOf] = await Promise.all([map(rest, slices), table(axes), lists(taps)]);
        return { ...slicesOf, name, slices, lobes: lobesOf, taps: tapsOf };
      }),
    ),
  ]);
  const { orbit, ggx, phongSize, metals, materials } = extension;
  return {
    parts,
    orbit: readOrbit(orbit),
    environment,
    diffuse,
    dfg,
    ggx: { lobes, size: ggx.size },
    phongSize,
    metals,
    maps,
    tables,
    materials,
  };
}
