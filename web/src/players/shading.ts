// Shows a mesh of any material in an environment that can be turned.

import type { PictureSum } from "../gpu/device/picture-sum";
import type { Rotation } from "../gpu/maps/env-map";
import { MaterialRenderer, type MaterialView } from "../gpu/materials/material-renderer";
import type { Camera } from "../maths/camera";
import { mostSamples, type Samples } from "../maths/sample-pattern";
import { NORMAL_EXPOSURE, type Tone } from "../maths/tone";
import { choiceOf } from "../panels/material-fields";
import { MaterialPanel } from "../panels/material-panel";
import type { ShadingSettings } from "../panels/shading-settings";
import { firstLamp, type LampSettings, lampOf, wrapped } from "../scene/lamp";
import { KINDS } from "../scene/material";
import type { ShadedScene, Shown } from "../scene/shaded-scene";
import { type Listener, Player } from "./player";

const CIRCLING_DEGREES_PER_MS = 0.03;

/** `map_from_world` of an environment turned about the vertical: twin of reflet.shade.turn_about_vertical. */
export function turnAboutVertical(degrees: number): Rotation {
  const [cosine, sine] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [
    [cosine, 0, -sine],
    [0, 1, 0],
    [sine, 0, cosine],
  ];
}

export class Shading extends Player {
  readonly panel: MaterialPanel;
  readonly complete = true;
  protected readonly drawable = true;
  protected readonly atRest = 16;
  readonly settings: ShadingSettings;
  private renderer!: MaterialRenderer;
  private circled = 0; // when the lamp last moved by itself

  constructor(
    canvas: HTMLCanvasElement,
    private readonly scene: ShadedScene,
    listener: Listener,
  ) {
    super(canvas, scene, listener);
    this.settings = {
      material: scene.materials[0],
      turn: 0,
      lamp: firstLamp(),
      backdrop: true,
      exposure: NORMAL_EXPOSURE,
      curve: "exponential",
    };
    this.panel = new MaterialPanel(
      scene,
      this.settings,
      () => this.invalidate(),
      () => this.home(),
    );
  }

  protected async prepare(device: GPUDevice, format: GPUTextureFormat): Promise<void> {
    this.renderer = await MaterialRenderer.create(device, this.scene, format);
  }

  configure({ lamp, ...settings }: Partial<Omit<ShadingSettings, "lamp">> & { lamp?: Partial<LampSettings> }): void {
    if (settings.material) this.check(settings.material);
    Object.assign(this.settings, settings);
    Object.assign(this.settings.lamp, lamp);
    this.panel.show();
    this.invalidate();
  }

  /** The light follows the pointer: what is in front of it goes to the right, what is behind to the left. */
  override shiftDrag(degrees: number): boolean {
    this.configure({ turn: wrapped(this.settings.turn + degrees) });
    return true;
  }

  override toggleLamp(): void {
    this.configure({ lamp: { on: !this.settings.lamp.on } });
  }

  override moveLamp(degrees: number): void {
    const { on, azimuth } = this.settings.lamp;
    if (on) this.configure({ lamp: { azimuth: wrapped(azimuth + degrees) } });
  }

  /** A circling lamp asks for the next frame as soon as one is drawn. */
  protected override drawMoving(): boolean {
    const now = performance.now();
    if (this.lampShows && this.settings.lamp.circling) {
      this.moveLamp(CIRCLING_DEGREES_PER_MS * Math.min(now - this.circled, 100));
    }
    this.circled = now;
    return super.drawMoving();
  }

  private get lampShows(): boolean {
    const { lamp, material } = this.settings;
    return lamp.on && material.kind !== "map";
  }

  /** Drawings are no light: they are shown as they are, unless the exposure is changed. */
  protected get tone(): Tone {
    const { material, exposure, curve } = this.settings;
    return material.kind === "map" ? { exposure: exposure / NORMAL_EXPOSURE, curve: "linear" } : { exposure, curve };
  }

  protected get sum(): PictureSum {
    return this.renderer.sum;
  }

  protected drawMultisampled(camera: Camera): void {
    this.renderer.drawMultisampled(this.view(camera));
  }

  /** Materials take all samples everywhere. */
  protected drawNextSample(camera: Camera, samples: Samples, first: boolean): void {
    this.renderer.drawNextSample(this.view(camera), mostSamples(samples), first);
  }

  protected facts(): string[] {
    const triangles = this.scene.parts.reduce((sum, part) => sum + part.indices.length / 3, 0);
    return [`${triangles.toLocaleString("en")} triangles`];
  }

  /** Throws for what this scene cannot show. */
  private check(material: Shown): void {
    const { maps, tables } = this.scene;
    const known = [
      ...KINDS,
      ...maps.map(({ name }) => choiceOf({ kind: "map", map: name })),
      ...tables.map(({ name }) => choiceOf({ kind: "table", table: name })),
    ];
    const choice = choiceOf(material);
    if (!known.includes(choice)) throw new Error(`There is no material ${choice} here; there are ${known.join(", ")}.`);
  }

  private view(camera: Camera): MaterialView {
    const { material, turn, backdrop, lamp } = this.settings;
    return {
      camera,
      material,
      mapFromWorld: turnAboutVertical(turn),
      backdrop,
      lamp: this.lampShows ? lampOf(lamp) : undefined,
    };
  }
}
