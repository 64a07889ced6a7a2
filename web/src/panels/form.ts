// What the panels have in common: pieces of markup, and the form that shows settings and is read when a user changes them.

import { NORMAL_EXPOSURE } from "../maths/tone"; // 0 on the slider, which counts in stops

export const words = (name: string): string => name.replaceAll("_", " ");

const escapeHtml = (text: string): string => text.replace(/[&<>"']/g, (character) => `&#${character.charCodeAt(0)};`);

type Choices = readonly (readonly [value: string, label: string])[];

const options = (values: Choices): string =>
  values.map(([value, label]) => `<option value="${escapeHtml(value)}">${escapeHtml(label)}</option>`).join("");

/** A row of buttons, of which one is pressed. */
export const segments = (name: string, legend: string, values: Choices): string => `
  <fieldset class="segments">
    <legend>${legend}</legend>
    ${values.map(([value, label]) => `<label><input type="radio" name="${name}" value="${value}" /><span>${label}</span></label>`).join("")}
  </fieldset>`;

/** A list to choose from; `attributes` are the row's. */
export const chooser = (name: string, label: string, values: Choices, attributes = ""): string =>
  `<label class="row" ${attributes}><span>${label}</span><select name="${name}">${options(values)}</select></label>`;

export const slider = (name: string, label: string, least: number, most: number, step: number): string =>
  `<label class="row"><span>${label}</span><input name="${name}" type="range" min="${least}" max="${most}" step="${step}" /><output></output></label>`;

/** A panel, and its fields by name. Panels show their settings once they have them: at the end of their constructors. */
export abstract class Form {
  readonly element = document.createElement("form");

  constructor(label: string, markup: string, onChange: () => void, onHome: () => void) {
    this.element.className = "panel";
    this.element.setAttribute("aria-label", label);
    this.element.innerHTML = `${markup}<p class="status" aria-live="off"></p>`;
    this.element.addEventListener("submit", (event) => event.preventDefault());
    this.element.addEventListener("input", () => {
      this.read();
      this.show();
      onChange();
    });
    this.element.querySelector(".home")?.addEventListener("click", onHome);
  }

  /** Puts the settings into the form. */
  abstract show(): void;

  /** Takes them from there. */
  protected abstract read(): void;

  /** What is said at its foot. */
  set status(text: string) {
    (this.element.querySelector(".status") as HTMLElement).textContent = text;
  }

  input(name: string): HTMLInputElement {
    return this.element.elements.namedItem(name) as HTMLInputElement;
  }

  radio(name: string, value: string): void {
    (this.element.elements.namedItem(name) as RadioNodeList).value = value;
  }

  slider(name: string, value: number, text: string): void {
    const input = this.input(name);
    input.value = String(value);
    input.dataset.shown = input.value; // what the slider's steps make of it
    (input.nextElementSibling as HTMLOutputElement).value = text;
  }

  /** Whether the user has moved a slider since it was shown: one that was not says less than what it shows. */
  moved(name: string): boolean {
    const input = this.input(name);
    return input.value !== input.dataset.shown;
  }

  number(name: string): number {
    return Number(this.input(name).value);
  }

  showExposure(exposure: number): void {
    const stops = Math.log2(exposure / NORMAL_EXPOSURE);
    this.slider("exposure", stops, `${stops < -0.05 ? "−" : "+"}${Math.abs(stops).toFixed(1)}`);
  }

  get exposure(): number {
    return NORMAL_EXPOSURE * 2 ** this.number("exposure");
  }
}

export const exposureSlider = slider("exposure", "Exposure", -4, 4, 0.1);
