// Lights without extent as reflet writes them in glTF (KHR_lights_punctual): each in a node behind those of the parts.

import type { Vec3 } from "../maths/vectors";

/** Twin of reflet.scene.punctual_light.PunctualLight; without a position it is infinitely far away. */
export interface PunctualLight {
  readonly intensity: Vec3;
  readonly position: Vec3 | undefined;
  readonly direction: Vec3;
  readonly range: number;
  readonly cone: readonly [number, number] | undefined;
}

export interface LightsOfScene {
  lights: {
    type: string;
    color: number[];
    intensity: number;
    range?: number;
    spot?: { innerConeAngle: number; outerConeAngle: number };
  }[];
}

export interface NodeOfLight {
  matrix?: number[];
  extensions?: { KHR_lights_punctual?: { light: number } };
}

export function readLights(nodes: readonly NodeOfLight[], described: LightsOfScene | undefined): PunctualLight[] {
  return nodes.flatMap(({ matrix = [], extensions }) => {
    const item = described?.lights[extensions?.KHR_lights_punctual?.light ?? -1];
    if (item === undefined) return [];
    const column = (k: number) => matrix.slice(4 * k, 4 * k + 3);
    return {
      intensity: item.color.map((channel) => channel * item.intensity) as unknown as Vec3,
      position: item.type === "directional" ? undefined : (column(3) as unknown as Vec3),
      direction: column(2).map((value) => -value) as unknown as Vec3,
      range: item.range ?? Number.POSITIVE_INFINITY,
      cone: item.spot && ([item.spot.innerConeAngle, item.spot.outerConeAngle] as const),
    };
  });
}
