// The panel of a PEM's controls: plain form elements, kept in step with the settings.

import { KINDS } from "../maths/geometry";
import { TONE_CURVES } from "../maths/tone";
import type { Pem } from "../scene/pem";
import { Form } from "./form";
import { chooser, exposureSlider, segments, slider, words } from "./markup";
import type { Settings } from "./settings";

const template = (pem: Pem): string => `
  ${segments("view", "View", [
    ["picture", "Picture"],
    ["maps", "Maps"],
  ])}
  ${chooser(
    "layer",
    "Map",
    pem.layers.map((layer, k) => [
      String(k),
      layer.name.includes(layer.kind) ? layer.name : `${layer.name}, ${layer.kind}`,
    ]),
    'data-for="maps"',
  )}
  <div data-for="picture">
    ${segments("blend", "Viewpoints", [
      ["blended", "Blended"],
      ["nearest", "Nearest"],
    ])}
    <fieldset class="checks">
      <legend>Layers</legend>
      ${(["distant", "local", "diffuse", "fresnel"] as const)
        .map((name) => `<label><input type="checkbox" name="${name}" /><span>${name}</span></label>`)
        .join("")}
    </fieldset>
    ${chooser("geometry", "Geometry", [
      ["baked", `as baked: ${words(pem.layers.find((layer) => layer.kind === "distant")?.geometry.kind ?? "none")}`],
      ...KINDS.map((kind) => [kind, words(kind)] as const),
    ])}
    ${slider("growth", "Its size", -2, 2, 0.05)}
  </div>
  ${exposureSlider}
  ${chooser(
    "curve",
    "Tone",
    TONE_CURVES.map((curve) => [curve, curve]),
  )}
  <button type="button" class="home">Return to the orbit</button>`;

export class Panel extends Form {
  constructor(
    pem: Pem,
    private readonly settings: Settings,
    onChange: () => void,
    onHome: () => void,
  ) {
    super("Display settings", template(pem), onChange, onHome);
    this.show();
  }

  show(): void {
    const { settings } = this;
    this.radio("view", settings.view);
    this.radio("blend", settings.blend ? "blended" : "nearest");
    for (const name of ["distant", "local", "diffuse", "fresnel"] as const) {
      this.input(name).checked = settings.shown[name];
    }
    this.input("layer").value = String(settings.layer);
    this.input("geometry").value = settings.geometry;
    this.input("curve").value = settings.curve;
    this.showExposure(settings.exposure);
    this.slider("growth", Math.log2(settings.growth), `×${settings.growth.toFixed(2)}`);
    for (const element of this.element.querySelectorAll<HTMLElement>("[data-for]")) {
      element.hidden = element.dataset.for !== settings.view;
    }
  }

  protected read(): void {
    const { settings } = this;
    const data = new FormData(this.element);
    settings.view = data.get("view") as Settings["view"];
    settings.blend = data.get("blend") === "blended";
    for (const name of ["distant", "local", "diffuse", "fresnel"] as const) settings.shown[name] = data.has(name);
    settings.layer = Number(data.get("layer"));
    settings.geometry = data.get("geometry") as Settings["geometry"];
    settings.growth = 2 ** this.number("growth");
    settings.exposure = this.exposure;
    settings.curve = data.get("curve") as Settings["curve"];
  }
}
