// Draws a mesh of any material in one environment: twin of reflet.render.materials.material_renderer, with maps filtered here.

import type { Part } from "../../files/gltf";
import type { Camera } from "../../maths/camera";
import { samplePositions } from "../../maths/sample-pattern";
import type { Lamp } from "../../scene/lamp";
import { diffuses, MATERIAL_BYTES, type Material, materialUniform } from "../../scene/material";
import type { BrdfMap, LoadedMap, NamedMap, ShadedScene, Shown, Table } from "../../scene/shaded-scene";
import { PictureSum } from "../device/picture-sum";
import { createMapArray, writeMap } from "../device/textures";
import { BrdfMapFilter } from "../filters/brdf-map-filter";
import { Lamplight, type Light } from "../filters/lamplight";
import { PhongParaboloidFilter } from "../filters/phong-paraboloid";
import { ProbeFilter } from "../filters/probe-filter";
import { createEnvMap, EnvMapGroup, type EnvMapTexture, type Rotation } from "../maps/env-map";
import { MaterialPrograms, type MeshVariant, VERTEX_FLOATS } from "./material-programs";
import { VIEW_BYTES, viewUniform } from "./view-uniform";

/** What a frame shows. */
export interface MaterialView {
  readonly camera: Camera;
  readonly material: Shown;
  readonly mapFromWorld: Rotation; // of the environment
  readonly backdrop: boolean;
  readonly lamp: Lamp | undefined; // that is added to the environment
}

/** A light as it is looked up. */
interface LightGroups {
  readonly light: Light;
  readonly sharp: EnvMapGroup;
  readonly backdrop: EnvMapGroup;
  readonly material: GPUBindGroup;
  /** What is in it: filtered maps are made again when that changes. */
  name: string;
}

/** What a material looks up, and how. */
interface Reflected {
  readonly map: EnvMapGroup;
  readonly material: GPUBindGroup;
  readonly variant: MeshVariant;
  readonly roughness: number | undefined;
  readonly drawn: boolean; // by hand: its levels are for the picture's own pixels
}

/** What a table looks up. */
interface ByLobes {
  readonly map: EnvMapGroup;
  readonly material: GPUBindGroup;
}

const WHITE_MIRROR: Material = { kind: "mirror", reflectance: [1, 1, 1] };
const PAPER: GPUColor = { r: 1, g: 1, b: 1, a: 0 };
const NOTHING: GPUColor = { r: 0, g: 0, b: 0, a: 0 };
const MIDDLE = [0.5, 0.5] as const;

export class MaterialRenderer {
  private readonly programs: MaterialPrograms;
  private readonly viewUniform: GPUBuffer;
  private readonly viewGroup: GPUBindGroup;
  private readonly materialBuffer: GPUBuffer;
  private readonly dfg: GPUTextureView;
  private readonly meshes: readonly { vertices: GPUBuffer; triangles: GPUBuffer; count: number }[];
  private readonly plain: LightGroups;
  private lamplit: (LightGroups & { readonly light: Lamplight }) | undefined;
  private readonly drawnMaps = new Map<string, EnvMapGroup>();
  private readonly tables = new Map<string, ByLobes>();
  private readonly litTables = new Map<string, ByLobes & { filter: BrdfMapFilter; shows: string }>();
  private glossy: { filter: ProbeFilter; group: EnvMapGroup; shows: string } | undefined;
  private phong: { filter: PhongParaboloidFilter; group: EnvMapGroup; shows: string } | undefined;

  private constructor(
    private readonly device: GPUDevice,
    private readonly scene: ShadedScene,
    readonly sum: PictureSum,
  ) {
    this.programs = new MaterialPrograms(device);
    this.viewUniform = this.uniform(VIEW_BYTES);
    const place = this.buffer(
      new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
      GPUBufferUsage.STORAGE,
    );
    this.viewGroup = device.createBindGroup({
      layout: this.programs.viewLayout,
      entries: [
        { binding: 0, resource: { buffer: this.viewUniform } },
        { binding: 1, resource: { buffer: place } },
      ],
    });
    this.materialBuffer = this.uniform(MATERIAL_BYTES);
    this.dfg = this.table(scene.dfg).createView();
    this.plain = this.groupsOf({ environment: this.upload(scene.environment), diffuse: this.upload(scene.diffuse) });
    this.meshes = scene.parts.map((part) => ({
      vertices: this.buffer(packVertices(part), GPUBufferUsage.VERTEX),
      triangles: this.buffer(part.indices, GPUBufferUsage.INDEX),
      count: part.indices.length,
    }));
  }

  static async create(device: GPUDevice, scene: ShadedScene, screen: GPUTextureFormat): Promise<MaterialRenderer> {
    return new MaterialRenderer(device, scene, await PictureSum.create(device, screen));
  }

  /** Draws four samples a pixel in one pass, of one colour a triangle: the whole sum. */
  drawMultisampled(view: MaterialView): void {
    this.draw(view, MIDDLE, 1, true, true);
  }

