// <reflet-viewer src="scene/scene.gltf">: shows a parameterized environment map, or a mesh of some material in an environment.

import type { ViewPoint } from "../maths/camera";
import { setMarkup } from "../panels/markup";
import type { Settings } from "../panels/settings";
import type { ShadingSettings } from "../panels/shading-settings";
import type { Listener, Player, RawFrame, RawSamples } from "../players/player";
import { steer } from "./controls";
import { Hint } from "./hint";
import { followPixelSize } from "./pixel-size";
import { play } from "./session";
import css from "./viewer.css?inline";

const WIDE = 1000; // pixels of the page from which on the settings are open at first

const MARKUP = `
  <canvas tabindex="0" role="application"></canvas>
  <p class="notice" role="status"></p>
  <p class="hint" aria-hidden="true"></p>
  <button class="toggle" type="button" aria-expanded="false" aria-label="Settings" hidden>
    <svg viewBox="0 0 18 18" aria-hidden="true"><path d="M2 5h8m4 0h2M2 13h2m4 0h8" /><circle cx="12" cy="5" r="2" /><circle cx="6" cy="13" r="2" /></svg>
  </button>`;
const LABEL = "Rendered view. Arrow keys turn it, plus and minus zoom, Home returns.";
const LABEL_OF_LIGHT = " Square brackets turn the light, L switches a lamp, comma and full stop move it.";

// A sheet made by script, not a style element: pages that forbid those inside themselves (CSP) allow it.
const SHEET = new CSSStyleSheet();
SHEET.replaceSync(css);

/** A promise, and what settles it. */
interface Opening {
  readonly promise: Promise<void>;
  resolve(): void;
  reject(reason: unknown): void;
  settled: boolean;
}

export class RefletViewer extends HTMLElement {
  static readonly observedAttributes = ["src", "gestures"];
  private readonly root: ShadowRoot;
  private readonly canvas: HTMLCanvasElement;
  private readonly notice: HTMLElement;
  private readonly toggle: HTMLButtonElement;
  private readonly hint: Hint;
  private opening = newOpening();
  private gone: AbortController | undefined; // of the scene that is open, or failed to
  private player: Player | undefined;
  private failure: Error | undefined;
  /** What is left of a scene when the element leaves the page, for its return. */
  private left: { src: string | null; viewpoint: ViewPoint; settings: Settings | ShadingSettings } | undefined;

  constructor() {
    super();
    this.root = this.attachShadow({ mode: "open" });
    this.root.adoptedStyleSheets = [SHEET];
    setMarkup(this.root, MARKUP);
    this.canvas = this.root.querySelector("canvas") as HTMLCanvasElement;
    this.notice = this.root.querySelector(".notice") as HTMLElement;
    this.toggle = this.root.querySelector(".toggle") as HTMLButtonElement;
    this.hint = new Hint(this.root.querySelector(".hint") as HTMLElement);
  }

  connectedCallback(): void {
    if (this.gone === undefined) void this.open();
  }

  disconnectedCallback(): void {
    queueMicrotask(() => {
      if (this.isConnected) return; // only moved to another place in the page
      if (this.player) {
        const { viewpoint, settings } = this.player;
        this.left = { src: this.getAttribute("src"), viewpoint, settings: structuredClone(settings) };
      }
      this.close();
    });
  }

  attributeChangedCallback(name: string, before: string | null, value: string | null): void {
    this.canvas.classList.toggle("captured", this.captured);
    if (name === "src" && before !== value && this.gone) {
      this.left = undefined;
      this.close();
      void this.open();
    }
  }

  /** Resolves when the scene that `src` names now is open; rejects with one sentence, which the page shows too. */
  get ready(): Promise<void> {
    return this.opening.promise;
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

  /** Draws the present view at another size and returns the numbers: `samples` a pixel, where they count, or four in one pass. */
  async rawFrame(width: number, height: number, samples: RawSamples): Promise<RawFrame> {
    const player = await this.until((that) => that.complete);
    return player.rawFrame(width, height, samples);
  }

  private async until(condition: (player: Player) => boolean): Promise<Player> {
    for (;;) {
      await this.ready;
      if (this.failure) throw this.failure;
      if (this.player === undefined) throw new Error("The viewer was removed from the page.");
      if (this.player.started && condition(this.player)) return this.player;
      await new Promise(requestAnimationFrame);
    }
  }

  private async open(): Promise<void> {
    const gone = new AbortController();
    this.gone = gone;
    if (this.opening.settled) this.opening = newOpening();
    this.failure = undefined;
    this.say("status", "Opening…");
    const listener: Listener = {
      shown: () => {
        this.notice.hidden = this.failure === undefined;
      },
      status: (text) => {
        if (this.player) this.player.panel.status = text;
      },
      failed: (message) => {
        if (!gone.signal.aborted) this.fail(message);
      },
    };
    try {
      const src = this.getAttribute("src");
      if (!src) throw new Error("A reflet-viewer needs the address of a scene.gltf in its src attribute.");
      const player = await play(this.canvas, src, listener, gone.signal);
      if (gone.signal.aborted) return;
      this.player = player;
      this.buildPage(player, gone.signal);
      if (this.left?.src === src) {
        player.configure(this.left.settings);
        player.viewpoint = this.left.viewpoint;
      }
      this.left = undefined;
      this.opening.resolve();
    } catch (error) {
      if (gone.signal.aborted) return;
      gone.abort();
      this.opening.reject(this.fail(error instanceof Error ? error.message : String(error)));
    }
  }

  private close(): void {
    this.gone?.abort();
    this.player?.panel.element.remove();
    this.toggle.hidden = true;
    this.gone = this.player = undefined;
  }

  private buildPage(player: Player, signal: AbortSignal): void {
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
    this.canvas.ariaLabel = "material" in player.settings ? LABEL + LABEL_OF_LIGHT : LABEL;
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
    const viewer = this;
    const page = {
      get captured() {
        return viewer.captured;
      },
      get focused() {
        return viewer.root.activeElement !== null;
      },
      passed: (by: "wheel" | "finger") => this.hint.show(by),
    };
    steer(this.canvas, motion, page, signal);
    followPixelSize(this.canvas, (width, height) => player.resize(width, height), signal);
  }

  /** In a frame of another page that page may have to be scrolled, whatever ours is made for. */
  private get captured(): boolean {
    return this.getAttribute("gestures") === "capture" && window.parent === window;
  }

  private say(role: "status" | "alert", text: string): void {
    this.notice.setAttribute("role", role);
    this.notice.textContent = text;
    this.notice.hidden = false;
  }

  private fail(message: string): Error {
    this.failure = new Error(message);
    this.say("alert", message);
    return this.failure;
  }
}

function newOpening(): Opening {
  let settle: Pick<Opening, "resolve" | "reject">;
  const promise = new Promise<void>((resolve, reject) => {
    settle = { resolve, reject };
  });
  promise.catch(() => {}); // the page says it; nobody has to listen
  const opening: Opening = {
    promise,
    settled: false,
    resolve: () => {
      opening.settled = true;
      settle.resolve();
    },
    reject: (reason) => {
      opening.settled = true;
      settle.reject(reason);
    },
  };
  return opening;
}
