// What can be set of each material, and what it begins with: the one table behind the panel's fields.

import type { Vec3 } from "../maths/vectors";
import type { Metal, ShadedScene, Shown } from "../scene/shaded-scene";

type Kind = Shown["kind"];

export interface Field {
  readonly name: string;
  readonly label: string;
  readonly type: "colour" | "slider" | "metal";
  readonly least?: number;
  readonly most?: number;
  readonly step?: number;
  /** From what the slider shows to the value, and back; by default the same. */
  readonly scale?: { readonly value: (shown: number) => number; readonly shown: (value: number) => number };
  readonly text?: (value: number) => string;
}

const decimals = (digits: number) => (value: number) => value.toFixed(digits);
const colour = (name: string, label: string): Field => ({ name, label, type: "colour" });
const share = (name: string, label: string): Field => ({
  ...{ name, label, type: "slider", least: 0, most: 1, step: 0.01 },
  text: decimals(2),
});

const INDEX: Field = {
  ...{ name: "index", label: "Index", type: "slider", least: 0, most: 1, step: 0.002 },
  // From 1 to 200, with glass near the left and half of the way for what is below 4.
  scale: { value: (shown) => 200 ** (shown * shown * 0.95 + 0.05 * shown), shown: shownIndex },
  text: (value) => (value < 10 ? value.toFixed(2) : value.toFixed(0)),
};

function shownIndex(index: number): number {
  const power = Math.log(Math.max(index, 1)) / Math.log(200);
  return (-0.05 + Math.sqrt(0.0025 + 3.8 * power)) / 1.9;
}

const EXPONENT: Field = {
  ...{ name: "exponent", label: "Exponent", type: "slider", least: 0, most: 12, step: 0.05 },
  scale: { value: (shown) => 2 ** shown, shown: (value) => Math.log2(value) },
  text: (value) => (value < 10 ? value.toFixed(1) : value.toFixed(0)),
};

export const FIELDS: Record<Kind, readonly Field[]> = {
  mirror: [colour("reflectance", "Colour")],
  dielectric: [INDEX],
  dielectric_over_diffuse: [INDEX, colour("albedo", "Colour")],
  coated: [INDEX, colour("albedo", "Colour")],
  conductor: [{ name: "metal", label: "Metal", type: "metal" }],
  phong: [EXPONENT, colour("specular", "Highlights"), colour("diffuse", "Diffuse")],
  ggx: [share("roughness", "Roughness"), share("metallic", "Metallic"), colour("baseColor", "Colour")],
  map: [],
  table: [],
};

/** What the chooser calls the kinds. */
export const KIND_NAMES: Record<Exclude<Kind, "map" | "table">, string> = {
  mirror: "mirror",
  dielectric: "dielectric",
  dielectric_over_diffuse: "dielectric + diffuse",
  coated: "coated",
  conductor: "metal",
  phong: "Phong",
  ggx: "GGX",
};

const WHITE: Vec3 = [1, 1, 1];
const RED: Vec3 = [0.5, 0.02, 0.02];

/** A material of each kind to begin with, by what the chooser calls it: with the name for maps and tables. */
export function firstMaterials({ metals, maps, tables, materials: chosen }: ShadedScene): Map<string, Shown> {
  const materials: Shown[] = [
    { kind: "mirror", reflectance: WHITE },
    { kind: "dielectric", index: 1.5 },
    { kind: "dielectric_over_diffuse", index: 1.5, albedo: RED },
    { kind: "coated", index: 1.5, albedo: RED },
    { kind: "conductor", ...index(metals[0] as Metal) },
    { kind: "phong", exponent: 50, specular: [0.5, 0.5, 0.5], diffuse: [0.25, 0.01, 0.01] },
    { kind: "ggx", baseColor: WHITE, metallic: 1, roughness: 0.3 },
    ...maps.map(({ name }) => ({ kind: "map" as const, map: name })),
    ...tables.map(({ name }) => ({ kind: "table" as const, table: name })),
    ...[...chosen].reverse(),
  ];
  return new Map(materials.map((each) => [choiceOf(each), each]));
}

export function choiceOf(material: Shown): string {
  if (material.kind === "map") return `map:${material.map}`;
  return material.kind === "table" ? `table:${material.table}` : material.kind;
}

export const index = ({ n, k }: Metal) => ({ n, k });
