// Pieces of markup, and how they become elements.

declare global {
  interface Window {
    readonly trustedTypes?: { createPolicy(name: string, rules: { createHTML(text: string): string }): typeof policy };
  }
}

// Pages that make elements from no text that comes along (Trusted Types) may still allow this policy by its name.
const policy: { createHTML(text: string): string } = window.trustedTypes?.createPolicy("reflet-viewer", {
  createHTML: (text) => text,
}) ?? { createHTML: (text) => text };

/** Fills an element. */
export function setMarkup(element: Element | ShadowRoot, markup: string): void {
  element.innerHTML = policy.createHTML(markup);
}

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

/** Boxes to check, by name; labels may be anyone's. */
export const checks = (legend: string, values: Choices): string => `
  <fieldset class="checks">
    <legend>${legend}</legend>
    ${values.map(([name, label]) => `<label><input type="checkbox" name="${name}" /><span>${escapeHtml(label)}</span></label>`).join("")}
  </fieldset>`;

/** A list to choose from; `attributes` are the row's. */
export const chooser = (name: string, label: string, values: Choices, attributes = ""): string =>
  `<label class="row" ${attributes}><span>${label}</span><select name="${name}">${options(values)}</select></label>`;

export const slider = (name: string, label: string, least: number, most: number, step: number): string =>
  `<label class="row"><span>${label}</span><input name="${name}" type="range" min="${least}" max="${most}" step="${step}" /><output></output></label>`;

export const exposureSlider = slider("exposure", "Exposure", -4, 4, 0.1);
