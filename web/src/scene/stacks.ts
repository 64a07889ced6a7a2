// Which maps share an array on the device: twin of reflet.render.playback.stacks.

import type { MapShape } from "../maths/parameterization";
import type { Layer } from "./pem";

export const MOST_SHELLS = 3; // of one object

/** Layers whose maps lie one after the other in each slot of an array: an object's shells, nearest first, or a local one. */
export interface Stack {
  readonly kind: Layer["kind"];
  readonly layers: readonly number[]; // of the PEM
  readonly parts: readonly number[];
  readonly shape: MapShape;
}

/** Distant layers of the same parts are the shells of one object. */
export function stacksOf(layers: readonly Layer[]): Stack[] {
  const byParts = new Map<string, number[]>();
  layers.forEach(({ kind, parts }, number) => {
    const key = kind === "distant" ? String(parts) : `layer ${number}`;
    byParts.set(key, [...(byParts.get(key) ?? []), number]);
  });
  return [...byParts.values()].map((numbers) => {
    const members = numbers.map((number) => layers[number] as Layer);
    const [shape] = members as [Layer];
    const alike = members.every(
      ({ size, parameterization }) => size === shape.size && parameterization === shape.parameterization,
    );
    if (numbers.length > MOST_SHELLS || !alike) {
      throw new Error(
        `The distant layers ${members.map((layer) => layer.name).join(", ")} are no shells of one object.`,
      );
    }
    return { kind: shape.kind, layers: numbers, parts: shape.parts, shape };
  });
}
