// The panel of a PEM's controls: plain form elements, kept in step with the settings.

import { KINDS } from "../maths/geometry";
import { TONE_CURVES } from "../maths/tone";
import { type Layer, MAP_SHOWS, type Pem, type Shown } from "../scene/pem";
import { stacksOf } from "../scene/stacks";
import { Form } from "./form";
import { checks, chooser, exposureSlider, segments, slider, words } from "./markup";
import type { Settings } from "./settings";

/** What of the picture can be left out: local light where there is any. */
function switchesOf(pem: Pem): (keyof Shown)[] {
  const local = pem.traced ?? (pem.maps.length > 0 && pem.layers.some(({ kind }) => kind === "local"));
  return ["distant", ...(local ? ["local" as const] : []), "diffuse", "fresnel"];
}

/** The shells of each object, the nearest first. */
const shellsOf = (pem: Pem): Layer[][] =>
  stacksOf(pem.layers)
    .filter(({ kind }) => kind === "distant")
    .map(({ layers }) => layers.map((layer) => pem.layers[layer] as Layer));

/** What the boxes say: the name of each shell, of several objects those of all. */
function shellNames(pem: Pem): string[] {
  const objects = shellsOf(pem);
  const most = Math.max(0, ...objects.map((shells) => shells.length));
  return Array.from({ length: most }, (_, shell) =>
    [...new Set(objects.flatMap((shells) => shells[shell]?.name ?? []))].join(", "),
  );
}

/** "relief and box": the kinds of the first object's shells. */
const bakedKinds = (pem: Pem): string =>
  words([...new Set(shellsOf(pem)[0]?.map(({ geometry }) => geometry.kind) ?? ["none"])].join(" and "));

/** What the colours of mirrored light mean. */
function origins(pem: Pem): [name: string, label: string][] {
  const nearer = shellNames(pem).length - 1;
  const shells: [string, string][] = [
    ["near", nearer > 1 ? "nearest shell" : "near shell"],
    ["middle", "the next"],
  ];
  const local = switchesOf(pem).includes("local");
  return [
    ...(local ? [["own-mesh", "the object itself"] as [string, string]] : []),
    ...shells.slice(0, Math.max(nearer, 0)),
    ["far", nearer > 0 ? "far shell" : "surroundings"],
  ];
}

const labelOf = ({ name, kind }: Layer): string => (name.includes(kind) ? name : `${name}, ${kind}`);

const template = (pem: Pem): string => {
  const shells = shellNames(pem);
  const maps = pem.layers.flatMap((layer, k): [string, string][] =>
    pem.maps.length > 0 || layer.kind === "distant" ? [[String(k), labelOf(layer)]] : [],
  );
  const sources = [
    ["viewpoint", "Viewpoint"],
    ["base", "All viewpoints"],
  ] as const;
  return `
  ${segments("view", "View", [
    ["picture", "Picture"],
    ["maps", "Maps"],
  ])}
  <div data-for="maps">
    ${chooser("layer", "Map", maps)}
    ${pem.maps.length > 0 && pem.base.length > 0 ? segments("mapOf", "Made for", sources) : ""}
    ${segments(
      "mapShows",
      "Shows",
      MAP_SHOWS.map((name) => [name, `${name.charAt(0).toUpperCase()}${name.slice(1)}`]),
    )}
  </div>
  <div data-for="picture">
    ${
      pem.maps.length > 1
        ? segments("blend", "Viewpoints", [
            ["blended", "Blended"],
            ["nearest", "Nearest"],
          ])
        : ""
    }
    ${checks(
      "Layers",
      switchesOf(pem).map((name) => [name, name]),
    )}
    ${
      shells.length > 1
        ? checks(
            "Shells, the nearest first",
            shells.map((name, shell) => [`shell-${shell}`, name]),
          )
        : ""
    }
    ${segments("mirrored", "Mirrored light", [
      ["seen", "As seen"],
      ["origin", "By origin"],
    ])}
    <p class="origins">${origins(pem)
      .map(([name, label]) => `<span class="${name}">${label}</span>`)
      .join("")}</p>
    ${chooser("geometry", "Geometry", [
      ["baked", `as baked: ${bakedKinds(pem)}`],
      ...KINDS.map((kind) => [kind, shells.length > 1 ? `${words(kind)}, all shells` : words(kind)] as const),
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
};

export class Panel extends Form {
  constructor(
    private readonly pem: Pem,
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
    if (this.input("blend")) this.radio("blend", settings.blend ? "blended" : "nearest");
    for (const name of switchesOf(this.pem)) this.input(name).checked = settings.shown[name];
    for (const [input, shell] of this.shells) input.checked = !settings.hiddenShells.includes(shell);
    this.input("layer").value = String(settings.layer);
    if (this.input("mapOf")) this.radio("mapOf", settings.mapOf);
    this.radio("mapShows", settings.mapShows);
    const distance = this.element.querySelector('[name="mapShows"][value="distance"]') as HTMLInputElement;
    distance.disabled = this.pem.layers[settings.layer]?.geometry.kind !== "relief"; // radiance is shown then
    this.radio("mirrored", settings.byOrigin ? "origin" : "seen");
    (this.element.querySelector(".origins") as HTMLElement).hidden = !settings.byOrigin;
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
    if (data.has("blend")) settings.blend = data.get("blend") === "blended";
    for (const name of switchesOf(this.pem)) settings.shown[name] = data.has(name);
    settings.hiddenShells = this.shells.filter(([input]) => !input.checked).map(([, shell]) => shell);
    settings.layer = Number(data.get("layer"));
    settings.mapOf = (data.get("mapOf") ?? settings.mapOf) as Settings["mapOf"];
    settings.mapShows = (data.get("mapShows") ?? settings.mapShows) as Settings["mapShows"];
    settings.byOrigin = data.get("mirrored") === "origin";
    settings.geometry = data.get("geometry") as Settings["geometry"];
    settings.growth = 2 ** this.number("growth");
    settings.exposure = this.exposure;
    settings.curve = data.get("curve") as Settings["curve"];
  }

  /** The boxes of the shells, none where there is but one. */
  private get shells(): [HTMLInputElement, number][] {
    const boxes = this.element.querySelectorAll<HTMLInputElement>('[name^="shell-"]');
    return [...boxes].map((input, shell) => [input, shell]);
  }
}
