// The maps that are on the device: those that serve every viewpoint, and a bounded set of the parameter space's samples,
// fetched as the view needs them.

import { fetchFile } from "../../files/gltf";
import { readMapLevels } from "../../files/map-file";
import { cameraAt, pointOf, type ViewPoint, viewFromWorld } from "../../maths/camera";
import { pointOfSample } from "../../maths/parameter-space";
import { mapBytes, PARAMETERIZATIONS } from "../../maths/parameterization";
import { channelsOf, type Layer, type Pem } from "../../scene/pem";
import { type Stack, stacksOf } from "../../scene/stacks";
import { createMapArray, writeMap } from "../device/textures";
import type { Blended } from "./view";

const MOST_ARRAY_LAYERS = 256; // WebGPU's default: 42 cubes
const MAP_MEMORY = 256 * 2 ** 20; // bytes of all arrays
const AT_ONCE = 2; // samples on their way at the same time
const AHEAD = 6; // samples wished for: those shown, and their nearest neighbours
const BASE = -1; // its number among the samples on their way

export class ResidentMaps {
  readonly stacks: readonly Stack[];
  /** One array a stack; a resident sample has the same slot in all of them, the base one behind those of all samples. */
  readonly arrays: readonly GPUTexture[];
  readonly slotCount: number;
  readonly bytes: number;
  private readonly slots = new Map<number, number>(); // of samples, the least recently shown first
  private readonly onTheWay = new Map<number, AbortController>();
  private wishes: readonly number[] = [];
  private baseIsHere = false;

  /** `onArrival` is called when maps have come, of the base without a sample; `onFailure` with one sentence. */
  constructor(
    private readonly device: GPUDevice,
    private readonly pem: Pem,
    private readonly onArrival: (sample?: number) => void,
    private readonly onFailure: (message: string) => void,
  ) {
    this.stacks = stacksOf(pem.layers);
    const bytesOf = (layers: readonly Layer[]) => layers.reduce((sum, layer) => sum + mapBytes(layer), 0);
    const bytesPerSlot = bytesOf(pem.layers);
    const baseBytes = pem.base.length ? bytesOf(pem.layers.filter(({ kind }) => kind === "distant")) : 0;
    const forBase = ({ kind }: Stack) => (kind === "distant" && pem.base.length ? 1 : 0);
    const slotsOf = (stack: Stack) => {
      const arrayLayers = PARAMETERIZATIONS[stack.shape.parameterization].faceCount * stack.layers.length;
      return Math.floor(MOST_ARRAY_LAYERS / arrayLayers) - forBase(stack);
    };
    const most = Math.min(MOST_ARRAY_LAYERS, ...this.stacks.map(slotsOf));
    const affordable = Math.floor((MAP_MEMORY - baseBytes) / Math.max(bytesPerSlot, 1));
    this.slotCount = Math.min(most, Math.max(2 ** pem.axes.length, affordable), pem.maps.length);
    this.bytes = this.slotCount * bytesPerSlot + baseBytes;
    this.arrays = this.stacks.map((stack) => {
      const slots = Math.max(this.slotCount + forBase(stack), 1); // an array may not be empty
      return createMapArray(device, stack.shape, slots * stack.layers.length);
    });
    if (!this.hasBase) void this.fetch(BASE);
  }

  get residentCount(): number {
    return this.slots.size;
  }

  has(sample: number): boolean {
    return this.slots.has(sample);
  }

  /** Whether the base is here, or there is none to come. */
  get hasBase(): boolean {
    return this.baseIsHere || this.pem.base.length === 0;
  }

  /** Ask for samples, the most wanted first. Those that are no longer wanted stop coming. */
  wish(samples: readonly number[]): void {
    this.wishes = samples.slice(0, Math.min(AHEAD, this.slotCount));
    if (!this.hasBase && !this.onTheWay.has(BASE)) void this.fetch(BASE); // it failed to come
    for (const [sample, controller] of this.onTheWay) {
      if (sample !== BASE && !this.wishes.includes(sample)) {
        this.onTheWay.delete(sample);
        controller.abort();
      }
    }
    this.fetchNext();
  }

