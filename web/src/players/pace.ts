// How finely a picture in motion is drawn, and how many sub-samples of one at rest at once, by the time that frames take.

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

const AS_IN_MOTION = 4; // sub-samples: a picture of fewer would look worse than the one on the screen
const FEW = 1.25; // times as many look the same
const MOST_AT_ONCE = 64;

export const FIRST_BURST = 1;

/** How many sub-samples are drawn in one frame at rest, after so many took so long: twice as many will not be slow. */
export function nextBurst(burst: number, ms: number): number {
  if (ms > SLOW_MS) return Math.max(Math.floor(burst / 2), 1);
  return ms < SLOW_MS / 2 ? Math.min(2 * burst, MOST_AT_ONCE) : burst;
}

/** Whether a picture of so many sub-samples is put on the screen, where there is one of `shown`: that takes time too. */
export function worthShowing(samples: number, shown: number): boolean {
  return samples >= Math.max(AS_IN_MOTION, FEW * shown);
}
