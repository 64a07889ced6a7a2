// Draws a PEM on a canvas: at once, coarsely if need be, whenever something changes; then, at rest, with all sub-samples.

import { cameraAt, pointOf, type ViewPoint } from "./camera";
import { asKind } from "./geometry";
import { Renderer, type View } from "./gpu/renderer";
import { ResidentMaps } from "./gpu/resident-maps";
import { blendWeights, nearestSample, samplesByDistance } from "./parameter-space";
import { type Pem, sceneBounds } from "./pem";
import type { Settings } from "./settings";
import { ViewLimits } from "./view-limits";

const MOST_PIXELS = 3 * 2 ** 20; // of the picture: bounds its textures to some 320 MB
const COARSEST = 4; // pixels of the screen along the edge of one drawn in motion
const SLOW_MS = 50; // a frame in motion that takes longer makes the next one coarser
const FAST_MS = 12; // four times as many pixels will not be slow
const REST_MS = 120; // without change, before the picture is refined
const SMOOTHED_FRAMES = 8; // in the frame time that is shown
const MULTISAMPLES = 4;

/** The picture as numbers, for tests and figures. */
export interface RawFrame {
  width: number;
  height: number;
  /** Linear radiance and coverage, four floats a pixel, row by row from the top. */
  radiance: Float32Array;
}

export interface Listener {
  /** A first picture is on the screen. */
  shown(): void;
  status(text: string): void;
  failed(message: string): void;
}

export class Playback {
  /** Width at the right side of the canvas that something else covers, in the page's pixels: no map is laid there. */
  covered = 0;
  private point: ViewPoint;
  private changed = false;
  private lastChange = 0;
  private samplesAtRest = 0; // of the picture being refined
  private refining = false;
  private awake = false;
  private coarseness = COARSEST;
  private frameMs = 0;
  private frameSize = "";
  private readonly limits: ViewLimits;
  private readonly maps: ResidentMaps;
  private renderer!: Renderer;