  /** Nothing is wanted any more. */
  stop(): void {
    this.wishes = [];
    for (const controller of this.onTheWay.values()) controller.abort();
  }

  /** What can be shown now: the wanted samples with their weights where all are here, else the nearest that is. */
  shown(wanted: ReadonlyMap<number, number>, byDistance: readonly number[]): Blended[] {
    const complete = [...wanted.keys()].every((sample) => this.slots.has(sample));
    const nearest = byDistance.find((sample) => this.slots.has(sample));
    const weights = complete ? wanted : new Map(nearest === undefined ? [] : [[nearest, 1]]);
    return [...weights].map(([sample, weight]) => {
      const slot = this.slots.get(sample) as number;
      this.slots.delete(sample); // and back in at the end: the most recently shown
      this.slots.set(sample, slot);
      const { axes, orbit } = this.pem;
      return this.blended(slot, weight, { ...pointOf(orbit), ...pointOfSample(axes, sample) });
    });
  }

  /** The base with its share of the distant light. */
  base(share: number): Blended {
    return this.blended(this.slotCount, share, pointOf(this.pem.orbit));
  }

  private blended(slot: number, weight: number, point: ViewPoint): Blended {
    return { slot, weight, mapFromWorld: viewFromWorld(cameraAt(this.pem.orbit, point, 1, 1)) };
  }

  private fetchNext(): void {
    if (!this.hasBase) return; // it serves every viewpoint: nothing else shows as much as soon
    for (const sample of this.wishes) {
      if (this.onTheWay.size >= AT_ONCE) return;
      if (!this.slots.has(sample) && !this.onTheWay.has(sample)) void this.fetch(sample);
    }
  }

  private async fetch(sample: number): Promise<void> {
    const controller = new AbortController();
    this.onTheWay.set(sample, controller);
    try {
      const maps = await this.levels(sample, controller.signal);
      if (controller.signal.aborted) return;
      const slot = sample === BASE ? this.slotCount : this.freeSlot();
      this.stacks.forEach(({ layers, shape }, k) => {
        layers.forEach((layer, shell) => {
          const levels = maps.get(layer);
          if (levels) writeMap(this.device, this.arrays[k] as GPUTexture, slot * layers.length + shell, shape, levels);
        });
      });
      if (sample === BASE) this.baseIsHere = true;
      else this.slots.set(sample, slot);
    } catch (error) {
      if (controller.signal.aborted) return;
      this.wishes = []; // until the view moves: a file that is missing would be asked for without end
      this.onFailure(error instanceof Error ? error.message : String(error));
      return;
    } finally {
      if (this.onTheWay.get(sample) === controller) this.onTheWay.delete(sample);
    }
    this.onArrival(sample === BASE ? undefined : sample);
    this.fetchNext();
  }

  /** The maps of a sample, or of the base, by the number of their layer. */
  private async levels(sample: number, signal: AbortSignal): Promise<Map<number, Uint8Array[]>> {
    const numbers = this.pem.layers
      .map((_, number) => number)
      .filter((number) => sample !== BASE || this.pem.layers[number]?.kind === "distant");
    const files = (sample === BASE ? this.pem.base : this.pem.maps[sample]) as readonly string[];
    const maps = await Promise.all(
      numbers.map(async (number, k) => {
        const file = await fetchFile(files[k] as string, signal);
        const layer = this.pem.layers[number] as Layer;
        return readMapLevels(await file.arrayBuffer(), layer, channelsOf(layer), files[k] as string);
      }),
    );
    return new Map(maps.map((levels, k) => [numbers[k] as number, levels]));
  }

  /** A slot never used, or that of the sample shown least recently which nobody wishes for now. */
  private freeSlot(): number {
    if (this.slots.size < this.slotCount) return this.slots.size;
    for (const [sample, slot] of this.slots) {
      if (!this.wishes.includes(sample)) {
        this.slots.delete(sample);
        return slot;
      }
    }
    throw new Error("All resident maps are wanted at once.");
  }
}
