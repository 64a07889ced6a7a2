// How finely a picture in motion is drawn, by the time that frames take.

export const COARSEST = 4;
const SLOW_MS = 50; // a frame that takes longer makes the next one coarser
const FAST_MS = 12; // four times as many pixels, or samples, will not be slow

export interface Pace {
  /** Pixels of the screen along the edge of one of the picture. */
  readonly coarseness: number;
  /** More samples, where those disagree, in all pixels of the screen; undefined until tried. */
  readonly more: boolean | undefined;
}

export const FIRST_PACE: Pace = { coarseness: COARSEST, more: undefined };

/** Of the frame after one that took so long. More samples that were slow are not tried again. */
export function nextPace({ coarseness, more }: Pace, ms: number): Pace {
  if (ms > SLOW_MS && more) return { coarseness, more: false };
  if (ms > SLOW_MS) return { coarseness: Math.min(2 * coarseness, COARSEST), more };
  if (ms < FAST_MS && coarseness > 1) return { coarseness: coarseness / 2, more };
  return { coarseness, more: ms < FAST_MS ? (more ?? true) : more };
}
