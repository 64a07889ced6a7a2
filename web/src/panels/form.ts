// What the panels have in common: the form that shows settings and is read when a user changes them.

import { NORMAL_EXPOSURE } from "../maths/tone"; // 0 on the slider, which counts in stops
import { setMarkup } from "./markup";

/** A panel, and its fields by name. Panels show their settings once they have them: at the end of their constructors. */
export abstract class Form {
  readonly element = document.createElement("form");

  constructor(label: string, markup: string, onChange: () => void, onHome: () => void) {
    this.element.className = "panel";
    this.element.setAttribute("aria-label", label);
    setMarkup(this.element, `${markup}<p class="status" aria-live="off"></p>`);
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