  private constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly context: GPUCanvasContext,
    private readonly device: GPUDevice,
    private readonly pem: Pem,
    private readonly settings: Settings,
    private readonly listener: Listener,
  ) {
    this.point = pointOf(pem.orbit);
    this.limits = new ViewLimits(pem);
    this.maps = new ResidentMaps(
      device,
      pem,
      (sample) => this.arrived(sample),
      (message) => listener.failed(message),
    );
  }

  /** Ready to draw; nothing is drawn before `invalidate`. */
  static async create(
    canvas: HTMLCanvasElement,
    device: GPUDevice,
    pem: Pem,
    settings: Settings,
    listener: Listener,
  ): Promise<Playback> {
    const context = canvas.getContext("webgpu") as GPUCanvasContext;
    const format = navigator.gpu.getPreferredCanvasFormat();
    context.configure({ device, format, alphaMode: "opaque" });
    const playback = new Playback(canvas, context, device, pem, settings, listener);
    playback.renderer = await Renderer.create(device, pem, playback.maps, format);
    return playback;
  }

  get viewpoint(): ViewPoint {
    return { ...this.point };
  }

  set viewpoint(point: Partial<ViewPoint>) {
    this.point = this.limits.clamp({ ...this.point, ...point });
    this.invalidate();
  }

  /** Back to the orbit's own point. */
  home(): void {
    this.point = pointOf(this.pem.orbit);
    this.invalidate();
  }

  /** Takes over changed settings. */
  configure(): void {
    const { geometry, growth } = this.settings;
    const bounds = sceneBounds(this.pem);
    this.renderer.scene.setDistantGeometries(
      this.pem.layers.map((layer) => {
        const kind = geometry === "baked" ? layer.geometry.kind : geometry;
        return asKind(layer.geometry, kind, growth, bounds);
      }),
    );
    this.invalidate();
  }

  /** Something changed: draws soon. */
  invalidate(): void {
    this.changed = true;
    this.lastChange = performance.now();
    this.wake();
  }

  /** Whether all maps of the present view are here. */
  get complete(): boolean {
    return [...this.wanted().keys()].every((sample) => this.maps.has(sample));
  }

  /** Whether the screen shows the right maps with all sub-samples. */
  get settled(): boolean {
    return this.complete && !this.changed && !this.refining;
  }

  /** Draws the present view at another size: `samples` a pixel one by one, or four in one pass. */
  async rawFrame(width: number, height: number, samples: number | "multisampled"): Promise<RawFrame> {
    const view = this.view(width, height);
    if (samples === "multisampled") this.renderer.drawMultisampled(view);
    else for (let k = 0; k < samples; k++) this.renderer.drawNextSample(view, samples, k === 0);
    const reading = this.renderer.read();
    this.invalidate(); // the sum of the picture on the screen is gone
    return { width, height, radiance: await reading };
  }

  private wake(): void {
    if (this.awake) return;
    this.awake = true;
    requestAnimationFrame(() => void this.frame());
  }

  private async frame(): Promise<void> {
    const start = performance.now();
    const { changed } = this;
    if (changed) {
      this.changed = false;
      this.samplesAtRest = 0;
      this.refining = this.drawMoving();
    } else if (this.refining && start - this.lastChange >= REST_MS) {
      this.refine();
    }
    await this.device.queue.onSubmittedWorkDone(); // never more than one frame ahead: input is answered at once
    if (changed) this.measure(performance.now() - start);
    this.listener.status(this.status());
    this.awake = false;
    if (this.changed || this.refining) this.wake();
  }

  /** Draws four sub-samples a pixel at once. Returns whether the picture has to be refined. */
  private drawMoving(): boolean {
    this.maps.wish(samplesByDistance(this.pem.axes, { ...this.point }));
    const full = this.fullSize();
    if (this.settings.view === "maps") {
      const [nearest] = this.maps.shown(new Map([[nearestSample(this.wanted()), 1]]), this.byDistance());
      if (nearest === undefined) return false;
      const screen = this.screen(full.width, full.height);
      const free = Math.max(1 - this.covered / this.canvas.clientWidth, 0.2) * full.width;
      this.renderer.displayMap(screen, this.settings, this.settings.layer, nearest.slot, free, full.height);
      this.listener.shown();
      return false;
    }
    const width = Math.ceil(full.width / this.coarseness);
    const height = Math.ceil(full.height / this.coarseness);
    const view = this.view(width, height);
    if (view.blend.length === 0) return false; // nothing has arrived yet
    this.renderer.drawMultisampled(view);
    this.renderer.display(this.screen(width, height), this.settings);
    this.listener.shown();
    return true;
  }

  /** Adds one sub-sample of the pattern; shown as soon as there are as many as in motion. */
  private refine(): void {
    const { width, height } = this.fullSize();
    const { sampleCount } = this.pem;
    this.renderer.drawNextSample(this.view(width, height), sampleCount, this.samplesAtRest === 0);
    this.samplesAtRest += 1;
    if (this.samplesAtRest >= Math.min(MULTISAMPLES, sampleCount)) {
      this.renderer.display(this.screen(width, height), this.settings);
    }
    this.refining = this.samplesAtRest < sampleCount;
  }

  /** The canvas at a number of pixels; the page stretches it over its place. */
  private screen(width: number, height: number): GPUTextureView {
    if (this.samplesAtRest === 0) this.frameSize = `${width} × ${height}`;
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    return this.context.getCurrentTexture().createView();
  }

  private fullSize(): { width: number; height: number } {
    const { clientWidth, clientHeight } = this.canvas;
    const pixels = clientWidth * clientHeight * devicePixelRatio ** 2;
    const ratio = devicePixelRatio * Math.min(1, Math.sqrt(MOST_PIXELS / Math.max(pixels, 1)));
    return {
      width: Math.max(Math.round(clientWidth * ratio), 1),
      height: Math.max(Math.round(clientHeight * ratio), 1),
    };
  }

  private measure(ms: number): void {
    this.frameMs += (ms - this.frameMs) / (this.frameMs === 0 ? 1 : SMOOTHED_FRAMES);
    if (ms > SLOW_MS) this.coarseness = Math.min(2 * this.coarseness, COARSEST);
    else if (ms < FAST_MS) this.coarseness = Math.max(this.coarseness / 2, 1);
  }

  /** A map that came ahead of its time changes nothing yet. */
  private arrived(sample: number): void {
    if (this.wanted().has(sample) || !this.complete) this.invalidate();
    else this.listener.status(this.status());
  }

  private wanted(): Map<number, number> {
    const weights = blendWeights(this.pem.axes, { ...this.point });
    return this.settings.blend ? weights : new Map([[nearestSample(weights), 1]]);
  }

  private byDistance(): number[] {
    return samplesByDistance(this.pem.axes, { ...this.point });
  }

  private view(width: number, height: number): View {
    return {
      camera: cameraAt(this.pem.orbit, this.point, width, height),
      blend: this.maps.shown(this.wanted(), this.byDistance()),
      shown: this.settings.shown,
    };
  }

  private status(): string {
    const { azimuth_deg, elevation_deg, distance } = this.point;
    return [
      `Azimuth ${azimuth_deg.toFixed(1)}°, elevation ${elevation_deg.toFixed(1)}°`,
      `Distance ${distance.toFixed(2)} m`,
      `${this.maps.residentCount} of ${this.pem.maps.length} viewpoints here, ${Math.ceil(this.maps.bytes / 2 ** 20)} MB`,
      `${this.frameMs.toFixed(this.frameMs < 100 ? 1 : 0)} ms a frame of ${this.frameSize}`,
    ].join("\n");
  }
}
