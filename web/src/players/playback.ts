// Plays a PEM back: which maps are needed and blended, and how the settings change them.

import { sceneBounds } from "../files/gltf";
import type { PictureSum } from "../gpu/device/picture-sum";
import { Renderer, type View } from "../gpu/playback/renderer";
import { ResidentMaps } from "../gpu/playback/resident-maps";
import type { Camera } from "../maths/camera";
import { asKind } from "../maths/geometry";
import { blendWeights, nearestSample, samplesByDistance } from "../maths/parameter-space";
import { Panel } from "../panels/panel";
import { defaultSettings, type Settings } from "../panels/settings";
import type { Pem } from "../scene/pem";
import { type Listener, Player } from "./player";

export class Playback extends Player {
  readonly panel: Panel;
  protected readonly sampleCount: number;
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
    this.sampleCount = pem.sampleCount;
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
    if (this.started) this.maps.wish([]);
    super.stop();
  }

  configure(settings: Partial<Settings>): void {
    Object.assign(this.settings, settings);
    this.panel.show();
    this.apply();
  }

  get complete(): boolean {
    return [...this.wanted().keys()].every((sample) => this.maps.has(sample));
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
    const [nearest] = this.maps.shown(new Map([[nearestSample(this.wanted()), 1]]), this.byDistance());
    if (nearest === undefined) return false;
    const { width, height } = this.fullSize();
    const free = Math.max(1 - this.covered / this.canvas.clientWidth, 0.2) * width;
    const screen = this.screen(width, height);
    this.renderer.displayMap(screen, this.settings, this.settings.layer, nearest.slot, free, height);
    this.listener.shown();
    return false;
  }

  protected drawMultisampled(camera: Camera): boolean {
    const view = this.view(camera);
    if (view.blend.length === 0) return false; // nothing has arrived yet
    this.renderer.drawMultisampled(view);
    return true;
  }

  protected drawNextSample(camera: Camera, sampleCount: number, first: boolean): void {
    this.renderer.drawNextSample(this.view(camera), sampleCount, first);
  }

  protected facts(): string[] {
    const megabytes = Math.ceil(this.maps.bytes / 2 ** 20);
    return [`${this.maps.residentCount} of ${this.pem.maps.length} viewpoints here, ${megabytes} MB`];
  }

  /** A map that came ahead of its time changes nothing yet. */
  private arrived(sample: number): void {
    if (this.wanted().has(sample) || !this.complete) this.invalidate();
    else this.tellStatus();
  }

  private wanted(): Map<number, number> {
    const weights = blendWeights(this.pem.axes, { ...this.point });
    return this.settings.blend ? weights : new Map([[nearestSample(weights), 1]]);
  }

  private byDistance(): number[] {
    return samplesByDistance(this.pem.axes, { ...this.point });
  }

  private view(camera: Camera): View {
    return { camera, blend: this.maps.shown(this.wanted(), this.byDistance()), shown: this.settings.shown };
  }
}
