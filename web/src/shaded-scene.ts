// Opens a mesh in an environment over HTTP: what reflet.view.shaded_scene writes.

import { type Orbit, type OrbitDescription, readOrbit } from "./camera";
import { type ArrayDescription, extensionOf, fetchFile, type Part, readParts, type SceneFile } from "./gltf";
import { LOOKUPS, type LookupDirection } from "./gpu/material-programs";
import type { LobeTaps } from "./gpu/probe-filter";
import { mapLevels } from "./ktx2";
import type { Material } from "./material";
import { isParameterization, type MapShape } from "./parameterization";
import type { Vec3 } from "./vectors";

const EXTENSION = "REFLET_environment_mapped_material";
const VERSION = 1;

/** A map with all its mip levels, in half float. */
export interface LoadedMap extends MapShape {
  readonly levels: readonly Uint8Array[];
}

/** A map that is shown as it is, as a material. */
export interface NamedMap extends LoadedMap {
  readonly name: string;
  readonly lookup: LookupDirection;
}

/** A metal's complex index of refraction n - ik. */
export interface Metal {
  readonly name: string;
  readonly n: Vec3;
  readonly k: Vec3;
}

/** A material as the viewer opens with it: one of the kinds, or a map by name. */
export type Shown = Material | { readonly kind: "map"; readonly map: string };

export interface ShadedScene {
  readonly parts: readonly Part[];
  readonly orbit: Orbit;
  readonly environment: LoadedMap; // a cube
  readonly diffuse: LoadedMap;
  /** What GGX's weights and lobe follow from (material.wgsl): rows by perceptual_roughness, columns by n·v. */
  readonly dfg: { readonly rows: number; readonly columns: number; readonly values: Float32Array };
  /** Lobes that levels 1 to the last but one of the GGX cube are filtered with, and the rows of its level 0. */
  readonly ggx: { readonly lobes: readonly LobeTaps[]; readonly size: number };
  readonly phongSize: number;
  readonly metals: readonly Metal[];
  readonly maps: readonly NamedMap[];
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
  materials: [Shown, ...Shown[]];
}

/** The mesh and environment in a scene.gltf; undefined where it holds none. Rejects with one sentence. */
export async function readShadedScene(scene: SceneFile): Promise<ShadedScene | undefined> {
  const extension = extensionOf<Extension>(scene, EXTENSION, VERSION);
  if (extension === undefined) return undefined;
  const { files } = scene;
  const map = async ({ uri, parameterization, size }: MapDescription): Promise<LoadedMap> => {
    if (!isParameterization(parameterization)) {
      throw new Error(`${uri} is a ${parameterization} map, which this viewer does not know.`);
    }
    const file = await (await fetchFile(files.resolve(uri))).arrayBuffer();
    return { parameterization, size, levels: mapLevels(file, { parameterization, size }, uri) };
  };
  const [parts, environment, diffuse, dfg, lobes, maps] = await Promise.all([
    readParts(scene, new Set([0])),
    map(extension.environment),
    map(extension.diffuse),
    files.array(Float32Array, extension.dfg),
    Promise.all(extension.ggx.lobes.map((lobe) => files.array(Float32Array, lobe))),
    Promise.all(
      extension.maps.map(async ({ name, lookup, ...rest }) => {
        const direction = LOOKUPS.find((known) => known === lookup);
        if (direction === undefined) throw new Error(`${name} is looked up by ${lookup}, which this viewer cannot do.`);
        return { ...(await map(rest)), name, lookup: direction };
      }),
    ),
  ]);
  const { orbit, ggx, phongSize, metals, materials } = extension;
  const [rows, columns] = extension.dfg.shape as [number, number];
  return {
    parts,
    orbit: readOrbit(orbit),
    environment,
    diffuse,
    dfg: { rows, columns, values: dfg },
    ggx: { lobes, size: ggx.size },
    phongSize,
    metals,
    maps,
    materials,
  };
}
