// <reflet-viewer src="scene/scene.gltf">: shows a parameterized environment map, or a mesh of some material in an environment.

import { openSceneFile } from "../files/gltf";
import { openDevice } from "../gpu/device/device";
import type { ViewPoint } from "../maths/camera";
import type { Settings } from "../panels/settings";
import type { ShadingSettings } from "../panels/shading-settings";
import { Playback } from "../players/playback";
import type { Listener, Player, RawFrame } from "../players/player";
import { Shading } from "../players/shading";
import { readPem } from "../scene/pem";
import { readShadedScene } from "../scene/shaded-scene";
import { steer } from "./controls";
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
  private readonly root: ShadowRoot;
  private readonly canvas: HTMLCanvasElement;
  private readonly notice: HTMLElement;
  private readonly toggle: HTMLButtonElement;
  private device: GPUDevice | undefined;
  private player: Player | undefined;
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
    return this.player?.viewpoint;
  }

  set viewpoint(point: Partial<ViewPoint>) {
    if (this.player) this.player.viewpoint = point;
  }

  /** All settings, as `configure` takes them. */
  get settings(): Settings | ShadingSettings | undefined {
    return this.player && structuredClone(this.player.settings);
  }

  /** Changes some of the settings. */
  configure(settings: Partial<Settings> | Partial<ShadingSettings>): void {
    this.player?.configure(settings);
  }

  /** Resolves when the picture shows the right maps and all its samples. */
  async settled(): Promise<void> {
    await this.until((player) => player.settled);
  }

  /** Draws the present view at another size and returns the numbers: `samples` a pixel, or four in one pass. */
  async rawFrame(width: number, height: number, samples: number | "multisampled"): Promise<RawFrame> {
    const player = await this.until((that) => that.complete);
    return player.rawFrame(width, height, samples);
  }

  private async until(condition: (player: Player) => boolean): Promise<Player> {
    await this.ready;
    for (;;) {
      if (this.failure) throw this.failure;
      if (this.player === undefined) throw new Error("The viewer was removed from the page.");
      if (condition(this.player)) return this.player;
      await new Promise(requestAnimationFrame);
    }
  }

  private async open(): Promise<void> {
    this.opening = true;
    try {
      const src = this.getAttribute("src");
      if (!src) throw new Error("A reflet-viewer needs the address of a scene.gltf in its src attribute.");
      const [device, scene] = await Promise.all([openDevice(), openSceneFile(src)]);
      this.device = device;
      void device.lost.then((lost) => {
        if (lost.reason !== "destroyed") this.fail("The graphics device was lost; reload the page.");
      });
      const listener: Listener = {
        shown: () => {
          this.notice.hidden = this.failure === undefined;
        },
        status: (text) => {
          if (this.player) this.player.panel.status = text;
        },
        failed: (message) => this.fail(message),
      };
      const [pem, shaded] = await Promise.all([readPem(scene), readShadedScene(scene)]);
      if (pem) this.player = await Playback.create(this.canvas, device, pem, listener);
      else if (shaded) {
        this.player = await Shading.create(this.canvas, device, shaded, listener);
        this.canvas.ariaLabel += " Square brackets turn the light, L switches a lamp, comma and full stop move it.";
      } else throw new Error(`${src} is a plain glTF file, with nothing in it that this viewer knows to show.`);
      this.buildPage(this.player);
      this.resolveReady();
    } catch (error) {
      this.rejectReady(this.fail(error instanceof Error ? error.message : String(error)));
    }
  }

  private close(): void {
    this.gone.abort();
    this.gone = new AbortController();
    this.player?.panel.element.remove();
    this.device?.destroy();
    this.device = this.player = undefined;
    this.opening = false;
  }

  private buildPage(player: Player): void {
    const { signal } = this.gone;
    const { panel } = player;
    const open = (opened: boolean) => {
      panel.element.hidden = !opened;
      player.covered = opened ? this.clientWidth - panel.element.offsetLeft : 0;
      player.invalidate();
      this.toggle.setAttribute("aria-expanded", String(opened));
    };
    this.root.append(panel.element);
    open(this.clientWidth >= WIDE);
    this.toggle.hidden = false;
    this.toggle.addEventListener("click", () => open(panel.element.hidden), { signal });
    const motion = {
      turn: (azimuth: number, elevation: number) => {
        const { azimuth_deg, elevation_deg } = player.viewpoint;
        player.viewpoint = { azimuth_deg: azimuth_deg + azimuth, elevation_deg: elevation_deg + elevation };
      },
      zoom: (factor: number) => {
        player.viewpoint = { distance: player.viewpoint.distance * factor };
      },
      home: () => player.home(),
      shiftDrag: (degrees: number) => player.shiftDrag(degrees),
      toggleLamp: () => player.toggleLamp(),
      moveLamp: (degrees: number) => player.moveLamp(degrees),
    };
    steer(this.canvas, motion, signal);
    const observer = new ResizeObserver(() => player.invalidate());
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
