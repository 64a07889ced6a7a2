// The panel of controls: plain form elements, kept in step with the settings.

import { KINDS } from "./geometry";
import { TONE_CURVES } from "./gpu/renderer";
import type { Pem } from "./pem";
import type { Settings } from "./settings";

const NORMAL_EXPOSURE = 1.6; // 0 on the slider, which counts in stops

const words = (name: string): string => name.replaceAll("_", " ");

const escapeHtml = (text: string): string => text.replace(/[&<>"']/g, (character) => `&#${character.charCodeAt(0)};`);

const options = (values: readonly (readonly [value: string, label: string])[]): string =>
  values.map(([value, label]) => `<option value="${escapeHtml(value)}">${escapeHtml(label)}</option>`).join("");

const choice = (name: string, legend: string, values: readonly (readonly [value: string, label: string])[]): string => `
  <fieldset class="segments">
    <legend>${legend}</legend>
    ${values.map(([value, label]) => `<label><input type="radio" name="${name}" value="${value}" /><span>${label}</span></label>`).join("")}
  </fieldset>`;

const template = (pem: Pem): string => `
  ${choice("view", "View", [
    ["picture", "Picture"],
    ["maps", "Maps"],
  ])}
  <label class="row" data-for="maps"><span>Map</span><select name="layer">${options(
    pem.layers.map((layer, k) => [
      String(k),
      layer.name.includes(layer.kind) ? layer.name : `${layer.name}, ${layer.kind}`,
    ]),
  )}</select></label>
  <div data-for="picture">
    ${choice("blend", "Viewpoints", [
      ["blended", "Blended"],
      ["nearest", "Nearest"],
    ])}
    <fieldset class="checks">
      <legend>Layers</legend>
      ${(["distant", "local", "diffuse", "fresnel"] as const)
        .map((name) => `<label><input type="checkbox" name="${name}" /><span>${name}</span></label>`)
        .join("")}
    </fieldset>
    <label class="row"><span>Geometry</span><select name="geometry">${options([
      ["baked", `as baked: ${words(pem.layers.find((layer) => layer.kind === "distant")?.geometry.kind ?? "none")}`],
      ...KINDS.map((kind) => [kind, words(kind)] as const),
    ])}</select></label>
    <label class="row"><span>Its size</span><input name="growth" type="range" min="-2" max="2" step="0.05" /><output></output></label>
  </div>
  <label class="row"><span>Exposure</span><input name="exposure" type="range" min="-4" max="4" step="0.1" /><output></output></label>
  <label class="row"><span>Tone</span><select name="curve">${options(TONE_CURVES.map((curve) => [curve, curve]))}</select></label>
  <button type="button" class="home">Return to the orbit</button>
  <p class="status" aria-live="off"></p>`;

export class Panel {
  readonly element = document.createElement("form");

  constructor(
    pem: Pem,
    private readonly settings: Settings,
    onChange: () => void,
    onHome: () => void,
  ) {
    this.element.className = "panel";
    this.element.setAttribute("aria-label", "Display settings");
    this.element.innerHTML = template(pem);
    this.show();
    this.element.addEventListener("submit", (event) => event.preventDefault());
    this.element.addEventListener("input", () => {
      this.read();
      this.show();
      onChange();
    });
    this.element.querySelector(".home")?.addEventListener("click", onHome);
  }

  set status(text: string) {
    (this.element.querySelector(".status") as HTMLElement).textContent = text;
  }

  /** Puts the settings into the form. */
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
    const stops = Math.log2(settings.exposure / NORMAL_EXPOSURE);
    this.slider("exposure", stops, `${stops < -0.05 ? "−" : "+"}${Math.abs(stops).toFixed(1)}`);
    this.slider("growth", Math.log2(settings.growth), `×${settings.growth.toFixed(2)}`);
    for (const element of this.element.querySelectorAll<HTMLElement>("[data-for]")) {
      element.hidden = element.dataset.for !== settings.view;
    }
  }

  private read(): void {
    const { settings } = this;
    const data = new FormData(this.element);
    settings.view = data.get("view") as Settings["view"];
    settings.blend = data.get("blend") === "blended";
    for (const name of ["distant", "local", "diffuse", "fresnel"] as const) settings.shown[name] = data.has(name);
    settings.layer = Number(data.get("layer"));
    settings.geometry = data.get("geometry") as Settings["geometry"];
    settings.growth = 2 ** Number(data.get("growth"));
    settings.exposure = NORMAL_EXPOSURE * 2 ** Number(data.get("exposure"));
    settings.curve = data.get("curve") as Settings["curve"];
  }

  private input(name: string): HTMLInputElement {
    return this.element.elements.namedItem(name) as HTMLInputElement;
  }

  private radio(name: string, value: string): void {
    (this.element.elements.namedItem(name) as RadioNodeList).value = value;
  }

  private slider(name: string, value: number, text: string): void {
    const input = this.input(name);
    input.value = String(value);
    (input.nextElementSibling as HTMLOutputElement).value = text;
  }
}
