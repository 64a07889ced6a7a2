// The panel of a shaded mesh's controls: material, its own fields, light and tone.

import { TONE_CURVES } from "../maths/tone";
import type { Vec3 } from "../maths/vectors";
import type { ShadedScene, Shown } from "../scene/shaded-scene";
import { Form } from "./form";
import { chooser, exposureSlider, setMarkup, slider, words } from "./markup";
import { choiceOf, FIELDS, type Field, firstMaterials, index, KIND_NAMES } from "./material-fields";
import type { ShadingSettings } from "./shading-settings";

const fieldMarkup = (field: Field, scene: ShadedScene): string => {
  switch (field.type) {
    case "colour":
      return `<label class="row"><span>${field.label}</span><input name="${field.name}" type="color" /></label>`;
    case "metal":
      return chooser(
        field.name,
        field.label,
        scene.metals.map(({ name }) => [name, name]),
      );
    case "slider":
      return slider(field.name, field.label, field.least ?? 0, field.most ?? 1, field.step ?? 0.01);
  }
};

const template = (scene: ShadedScene): string => `
  ${chooser("kind", "Material", [
    ...Object.entries(KIND_NAMES),
    ...scene.tables.map(({ name }) => [`table:${name}`, name] as const),
    ...scene.maps.map(({ name }) => [`map:${name}`, words(name)] as const),
  ])}
  <div class="fields"></div>
  <div data-turned>${slider("turn", "Light", -180, 180, 1)}</div>
  <fieldset class="checks" data-lit><label><input type="checkbox" name="backdrop" /><span>backdrop</span></label><span data-lamp><label><input type="checkbox" name="lamp" /><span>lamp</span></label></span></fieldset>
  <div class="fields" data-lamp-on role="group" aria-label="Lamp">
    ${slider("lamp_azimuth", "Azimuth", -180, 180, 1)}
    ${slider("lamp_elevation", "Elevation", -90, 90, 1)}
    ${slider("lamp_radius", "Radius", 1, 60, 0.5)}
    ${slider("lamp_brightness", "Brightness", -4, 10, 0.1)}
    <label class="row"><span>Colour</span><input name="lamp_colour" type="color" aria-label="Colour of the lamp" /></label>
    <fieldset class="checks"><label><input type="checkbox" name="lamp_circling" /><span>circling</span></label></fieldset>
  </div>
  ${exposureSlider}
  ${chooser(
    "curve",
    "Tone",
    TONE_CURVES.map((curve) => [curve, curve]),
    "data-lit",
  )}
  <button type="button" class="home">Return to the first view</button>`;

export class MaterialPanel extends Form {
  private readonly materials: Map<string, Shown>; // the last of each choice
  private built = ""; // the choice whose fields are in the form

  constructor(
    private readonly scene: ShadedScene,
    private readonly settings: ShadingSettings,
    onChange: () => void,
    onHome: () => void,
  ) {
    super("Material and light", template(scene), onChange, onHome);
    this.materials = firstMaterials(scene);
    this.show();
  }

  show(): void {
    const { settings, scene } = this;
    const { material } = settings;
    const choice = choiceOf(material);
    this.materials.set(choice, material);
    this.input("kind").value = choice;
    const fields = FIELDS[material.kind];
    if (this.built !== choice) {
      const place = this.element.querySelector(".fields") as HTMLElement;
      setMarkup(place, fields.map((field) => fieldMarkup(field, scene)).join(""));
      place.hidden = fields.length === 0;
      this.built = choice;
    }
    for (const field of fields) this.showField(field, material);
    for (const element of this.element.querySelectorAll<HTMLElement>("[data-lit]")) {
      element.hidden = material.kind === "map";
    }
    const map = material.kind === "map" ? scene.maps.find(({ name }) => name === material.map) : undefined;
    (this.element.querySelector("[data-turned]") as HTMLElement).hidden = map?.lookup.startsWith("view_") ?? false;
    this.slider("turn", settings.turn, `${settings.turn.toFixed(0)}°`);
    this.input("backdrop").checked = settings.backdrop;
    this.showLamp(material.kind !== "map");
    this.input("curve").value = settings.curve;
    this.showExposure(settings.exposure);
  }