  /** Adds the next sub-sample of a picture of `sampleCount` to the sum, emptying it before the first. */
  drawNextSample(view: MaterialView, sampleCount: number, first: boolean): void {
    const at = samplePositions(sampleCount)[first ? 0 : this.sum.count] ?? MIDDLE;
    this.draw(view, at, sampleCount, first, false);
  }

  private draw(
    view: MaterialView,
    at: readonly [number, number],
    sampleCount: number,
    first: boolean,
    multi: boolean,
  ): void {
    const { device, programs } = this;
    const { camera, material, mapFromWorld } = view;
    const light = this.light(view.lamp);
    const reflected = this.reflected(material, light);
    // Samples share a pixel: each may look maps up as much sharper.
    const lodBias = -0.5 * Math.log2(sampleCount);
    device.queue.writeBuffer(this.viewUniform, 0, viewUniform(camera, at));
    device.queue.writeBuffer(this.materialBuffer, 0, materialUniform(plain(material)));
    reflected.map.write({
      mapFromWorld,
      lodBias: reflected.drawn ? 0 : lodBias,
      roughness: reflected.roughness,
    });
    light.backdrop.write({ mapFromWorld, lodBias, roughness: undefined });
    this.sum.add(camera, first, multi, reflected.drawn ? PAPER : NOTHING, (pass) => {
      pass.setBindGroup(0, this.viewGroup);
      programs.setMesh(pass, reflected.map, reflected.material, reflected.variant, multi);
      for (const { vertices, triangles, count } of this.meshes) {
        pass.setVertexBuffer(0, vertices);
        pass.setIndexBuffer(triangles, "uint32");
        pass.drawIndexed(count);
      }
      if (view.backdrop && !reflected.drawn) programs.drawBackdrop(pass, light.backdrop, multi);
    });
  }

  /** The environment, with the lamp as it is now. */
  private light(lamp: Lamp | undefined): LightGroups {
    if (lamp === undefined) return this.plain;
    if (this.lamplit === undefined) {
      const light = new Lamplight(this.device, this.plain.light.environment);
      this.lamplit = { ...this.groupsOf(light), light };
    }
    const { lamplit } = this;
    const name = JSON.stringify(lamp);
    if (lamplit.name !== name) {
      lamplit.name = name;
      this.submit((encoder) => lamplit.light.show(encoder, lamp));
    }
    return lamplit;
  }

  private groupsOf(light: Light): LightGroups {
    const { environment, diffuse } = light;
    const material = this.groupOfMaterial(this.dfg, diffuse);
    return { light, sharp: this.groupOf(environment), backdrop: this.groupOf(environment), material, name: "" };
  }

  /** What a material looks up; filtered now, where that has not been done. */
  private reflected(material: Shown, light: LightGroups): Reflected {
    if (material.kind === "map") {
      const map = this.scene.maps.find(({ name }) => name === material.map);
      if (map === undefined) throw new Error(`There is no map ${material.map}.`);
      const variant = { diffuseMap: undefined, lookup: map.lookup, byLobes: false };
      return { map: this.drawnMap(map), material: light.material, variant, roughness: undefined, drawn: true };
    }
    if (material.kind === "table") {
      const table = this.scene.tables.find(({ name }) => name === material.table);
      if (table === undefined) throw new Error(`There is no table ${material.table}.`);
      const { parameterization } = light.light.diffuse;
      const variant = { diffuseMap: parameterization, lookup: "reflection", byLobes: true } as const;
      const lobes = light === this.plain ? this.lobesOf(table) : this.litLobesOf(table, light);
      return { ...lobes, variant, roughness: undefined, drawn: false };
    }
    const diffuseMap = diffuses(material) ? light.light.diffuse.parameterization : undefined;
    const of = (map: EnvMapGroup, roughness?: number): Reflected => ({
      map,
      material: light.material,
      variant: { diffuseMap, lookup: "reflection", byLobes: false },
      roughness,
      drawn: false,
    });
    switch (material.kind) {
      case "phong":
        return of(this.phongMap(material.exponent, light));
      case "ggx":
        return of(this.glossyMap(light), material.roughness);
      default:
        return of(light.sharp);
    }
  }

  private drawnMap(map: NamedMap): EnvMapGroup {
    let group = this.drawnMaps.get(map.name);
    if (group === undefined) {
      group = this.groupOf(this.upload(map));
      this.drawnMaps.set(map.name, group);
    }
    return group;
  }

  /** As they were filtered beforehand. */
  private lobesOf(table: BrdfMap): ByLobes {
    let lobes = this.tables.get(table.name);
    if (lobes === undefined) {
      const { parameterization, size, slices, levels } = table;
      const texture = createMapArray(this.device, table, slices);
      for (let k = 0; k < slices; k++) {
        writeMap(
          this.device,
          texture,
          k,
          table,
          levels.map((level) => level.subarray((k * level.length) / slices, ((k + 1) * level.length) / slices)),
        );
      }
      lobes = {
        map: this.groupOf({ parameterization, size, texture }),
        material: this.groupOfMaterial(this.table(table.lobes).createView(), this.plain.light.diffuse),
      };
      this.tables.set(table.name, lobes);
    }
    return lobes;
  }

