// <reflet-viewer src="pem/scene.gltf">: shows a parameterized environment map.

import { cameraAt, pointOf, type ViewPoint } from "./camera";
import { steer } from "./controls";
import { asKind } from "./geometry";
import { openDevice } from "./gpu/device";
import { Renderer, type View } from "./gpu/renderer";
import { ResidentMaps } from "./gpu/resident-maps";
import { Panel } from "./panel";
import { blendWeights, nearestSample, samplesByDistance } from "./parameter-space";
import { openPem, type Pem, sceneBounds } from "./pem";
import { defaultSettings, type Settings } from "./settings";
import { ViewLimits } from "./view-limits";
import css from "./viewer.css?inline";

const MOST_PIXELS = 3 * 2 ** 20; // of the picture: bounds its textures to some 320 MB
const REST_MS = 120; // without change, before the picture is refined
const SMOOTHED_FRAMES = 12; // in the frame time that is shown

/** The picture as numbers, for tests and figures. */
export interface RawFrame {
  width: number;
  height: number;
  /** Linear radiance and coverage, four floats a pixel, row by row from the top. */
  radiance: Float32Array;
}

interface Opened {
  readonly pem: Pem;
  readonly device: GPUDevice;
  readonly maps: ResidentMaps;
  readonly renderer: Renderer;
  readonly limits: ViewLimits;
  readonly panel: Panel;
  readonly context: GPUCanvasContext;
}

const MARKUP = `
  <style>${css}</style>
  <canvas tabindex="0" role="application" aria-label="Rendered view. Arrow keys turn it, plus and minus zoom, Home returns."></canvas>
  <p class="notice" role="status">Opening…</p>
  <button class="toggle" type="button" aria-expanded="false" aria-label="Settings" hidden>
    <svg viewBox="0 0 18 18" aria-hidden="true"><path d="M2 5h8m4 0h2M2 13h2m4 0h8" /><circle cx="12" cy="5" r="2" /><circle cx="6" cy="13" r="2" /></svg>
  </button>`;

