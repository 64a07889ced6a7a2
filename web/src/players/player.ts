// Draws on a canvas whenever something changes: at once, coarsely if need be; then, at rest, with all sub-samples.

import type { PictureSum } from "../gpu/device/picture-sum";
import { type Camera, cameraAt, type Orbit, pointOf, type ViewPoint } from "../maths/camera";
import { type Adaptive, AT_REST, IN_MOTION, mostSamples, type Samples } from "../maths/sample-pattern";
import type { Tone } from "../maths/tone";
import type { Form } from "../panels/form";
import type { Settings } from "../panels/settings";
import type { ShadingSettings } from "../panels/shading-settings";
import { type Surroundings, ViewLimits } from "../scene/view-limits";
import { FIRST_BURST, FIRST_PACE, nextBurst, nextPace, worthShowing } from "./pace";

const MOST_PIXELS = 3 * 2 ** 20; // of the picture: bounds its textures to some 330 MB
const REST_MS = 120; // without change, before the picture is refined
const SMOOTHED_FRAMES = 8; // in the frame time that is shown

/** The picture as numbers, for tests and figures. */
export interface RawFrame {
  width: number;
  height: number;
  /** Linear radiance and coverage, four floats a pixel, row by row from the top. */
  radiance: Float32Array;
}

export type RawSamples = number | "at rest" | "in motion" | "multisampled";

export interface Listener {
  /** A first picture is on the screen. */
  shown(): void;
  status(text: string): void;
  failed(message: string): void;
}

/** What players have in common: the camera, and when to draw. Settings and drawing are theirs. */
export abstract class Player {
  /** Width at the right side of the canvas that something else covers, in the page's pixels. */
  covered = 0;
  abstract readonly panel: Form;
  abstract readonly settings: Settings | ShadingSettings;
  protected point: ViewPoint;
  protected abstract readonly atRest: Samples;
  protected readonly inMotion: Adaptive | undefined; // where there is time for more than four at once
  protected abstract readonly sum: PictureSum;
  protected abstract readonly tone: Tone;
  private readonly orbit: Orbit;
  private readonly limits: ViewLimits;
  private changed = false;
  private lastChange = 0;
  private samplesAtRest = 0; // of the picture being refined
  private samplesShown = 0; // of these
  private burst = FIRST_BURST; // of these between two frames
  private refining = false;
  private awake = false;
  private pace = FIRST_PACE; // in motion
  private frameMs = 0;
  private frameSize = "";
  private device: GPUDevice | undefined; // while there is one
  private pixels = { width: 0, height: 0 }; // of the device, that the canvas covers

  protected constructor(
    protected readonly canvas: HTMLCanvasElement,
    scene: Surroundings,
    protected readonly listener: Listener,
  ) {
    this.orbit = scene.orbit;
    this.point = pointOf(scene.orbit);
    this.limits = new ViewLimits(scene);
  }

  /** Changes some of the settings. */
  abstract configure(settings: object): void;
  /** Whether all that the present view needs is here. */
  abstract get complete(): boolean;
  /** Makes what draws on a device into a canvas of this format. */
  protected abstract prepare(device: GPUDevice, format: GPUTextureFormat): Promise<void>;
  /** Whether there is anything to draw. */
  protected abstract get drawable(): boolean;
  /** Draws four samples a pixel at once. */
  protected abstract drawMultisampled(camera: Camera): void;
  protected abstract drawNextSample(camera: Camera, samples: Samples, first: boolean): void;
  /** The first lines of what the panel says. */
  protected abstract facts(): string[];

  /** Draws on this device from now on, what was drawn before on another; nothing is drawn before. */
  async start(device: GPUDevice): Promise<void> {
    const format = navigator.gpu.getPreferredCanvasFormat();
    await this.prepare(device, format);
    this.context.configure({ device, format, alphaMode: "opaque" });
    this.device = device;
    this.invalidate();
  }

  /** Draws no more, and leaves the canvas empty: the device is lost or no longer wanted. */
  stop(): void {
    this.device = undefined;
    this.context.unconfigure();
  }

  /** Whether it draws. */
  get started(): boolean {
    return this.device !== undefined;
  }

  /** The canvas covers so many pixels of the device now: none where it is hidden. */
  resize(width: number, height: number): void {
    this.pixels = { width, height };
    this.pace = { ...this.pace, more: undefined };
    this.invalidate();
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
    this.point = pointOf(this.orbit);
    this.invalidate();
  }

  /** A drag with shift held, in degrees. Returns whether that means anything here. */
  shiftDrag(_degrees: number): boolean {
    return false;
  }

  /** Switches a lamp, where there may be one. */
  toggleLamp(): void {}

  /** Moves it, in degrees of azimuth. */
  moveLamp(_degrees: number): void {}

  /** Something changed: draws soon. */
  invalidate(): void {
    this.changed = true;
    this.lastChange = performance.now();
    this.wake();
  }

  /** Whether the screen shows all that it should, with all sub-samples: nothing, while it is hidden. */
  get settled(): boolean {
    return this.complete && (this.hidden || (!this.changed && !this.refining));
  }