  /** Filtered anew when the light changes. */
  private litLobesOf(table: BrdfMap, { light, name }: LightGroups): ByLobes {
    let lobes = this.litTables.get(table.name);
    if (lobes === undefined) {
      const filter = new BrdfMapFilter(this.device, table);
      const material = this.groupOfMaterial(this.table(table.lobes).createView(), light.diffuse);
      lobes = { map: this.groupOf(filter.result), material, filter, shows: "nothing" };
      this.litTables.set(table.name, lobes);
    }
    const { filter, shows } = lobes;
    if (shows !== name) {
      lobes.shows = name;
      this.submit((encoder) => filter.refilter(encoder, light.environment.texture));
    }
    return lobes;
  }

  /** Filtered anew when the exponent or the light changes. */
  private phongMap(exponent: number, { light, name }: LightGroups): EnvMapGroup {
    if (this.phong === undefined) {
      const filter = new PhongParaboloidFilter(this.device, this.scene.phongSize);
      this.phong = { filter, group: this.groupOf(filter.result), shows: "nothing" };
    }
    const { filter, group, shows } = this.phong;
    const wanted = `${exponent} ${name}`;
    if (shows !== wanted) {
      this.phong.shows = wanted;
      this.submit((encoder) => filter.refilter(encoder, light.environment, exponent));
    }
    return group;
  }

  /** For every roughness; filtered once for each light. */
  private glossyMap({ light, name }: LightGroups): EnvMapGroup {
    if (this.glossy === undefined) {
      const { size, lobes } = this.scene.ggx;
      const filter = new ProbeFilter(this.device, size, lobes);
      this.glossy = { filter, group: this.groupOf(filter.result), shows: "nothing" };
    }
    const { filter, group, shows } = this.glossy;
    if (shows !== name) {
      this.glossy.shows = name;
      this.submit((encoder) => filter.refilter(encoder, light.environment.texture));
    }
    return group;
  }

  private submit(record: (encoder: GPUCommandEncoder) => void): void {
    const encoder = this.device.createCommandEncoder();
    record(encoder);
    this.device.queue.submit([encoder.finish()]);
  }

  private groupOf(map: EnvMapTexture): EnvMapGroup {
    return new EnvMapGroup(this.device, this.programs.mapLayout, map);
  }

  private upload(map: LoadedMap): EnvMapTexture {
    const { parameterization, size, levels } = map;
    const out = createEnvMap(this.device, parameterization, size, levels.length, "rgba16float");
    writeMap(this.device, out.texture, 0, map, levels);
    return out;
  }

  /** Bind group 2. */
  private groupOfMaterial(table: GPUTextureView, diffuse: EnvMapTexture): GPUBindGroup {
    return this.device.createBindGroup({
      layout: this.programs.materialLayout,
      entries: [
        { binding: 0, resource: { buffer: this.materialBuffer } },
        { binding: 1, resource: diffuse.texture.createView({ dimension: "2d-array" }) },
        { binding: 2, resource: table },
      ],
    });
  }

  private table({ rows, columns, values }: Table): GPUTexture {
    const texels = new Float32Array(4 * rows * columns);
    const channels = values.length / (rows * columns);
    for (let k = 0; k < rows * columns; k++) texels.set(values.subarray(channels * k, channels * (k + 1)), 4 * k);
    const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
    const texture = this.device.createTexture({ size: [columns, rows], format: "rgba32float", usage });
    this.device.queue.writeTexture({ texture }, texels, { bytesPerRow: 16 * columns }, [columns, rows]);
    return texture;
  }

  private uniform(size: number): GPUBuffer {
    return this.device.createBuffer({ size, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  }

  private buffer(data: Float32Array | Uint32Array, usage: GPUBufferUsageFlags): GPUBuffer {
    const buffer = this.device.createBuffer({ size: data.byteLength, usage: usage | GPUBufferUsage.COPY_DST });
    this.device.queue.writeBuffer(buffer, 0, data as Float32Array<ArrayBuffer>);
    return buffer;
  }
}

/** A map that is shown as it is counts as a white mirror's; lobes need none of this. */
const plain = (material: Shown): Material =>
  material.kind === "map" || material.kind === "table" ? WHITE_MIRROR : material;

function packVertices({ positions, normals, uv }: Part): Float32Array {
  const count = positions.length / 3;
  const out = new Float32Array(VERTEX_FLOATS * count);
  for (let k = 0; k < count; k++) {
    out.set(positions.subarray(3 * k, 3 * k + 3), VERTEX_FLOATS * k);
    out.set(normals.subarray(3 * k, 3 * k + 3), VERTEX_FLOATS * k + 3);
    if (uv) out.set(uv.subarray(2 * k, 2 * k + 2), VERTEX_FLOATS * k + 6);
  }
  return out;
}
