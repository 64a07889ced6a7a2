// The maps that are on the device: a bounded set of the parameter space's samples, fetched as the view needs them.

import { fetchFile } from "../../files/gltf";
import { mapLevels } from "../../files/ktx2";
import { cameraAt, pointOf, viewFromWorld } from "../../maths/camera";
import { pointOfSample } from "../../maths/parameter-space";
import { mapBytes, PARAMETERIZATIONS } from "../../maths/parameterization";
import type { Layer, Pem } from "../../scene/pem";
import { createMapArray, writeMap } from "../device/textures";
import type { Blended } from "./layouts";

const MOST_ARRAY_LAYERS = 256; // WebGPU's default: 42 cubes
const MAP_MEMORY = 256 * 2 ** 20; // bytes of all arrays
const AT_ONCE = 2; // samples on their way at the same time
const AHEAD = 6; // samples wished for: those shown, and their nearest neighbours

export class ResidentMaps {
  /** One array a layer; a resident sample has the same slot in all of them. */
  readonly arrays: readonly GPUTexture[];
  readonly slotCount: number;
  readonly bytes: number;
  private readonly slots = new Map<number, number>(); // of samples, the least recently shown first
  private readonly onTheWay = new Map<number, AbortController>();
  private wishes: readonly number[] = [];

  /** `onArrival` is called with each sample that has come, `onFailure` with one sentence. */
  constructor(
    private readonly device: GPUDevice,
    private readonly pem: Pem,
    private readonly onArrival: (sample: number) => void,
    private readonly onFailure: (message: string) => void,
  ) {
    const bytesPerSlot = pem.layers.reduce((sum, layer) => sum + mapBytes(layer), 0);
    const faces = pem.layers.map((layer) => PARAMETERIZATIONS[layer.parameterization].faceCount);
    const most = Math.floor(MOST_ARRAY_LAYERS / Math.max(1, ...faces));
    const blended = 2 ** pem.axes.length;
    const affordable = Math.max(blended, Math.floor(MAP_MEMORY / Math.max(bytesPerSlot, 1)));
    this.slotCount = Math.min(most, affordable, pem.maps.length);
    this.bytes = this.slotCount * bytesPerSlot;
    this.arrays = pem.layers.map((layer) => createMapArray(device, layer, this.slotCount));
  }

  get residentCount(): number {
    return this.slots.size;
  }

  has(sample: number): boolean {
    return this.slots.has(sample);
  }

  /** Ask for samples, the most wanted first. Those that are no longer wanted stop coming. */
  wish(samples: readonly number[]): void {
    this.wishes = samples.slice(0, Math.min(AHEAD, this.slotCount));
    for (const [sample, controller] of this.onTheWay) {
      if (!this.wishes.includes(sample)) {
        this.onTheWay.delete(sample);
        controller.abort();
      }
    }
    this.fetchNext();
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
      const point = { ...pointOf(orbit), ...pointOfSample(axes, sample) };
      return { slot, weight, mapFromWorld: viewFromWorld(cameraAt(orbit, point, 1, 1)) };
    });
  }

  private fetchNext(): void {
    for (const sample of this.wishes) {
      if (this.onTheWay.size >= AT_ONCE) return;
      if (!this.slots.has(sample) && !this.onTheWay.has(sample)) void this.fetch(sample);
    }
  }

  private async fetch(sample: number): Promise<void> {
    const controller = new AbortController();
    this.onTheWay.set(sample, controller);
    try {
      const files = this.pem.maps[sample] as readonly string[];
      const maps = await Promise.all(
        this.pem.layers.map(async (layer, k) => {
          const file = await fetchFile(files[k] as string, controller.signal);
          return mapLevels(await file.arrayBuffer(), layer, files[k] as string);
        }),
      );
      if (controller.signal.aborted) return;
      const slot = this.freeSlot();
      maps.forEach((levels, k) => {
        writeMap(this.device, this.arrays[k] as GPUTexture, slot, this.pem.layers[k] as Layer, levels);
      });
      this.slots.set(sample, slot);
    } catch (error) {
      if (controller.signal.aborted) return;
      this.wishes = []; // until the view moves: a file that is missing would be asked for without end
      this.onFailure(error instanceof Error ? error.message : String(error));
      return;
    } finally {
      if (this.onTheWay.get(sample) === controller) this.onTheWay.delete(sample);
    }
    this.onArrival(sample);
    this.fetchNext();
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