export class RefletViewer extends HTMLElement {
  /** Resolves when the scene is open; rejects with one sentence, which the page shows too. */
  readonly ready: Promise<void>;
  private readonly settings = defaultSettings();
  private readonly canvas: HTMLCanvasElement;
  private readonly notice: HTMLElement;
  private readonly toggle: HTMLButtonElement;
  private point: ViewPoint = { azimuth_deg: 0, elevation_deg: 0, distance: 1 };
  private opened: Opened | undefined;
  private changed = true;
  private refining = false;
  private refined = 0; // sub-samples of the picture at rest
  private awake = false;
  private lastChange = 0;
  private frameMs = 0;
  private whenSettled: (() => void)[] = [];
  private readonly gone = new AbortController();
  private resolveReady: () => void = () => {};
  private rejectReady: (reason: unknown) => void = () => {};

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    root.innerHTML = MARKUP;
    this.canvas = root.querySelector("canvas") as HTMLCanvasElement;
    this.notice = root.querySelector(".notice") as HTMLElement;
    this.toggle = root.querySelector(".toggle") as HTMLButtonElement;
    this.ready = new Promise((resolve, reject) => {
      this.resolveReady = resolve;
      this.rejectReady = reject;
    });
    this.ready.catch(() => {}); // the page says it; nobody has to listen
  }

  connectedCallback(): void {
    if (this.opened === undefined) void this.open();
  }

  disconnectedCallback(): void {
    this.gone.abort();
    this.opened?.device.destroy();
  }

  /** Where the camera stands; values out of bounds are brought back. */
  get viewpoint(): ViewPoint {
    return { ...this.point };
  }

  set viewpoint(point: Partial<ViewPoint>) {
    const wanted = { ...this.point, ...point };
    this.point = this.opened?.limits.clamp(wanted) ?? wanted;
    this.invalidate();
  }

  /** Changes some of the settings. */
  configure(settings: Partial<Settings>): void {
    Object.assign(this.settings, settings);
    this.opened?.panel.show();
    this.applySettings();
  }

  /** Resolves when the picture shows the right maps and all its samples. */
  async settled(): Promise<void> {
    await this.ready;
    if (!this.changed && !this.refining && this.isComplete()) return;
    await new Promise<void>((resolve) => this.whenSettled.push(resolve));
  }

  /** Draws the present view at another size and returns the numbers: `samples` a pixel, or four in one pass. */
  async rawFrame(width: number, height: number, samples: number | "multisampled"): Promise<RawFrame> {
    await this.settled();
    const { renderer } = this.opened as Opened;
    const view = this.view(width, height);
    if (samples === "multisampled") renderer.drawMultisampled(view);
    else for (let k = 0; k < samples; k++) renderer.drawNextSample(view, samples, k === 0);
    const reading = renderer.read();
    this.invalidate();
    return { width, height, radiance: await reading };
  }

  private async open(): Promise<void> {
    try {
      const src = this.getAttribute("src");
      if (!src) throw new Error("A reflet-viewer needs the address of a scene.gltf in its src attribute.");
      const [device, pem] = await Promise.all([openDevice(), openPem(src)]);
      const maps = new ResidentMaps(
        device,
        pem,
        () => this.invalidate(),
        (message) => this.fail(message),
      );
      const context = this.canvas.getContext("webgpu") as GPUCanvasContext;
      const format = navigator.gpu.getPreferredCanvasFormat();
      context.configure({ device, format, alphaMode: "opaque" });
      const renderer = await Renderer.create(device, pem, maps, format);
      const limits = new ViewLimits(pem);
      const panel = new Panel(
        pem,
        this.settings,
        () => this.applySettings(),
        () => this.home(),
      );
      this.opened = { pem, device, maps, renderer, limits, panel, context };
      void device.lost.then((lost) => {
        if (lost.reason !== "destroyed") this.fail("The graphics device was lost; reload the page.");
      });
      this.buildPage(panel);
      this.home();
      this.resolveReady();
    } catch (error) {
      this.fail(error instanceof Error ? error.message : String(error));
      this.rejectReady(error);
    }
  }

  private buildPage(panel: Panel): void {
    const wide = this.clientWidth >= 720;
    panel.element.hidden = !wide;
    this.toggle.hidden = false;
    this.toggle.setAttribute("aria-expanded", String(wide));
    this.toggle.addEventListener("click", () => {
      panel.element.hidden = !panel.element.hidden;
      this.toggle.setAttribute("aria-expanded", String(!panel.element.hidden));
    });
    this.shadowRoot?.append(panel.element);
    const motion = {
      turn: (azimuth: number, elevation: number) => {
        const { azimuth_deg, elevation_deg } = this.point;
        this.viewpoint = { azimuth_deg: azimuth_deg + azimuth, elevation_deg: elevation_deg + elevation };
      },
      zoom: (factor: number) => {
        this.viewpoint = { distance: this.point.distance * factor };
      },
      home: () => this.home(),
    };
    steer(this.canvas, motion, this.gone.signal);
    const observer = new ResizeObserver(() => this.resize());
    observer.observe(this.canvas);
    this.gone.signal.addEventListener("abort", () => observer.disconnect());
    this.resize();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    const pixels = clientWidth * clientHeight * devicePixelRatio ** 2;
    const ratio = devicePixelRatio * Math.min(1, Math.sqrt(MOST_PIXELS / Math.max(pixels, 1)));
    const width = Math.max(Math.round(clientWidth * ratio), 1);
    const height = Math.max(Math.round(clientHeight * ratio), 1);
    if (this.canvas.width === width && this.canvas.height === height) return;
    this.canvas.width = width;
    this.canvas.height = height;
    this.invalidate();
  }

  private home(): void {
    const { pem } = this.opened as Opened;
    this.point = pointOf(pem.orbit);
    this.invalidate();
  }

  private applySettings(): void {
    if (this.opened === undefined) return;
    const { pem, renderer } = this.opened;
    const { geometry, growth } = this.settings;
    const bounds = sceneBounds(pem);
    renderer.scene.setDistantGeometries(
      pem.layers.map((layer) => {
        const kind = geometry === "baked" ? layer.geometry.kind : geometry;
        return asKind(layer.geometry, kind, growth, bounds);
      }),
    );
    this.invalidate();
  }

  private fail(message: string): void {
    this.notice.setAttribute("role", "alert");
    this.notice.textContent = message;
    this.notice.hidden = false;
  }

  // --- drawing: only when something changed, then until the picture is refined -----------------------------------

  private invalidate(): void {
    this.changed = true;
    this.lastChange = performance.now();
    this.wake();
  }

  private wake(): void {
    if (this.awake || this.opened === undefined) return;
    this.awake = true;
    requestAnimationFrame(() => void this.frame());
  }

  private async frame(): Promise<void> {
    const { device, renderer } = this.opened as Opened;
    const start = performance.now();
    const { changed } = this;
    if (changed) {
      this.changed = false;
      this.refined = 0;
      this.refining = this.drawMoving() && this.settings.view === "picture";
    } else if (this.refining && start - this.lastChange >= REST_MS) {
      this.refine(renderer);
    }
    await device.queue.onSubmittedWorkDone();
    if (changed) {
      const ms = performance.now() - start;
      this.frameMs += (ms - this.frameMs) / (this.frameMs === 0 ? 1 : SMOOTHED_FRAMES);
    }
    this.showStatus();
    this.awake = false;
    if (this.changed || this.refining) this.wake();
    else if (this.isComplete()) for (const resolve of this.whenSettled.splice(0)) resolve();
  }

  /** Draws four samples a pixel at once; false where no map has arrived yet. */
  private drawMoving(): boolean {
    const { context, maps, pem, renderer } = this.opened as Opened;
    maps.wish(samplesByDistance(pem.axes, { ...this.point }));
    const { width, height } = this.canvas;
    const view = this.view(width, height);
    const slot = [...view.blend].reduce((best, next) => (next[1] > best[1] ? next : best), [-1, 0])[0];
    if (slot < 0) return false;
    const screen = context.getCurrentTexture().createView();
    if (this.settings.view === "maps") {
      renderer.displayMap(screen, this.settings, this.settings.layer, slot, width, height);
    } else {
      renderer.drawMultisampled(view);
      renderer.display(screen, this.settings);
    }
    this.notice.hidden = this.notice.getAttribute("role") !== "alert";
    return true;
  }

  /** Adds the sub-samples of the pattern one by one; shown from the fourth on, since four were shown before. */
  private refine(renderer: Renderer): void {
    const { context, pem } = this.opened as Opened;
    const { width, height } = this.canvas;
    const first = this.refined === 0;
    renderer.drawNextSample(this.view(width, height), pem.sampleCount, first);
    this.refined = renderer.pictureCount;
    if (this.refined >= Math.min(4, pem.sampleCount)) {
      renderer.display(context.getCurrentTexture().createView(), this.settings);
    }
    if (this.refined === pem.sampleCount) this.refining = false;
  }

  private wanted(): Map<number, number> {
    const weights = blendWeights((this.opened as Opened).pem.axes, { ...this.point });
    return this.settings.blend ? weights : new Map([[nearestSample(weights), 1]]);
  }

  private isComplete(): boolean {
    const { maps } = this.opened as Opened;
    return [...this.wanted().keys()].every((sample) => maps.has(sample));
  }

  private view(width: number, height: number): View {
    const { maps, pem } = this.opened as Opened;
    return {
      camera: cameraAt(pem.orbit, this.point, width, height),
      blend: maps.shown(this.wanted(), samplesByDistance(pem.axes, { ...this.point })),
      shown: this.settings.shown,
    };
  }

  private showStatus(): void {
    const { maps, panel, pem } = this.opened as Opened;
    const { azimuth_deg, elevation_deg, distance } = this.point;
    panel.status = [
      `azimuth ${azimuth_deg.toFixed(1)}°, elevation ${elevation_deg.toFixed(1)}°, distance ${distance.toFixed(2)} m`,
      `${maps.residentCount} of ${pem.maps.length} viewpoints here, ${Math.round(maps.bytes / 2 ** 20)} MB of maps`,
      `${this.frameMs.toFixed(1)} ms a frame`,
    ].join("\n");
  }
}