  /** Draws the present view at another size: `samples` a pixel one by one, where they count, or four in one pass. */
  async rawFrame(width: number, height: number, samples: RawSamples): Promise<RawFrame> {
    const camera = this.camera(width, height);
    if (samples === "multisampled") this.drawMultisampled(camera);
    else
      this.drawSamples(
        camera,
        typeof samples === "string" ? { "at rest": AT_REST, "in motion": IN_MOTION }[samples] : samples,
      );
    const { device } = this;
    const reading = this.sum.read().catch((error: unknown) => {
      throw device === this.device ? error : new Error("The graphics device was lost meanwhile; ask again.");
    });
    this.invalidate(); // the sum of the picture on the screen is gone
    return { width, height, radiance: await reading };
  }

  /** Draws at once what is in motion. Returns whether the picture has to be refined. */
  protected drawMoving(): boolean {
    const full = this.fullSize();
    const width = Math.ceil(full.width / this.pace.coarseness);
    const height = Math.ceil(full.height / this.pace.coarseness);
    if (!this.drawable) return false;
    const camera = this.shownCamera(width, height);
    if (this.inMotion && this.pace.more) this.drawSamples(camera, this.inMotion);
    else this.drawMultisampled(camera);
    this.sum.display(this.screen(width, height), this.tone);
    this.listener.shown();
    return true;
  }

  /** The canvas at a number of pixels; the page stretches it over its place. */
  protected screen(width: number, height: number): GPUTextureView {
    if (this.samplesAtRest === 0) this.frameSize = `${width} × ${height}`;
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    return this.context.getCurrentTexture().createView();
  }

  protected fullSize(): { width: number; height: number } {
    const { width, height } = this.pixels;
    const longest = this.device?.limits.maxTextureDimension2D ?? 1;
    const ratio = Math.min(1, Math.sqrt(MOST_PIXELS / (width * height)), longest / Math.max(width, height));
    return { width: Math.max(Math.floor(width * ratio), 1), height: Math.max(Math.floor(height * ratio), 1) };
  }

  private drawSamples(camera: Camera, samples: Samples): void {
    for (let k = 0; k < mostSamples(samples); k++) this.drawNextSample(camera, samples, k === 0);
  }

  private get hidden(): boolean {
    return this.pixels.width * this.pixels.height === 0;
  }

  private get context(): GPUCanvasContext {
    return this.canvas.getContext("webgpu") as GPUCanvasContext;
  }

  protected tellStatus(): void {
    const { azimuth_deg, elevation_deg, distance } = this.point;
    this.listener.status(
      [
        `Azimuth ${azimuth_deg.toFixed(1)}°, elevation ${elevation_deg.toFixed(1)}°`,
        `Distance ${distance.toFixed(2)} m`,
        ...this.facts(),
        `${this.frameMs.toFixed(this.frameMs < 100 ? 1 : 0)} ms a frame of ${this.frameSize}`,
      ].join("\n"),
    );
  }

  private camera(width: number, height: number): Camera {
    return cameraAt(this.orbit, this.point, width, height);
  }

  /** The camera of what is on the screen: the target stands in the middle of what nothing covers, if that is most of it. */
  private shownCamera(width: number, height: number): Camera {
    const share = this.covered / this.canvas.clientWidth;
    return { ...this.camera(width, height), shift: share < 0.5 ? (share * width) / 2 : 0 };
  }

  private wake(): void {
    if (this.awake) return;
    this.awake = true;
    requestAnimationFrame(() => void this.frame());
  }

  private async frame(): Promise<void> {
    const { device } = this;
    if (device && !this.hidden) await this.drawFrame(device).catch((error: unknown) => this.failed(device, error));
    this.awake = false;
    if (this.device && !this.hidden && (this.changed || this.refining)) this.wake();
  }

  private async drawFrame(device: GPUDevice): Promise<void> {
    const start = performance.now();
    const { changed } = this;
    const refines = !changed && this.refining && start - this.lastChange >= REST_MS;
    if (changed) {
      this.changed = false;
      this.samplesAtRest = 0;
      this.samplesShown = 0;
      this.burst = FIRST_BURST;
      this.refining = this.drawMoving();
    } else if (refines) {
      this.refine();
    }
    await device.queue.onSubmittedWorkDone(); // never more than one frame ahead: input is answered at once
    if (device !== this.device) return;
    const ms = performance.now() - start;
    if (changed) this.measure(ms);
    if (refines) this.burst = nextBurst(this.burst, ms);
    this.tellStatus();
  }

  /** What cannot be drawn is said, unless it is for want of a device. */
  private failed(device: GPUDevice, error: unknown): void {
    this.refining = false;
    if (device === this.device) this.listener.failed(error instanceof Error ? error.message : String(error));
  }

  /** Adds the next sub-samples of the pattern. */
  private refine(): void {
    const { width, height } = this.fullSize();
    const most = mostSamples(this.atRest);
    for (const end = Math.min(this.samplesAtRest + this.burst, most); this.samplesAtRest < end; ) {
      this.drawNextSample(this.shownCamera(width, height), this.atRest, this.samplesAtRest === 0);
      this.samplesAtRest += 1;
    }
    this.refining = this.samplesAtRest < most;
    if (!this.refining || worthShowing(this.samplesAtRest, this.samplesShown)) {
      this.sum.display(this.screen(width, height), this.tone);
      this.samplesShown = this.samplesAtRest;
    }
  }

  private measure(ms: number): void {
    this.frameMs += (ms - this.frameMs) / (this.frameMs === 0 ? 1 : SMOOTHED_FRAMES);
    this.pace = nextPace(this.pace, ms);
  }
}
