// <reflet-viewer src="pem/scene.gltf">: shows a parameterized environment map.

import type { ViewPoint } from "./camera";
import { steer } from "./controls";
import { openDevice } from "./gpu/device";
import { Panel } from "./panel";
import { openPem } from "./pem";
import { Playback, type RawFrame } from "./playback";
import { defaultSettings, type Settings } from "./settings";
import css from "./viewer.css?inline";

const WIDE = 1000; // pixels of the page from which on the settings are open at first

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
  private readonly root: ShadowRoot;
  private readonly canvas: HTMLCanvasElement;
  private readonly notice: HTMLElement;
  private readonly toggle: HTMLButtonElement;
  private device: GPUDevice | undefined;
  private panel: Panel | undefined;
  private playback: Playback | undefined;
  private failure: Error | undefined;
  private opening = false;
  private gone = new AbortController();
  private resolveReady: () => void = () => {};
  private rejectReady: (reason: unknown) => void = () => {};

  constructor() {
    super();
    this.root = this.attachShadow({ mode: "open" });
    this.root.innerHTML = MARKUP;
    this.canvas = this.root.querySelector("canvas") as HTMLCanvasElement;
    this.notice = this.root.querySelector(".notice") as HTMLElement;
    this.toggle = this.root.querySelector(".toggle") as HTMLButtonElement;
    this.ready = new Promise((resolve, reject) => {
      this.resolveReady = resolve;
      this.rejectReady = reject;
    });
    this.ready.catch(() => {}); // the page says it; nobody has to listen
  }

  connectedCallback(): void {
    if (!this.opening) void this.open();
  }

  disconnectedCallback(): void {
    queueMicrotask(() => {
      if (!this.isConnected) this.close(); // and not only moved to another place in the page
    });
  }

  /** Where the camera stands. What is set may be a part of it; it is brought back to where the camera may go. */
  get viewpoint(): ViewPoint | undefined {
    return this.playback?.viewpoint;
  }

  set viewpoint(point: Partial<ViewPoint>) {
    if (this.playback) this.playback.viewpoint = point;
  }

  /** Changes some of the settings. */
  configure(settings: Partial<Settings>): void {
    Object.assign(this.settings, settings);
    this.panel?.show();
    this.playback?.configure();
  }

  /** Resolves when the picture shows the right maps and all its samples. */
  async settled(): Promise<void> {
    await this.until((playback) => playback.settled);
  }

  /** Draws the present view at another size and returns the numbers: `samples` a pixel, or four in one pass. */
  async rawFrame(width: number, height: number, samples: number | "multisampled"): Promise<RawFrame> {
    const playback = await this.until((that) => that.complete);
    return playback.rawFrame(width, height, samples);
  }

  private async until(condition: (playback: Playback) => boolean): Promise<Playback> {
    await this.ready;
    for (;;) {
      if (this.failure) throw this.failure;
      if (this.playback === undefined) throw new Error("The viewer was removed from the page.");
      if (condition(this.playback)) return this.playback;
      await new Promise(requestAnimationFrame);
    }
  }

  private async open(): Promise<void> {
    this.opening = true;
    try {
      const src = this.getAttribute("src");
      if (!src) throw new Error("A reflet-viewer needs the address of a scene.gltf in its src attribute.");
      const [device, pem] = await Promise.all([openDevice(), openPem(src)]);
      this.device = device;
      void device.lost.then((lost) => {
        if (lost.reason !== "destroyed") this.fail("The graphics device was lost; reload the page.");
      });
      this.playback = await Playback.create(this.canvas, device, pem, this.settings, {
        shown: () => {
          this.notice.hidden = this.failure === undefined;
        },
        status: (text) => {
          if (this.panel) this.panel.status = text;
        },
        failed: (message) => this.fail(message),
      });
      const { playback } = this;
      this.panel = new Panel(
        pem,
        this.settings,
        () => playback.configure(),
        () => playback.home(),
      );
      this.buildPage(playback, this.panel);
      this.resolveReady();
    } catch (error) {
      this.rejectReady(this.fail(error instanceof Error ? error.message : String(error)));
    }
  }

  private close(): void {
    this.gone.abort();
    this.gone = new AbortController();
    this.panel?.element.remove();
    this.device?.destroy();
    this.device = this.panel = this.playback = undefined;
    this.opening = false;
  }

  private buildPage(playback: Playback, panel: Panel): void {
    const { signal } = this.gone;
    const open = (opened: boolean) => {
      panel.element.hidden = !opened;
      playback.covered = opened ? this.clientWidth - panel.element.offsetLeft : 0;
      playback.invalidate();
      this.toggle.setAttribute("aria-expanded", String(opened));
    };
    this.root.append(panel.element);
    open(this.clientWidth >= WIDE);
    this.toggle.hidden = false;
    this.toggle.addEventListener("click", () => open(panel.element.hidden), { signal });
    const motion = {
      turn: (azimuth: number, elevation: number) => {
        const { azimuth_deg, elevation_deg } = playback.viewpoint;
        playback.viewpoint = { azimuth_deg: azimuth_deg + azimuth, elevation_deg: elevation_deg + elevation };
      },
      zoom: (factor: number) => {
        playback.viewpoint = { distance: playback.viewpoint.distance * factor };
      },
      home: () => playback.home(),
    };
    steer(this.canvas, motion, signal);
    const observer = new ResizeObserver(() => playback.invalidate());
    observer.observe(this.canvas);
    signal.addEventListener("abort", () => observer.disconnect());
  }

  private fail(message: string): Error {
    this.failure = new Error(message);
    this.notice.setAttribute("role", "alert");
    this.notice.textContent = message;
    this.notice.hidden = false;
    return this.failure;
  }
}
