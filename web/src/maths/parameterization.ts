// How maps lay directions out: what a host needs to know of reflet.envmap.parameterizations.by_name; the rest is the shaders'.

export interface Parameterization {
  readonly kind: number; // its number in shaders
  readonly faceCount: number;
  readonly aspect: number; // columns over rows of a face
}

export const PARAMETERIZATIONS = {
  cube: { kind: 0, faceCount: 6, aspect: 1 },
  latlong: { kind: 1, faceCount: 1, aspect: 2 },
  dual_paraboloid: { kind: 2, faceCount: 2, aspect: 1 },
  gazing_ball: { kind: 3, faceCount: 1, aspect: 1 },
  angular: { kind: 4, faceCount: 1, aspect: 1 },
  octahedral: { kind: 5, faceCount: 1, aspect: 1 },
  equal_area_octahedral: { kind: 6, faceCount: 1, aspect: 1 },
} as const satisfies Record<string, Parameterization>;

export type ParameterizationName = keyof typeof PARAMETERIZATIONS;

export const isParameterization = (name: string): name is ParameterizationName => name in PARAMETERIZATIONS;

/** Rows, columns and faces of maps, as layers name them. */
export interface MapShape {
  readonly parameterization: ParameterizationName;
  readonly size: number; // rows of a face at the finest level, a power of two
}

export const levelCount = ({ size }: MapShape): number => Math.log2(size) + 1;

/** Bytes of one mip level in half-float RGBA. */
export function levelBytes({ parameterization, size }: MapShape, mipLevel: number): number {
  const { faceCount, aspect } = PARAMETERIZATIONS[parameterization];
  return 8 * faceCount * aspect * (size >> mipLevel) ** 2;
}

/** Bytes of a map with all its mip levels. */
export function mapBytes(shape: MapShape): number {
  let bytes = 0;
  for (let mipLevel = 0; mipLevel < levelCount(shape); mipLevel++) bytes += levelBytes(shape, mipLevel);
  return bytes;
}
