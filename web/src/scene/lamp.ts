// A lamp in the environment: what can be set of it, and what it then is. Twin of reflet.envmap.lamp.

import type { Vec3 } from "../maths/vectors";

export interface LampSettings {
  on: boolean;
  /** Where it stands, in degrees, as cameras do; it turns with the environment. */
  azimuth: number;
  elevation: number;
  /** In degrees, from 1 to 60. */
  radius: number;
  /** The brightest channel's radiance. */
  brightness: number;
  /** Shares of that. */
  colour: Vec3;
  /** Goes round by itself. */
  circling: boolean;
}

export const firstLamp = (): LampSettings => ({
  on: false,
  azimuth: -20,
  elevation: 40,
  radius: 8,
  brightness: 32,
  colour: [1, 1, 1],
  circling: false,
});

/** A soft disc at infinity. */
export interface Lamp {
  readonly direction: Vec3; // of length 1
  readonly squareChord: number; // between its middle and its rim
  readonly radiance: Vec3;
}

export function lampOf({ azimuth, elevation, radius, brightness, colour }: LampSettings): Lamp {
  const [phi, theta, angle] = [azimuth, elevation, radius].map((degrees) => (degrees * Math.PI) / 180) as [
    number,
    number,
    number,
  ];
  return {
    direction: [Math.cos(phi) * Math.cos(theta), Math.sin(theta), -Math.sin(phi) * Math.cos(theta)],
    squareChord: 4 * Math.sin(angle / 2) ** 2,
    radiance: [brightness * colour[0], brightness * colour[1], brightness * colour[2]],
  };
}

/** From -180 to 180. */
export const wrapped = (degrees: number): number => ((((degrees + 180) % 360) + 360) % 360) - 180;
