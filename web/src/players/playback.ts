// Plays a PEM back: which maps are needed and blended, and how the settings change them.

import { sceneBounds } from "../files/gltf";
import type { PictureSum } from "../gpu/device/picture-sum";
import { Renderer } from "../gpu/playback/renderer";
import { ResidentMaps } from "../gpu/playback/resident-maps";
import type { View } from "../gpu/playback/view";
import type { Camera } from "../maths/camera";
import { asKind } from "../maths/geometry";
import { blendWeights, nearestAlone, samplesByDistance } from "../maths/parameter-space";
import { AT_REST, IN_MOTION, type Samples } from "../maths/sample-pattern";
import { Panel } from "../panels/panel";
import { defaultSettings, type Settings } from "../panels/settings";
import { baseShare, type Pem } from "../scene/pem";
import { type Listener, Player } from "./player";

export class Playback extends Player {
  readonly panel: Panel;
  protected readonly atRest = AT_REST;
  protected override readonly inMotion = IN_MOTION;
  protected readonly tone: Settings;
  readonly settings = defaultSettings();
  private maps!: ResidentMaps;
  private renderer!: Renderer;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly pem: Pem,
    listener: Listener,
  ) {
    super(canvas, pem, listener);
    this.tone = this.settings;
    this.panel = new Panel(
      pem,
      this.settings,
      () => this.apply(),
      () => this.home(),
    );
  }

  protected async prepare(device: GPUDevice, format: GPUTextureFormat): Promise<void> {
    this.maps = new ResidentMaps(
      device,
      this.pem,
      (sample) => this.arrived(sample),
      (message) => this.listener.failed(message),
    );
    this.renderer = await Renderer.create(device, this.pem, this.maps, format);
    this.apply();
  }

  override stop(): void {
    if (this.started) this.maps.stop();
    super.stop();
  }

  configure(settings: Partial<Settings>): void {
    Object.assign(this.settings, settings);
    this.panel.show();
    this.apply();
  }

  get complete(): boolean {
    return this.maps.hasBase && [...this.wanted().keys()].every((sample) => this.maps.has(sample));
  }

  protected get sum(): PictureSum {
    return this.renderer.sum;
  }

  /** Takes over changed settings. */
  private apply(): void {
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

  protected override drawMoving(): boolean {
    this.maps.wish(this.byDistance());
    if (this.settings.view !== "maps") return super.drawMoving();
    const slot = this.mapSlot();
    if (slot === undefined) return false;
    const { width, height } = this.fullSize();
    const free = Math.max(1 - this.covered / this.canvas.clientWidth, 0.2) * width;
    const screen = this.screen(width, height);
    const { layer, mapShows } = this.settings;
    this.renderer.displayMap(screen, this.settings, layer, slot, mapShows, free, height);
    this.listener.shown();
    return false;
  }

  /** Something has arrived. */
  protected get drawable(): boolean {
    const { blend, base } = this.lit();
    return blend.length > 0 || base.weight > 0;
  }

  protected drawMultisampled(camera: Camera): void {
    this.renderer.drawMultisampled(this.view(camera));
  }

  protected drawNextSample(camera: Camera, samples: Samples, first: boolean): void {
    this.renderer.drawNextSample(this.view(camera), samples, first, this.tone);
  }

  protected facts(): string[] {
    const megabytes = Math.ceil(this.maps.bytes / 2 ** 20);
    if (this.pem.maps.length === 0) return [`Maps for all viewpoints, ${megabytes} MB`];
    const { length } = this.pem.base;
    return [
      `${this.maps.residentCount} of ${this.pem.maps.length} viewpoints here, ${megabytes} MB`,
      ...(length > 0 ? [`${Math.round(100 * this.share)} % from the maps for all viewpoints`] : []),
    ];
  }

  /** A map that came ahead of its time changes nothing yet. */
  private arrived(sample: number | undefined): void {
    if (sample === undefined || this.wanted().has(sample) || !this.complete) this.invalidate();
    else this.tellStatus();
  }

  /** Where the base is all that is shown, no sample is. */
  private wanted(): Map<number, number> {
    const local = this.settings.shown.local && !this.pem.traced && this.pem.layers.some(({ kind }) => kind === "local");
    if (this.share === 1 && !local) return new Map();
    const weights = this.weights();
    return this.settings.blend ? weights : nearestAlone(weights);
  }

  private weights(): Map<number, number> {
    return blendWeights(this.pem.axes, { ...this.point });
  }

  /** The base's share of the distant light. */
  private get share(): number {
    return baseShare(this.pem, this.point);
  }

  /** The slot of the map that is laid flat, if it is here: the nearest that is, or the base. */
  private mapSlot(): number | undefined {
    const { layer, mapOf } = this.settings;
    const ofBase = this.pem.base.length > 0 && this.pem.layers[layer]?.kind === "distant";
    if (ofBase && (mapOf === "base" || this.pem.maps.length === 0)) {
      return this.maps.hasBase ? this.maps.base(1).slot : undefined;
    }
    return this.maps.shown(nearestAlone(this.weights()), this.byDistance())[0]?.slot;
  }

  private byDistance(): number[] {
    return samplesByDistance(this.pem.axes, { ...this.point });
  }

  private view(camera: Camera): View {
    const { shown, hiddenShells, byOrigin } = this.settings;
    return { camera, ...this.lit(), shown, hiddenShells, byOrigin };
  }

  private lit(): Pick<View, "blend" | "base"> {
    // Until the samples are here the base stands for them, alone.
    const away = this.pem.base.length > 0 && this.maps.hasBase ? 1 : 0;
    const base = this.maps.base(this.complete ? this.share : away);
    return { blend: this.maps.shown(this.wanted(), this.byDistance()), base };
  }
}