  private showLamp(possible: boolean): void {
    const { element } = this;
    const { on, azimuth, elevation, radius, brightness, colour, circling } = this.settings.lamp;
    (element.querySelector("[data-lamp]") as HTMLElement).hidden = !possible;
    (element.querySelector("[data-lamp-on]") as HTMLElement).hidden = !(possible && on);
    this.input("lamp").checked = on;
    this.slider("lamp_azimuth", azimuth, `${azimuth.toFixed(0)}°`);
    this.slider("lamp_elevation", elevation, `${elevation.toFixed(0)}°`);
    this.slider("lamp_radius", radius, `${radius.toFixed(1)}°`);
    this.slider("lamp_brightness", Math.log2(brightness), brightness.toPrecision(2));
    this.input("lamp_colour").value = hexFromLinear(colour);
    this.input("lamp_circling").checked = circling;
  }

  private readLamp(): void {
    const { lamp } = this.settings;
    lamp.on = this.input("lamp").checked;
    for (const name of ["azimuth", "elevation", "radius"] as const) {
      if (this.moved(`lamp_${name}`)) lamp[name] = this.number(`lamp_${name}`);
    }
    if (this.moved("lamp_brightness")) lamp.brightness = 2 ** this.number("lamp_brightness");
    const { value } = this.input("lamp_colour");
    if (value !== hexFromLinear(lamp.colour)) lamp.colour = linearFromHex(value);
    lamp.circling = this.input("lamp_circling").checked;
  }

  private showField({ name, type, scale, text }: Field, material: Shown): void {
    const value = (material as unknown as Record<string, number | Vec3>)[name];
    if (type === "slider") {
      const number = value as number;
      this.slider(name, scale ? scale.shown(number) : number, text ? text(number) : String(number));
    } else if (type === "colour") {
      this.input(name).value = hexFromLinear(value as Vec3);
    } else if (material.kind === "conductor") {
      const metal = this.scene.metals.find(({ n, k }) => String([n, k]) === String([material.n, material.k]));
      this.input(name).value = metal?.name ?? "";
    }
  }

  protected read(): void {
    const { settings } = this;
    const choice = this.input("kind").value;
    const before = this.materials.get(choice) as Shown;
    settings.material = choice === this.built ? this.readFields(before) : before;
    if (this.moved("turn")) settings.turn = this.number("turn");
    settings.backdrop = this.input("backdrop").checked;
    this.readLamp();
    settings.exposure = this.exposure;
    settings.curve = this.input("curve").value as ShadingSettings["curve"];
  }

  /** The material with what its fields say. What nobody has changed stays: sliders and colours round. */
  private readFields(material: Shown): Shown {
    const changed: Record<string, unknown> = { ...material };
    for (const { name, type, scale } of FIELDS[material.kind]) {
      const before = changed[name];
      if (type === "slider") {
        const shown = this.number(name);
        if (this.moved(name)) changed[name] = scale ? scale.value(shown) : shown;
      } else if (type === "colour") {
        const { value } = this.input(name);
        if (value !== hexFromLinear(before as Vec3)) changed[name] = linearFromHex(value);
      } else {
        const metal = this.scene.metals.find((each) => each.name === this.input(name).value);
        if (metal) Object.assign(changed, index(metal));
      }
    }
    return changed as unknown as Shown;
  }
}

/** "#rrggbb" in sRGB, as colour fields have it. */
export function hexFromLinear(color: Vec3): string {
  const encoded = color.map((linear) => {
    const value = linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
    return Math.round(255 * Math.min(Math.max(value, 0), 1))
      .toString(16)
      .padStart(2, "0");
  });
  return `#${encoded.join("")}`;
}

export function linearFromHex(hex: string): Vec3 {
  const channel = (at: number) => {
    const value = Number.parseInt(hex.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  };
  return [channel(1), channel(3), channel(5)];
}
