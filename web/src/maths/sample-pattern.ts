// Where a pixel's sub-samples lie, in 1/32 of a pixel: twin of reflet.scene.views.sample_pattern.

export const PATTERN = [
  [12, 4], [28, 12], [4, 20], [20, 28], [1, 3], [3, 9], [7, 31], [15, 15],
  [11, 23], [13, 29], [23, 7], [21, 13], [19, 19], [27, 1], [25, 17], [29, 27],
] as const; // biome-ignore format: a table
