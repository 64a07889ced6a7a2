// Where a pixel's sub-samples lie, in 1/128 of a pixel: twin of reflet.scene.views.sample_pattern.

const PATTERN = [
  [48, 16], [112, 48], [16, 80], [80, 112], [4, 12], [12, 36], [28, 124], [60, 60],
  [44, 92], [52, 116], [92, 28], [84, 52], [76, 76], [108, 4], [100, 68], [116, 108],
  [37, 59], [9, 57], [19, 105], [99, 97], [67, 11], [31, 25], [111, 83], [1, 75],
  [35, 79], [127, 27], [47, 31], [105, 35], [95, 111], [91, 85], [55, 101], [65, 47],
  [89, 7], [11, 121], [27, 41], [51, 73], [123, 127], [115, 65], [21, 9], [41, 3],
  [43, 45], [7, 91], [71, 123], [103, 19], [125, 43], [73, 63], [33, 99], [75, 89],
  [3, 107], [79, 21], [59, 87], [23, 55], [63, 33], [69, 103], [57, 1], [121, 95],
  [15, 23], [119, 15], [39, 115], [83, 39], [87, 67], [97, 51], [107, 119], [25, 71],
] as const; // biome-ignore format: a table

const MOVED = [
  [0, 0],
  [64, 64],
  [64, 0],
  [0, 64],
] as const; // and the same again, and again

/** Samples where they count: the pattern's `first` in every pixel, all `most` where those disagree. */
export interface Adaptive {
  readonly first: number;
  readonly most: number;
}

export const AT_REST: Adaptive = { first: 16, most: 256 };
export const IN_MOTION: Adaptive = { first: 4, most: 16 };

/** A pixel. */
export type Samples = number | Adaptive;

export const mostSamples = (samples: Samples): number => (typeof samples === "number" ? samples : samples.most);

/** The first `count` positions as [x, y] from a pixel's top left corner, in pixels; one is the centre. */
export function samplePositions(count: number): (readonly [number, number])[] {
  const all = MOVED.flatMap(([right, down]) => PATTERN.map(([x, y]) => [(x + right) % 128, (y + down) % 128] as const));
  return count === 1 ? [[0.5, 0.5]] : all.slice(0, count).map(([x, y]) => [x / 128, y / 128] as const);
}
