// How radiance becomes the colours of a screen: the numbers of display.wgsl's tone curves.

export const TONE_CURVES = ["exponential", "linear", "neutral"] as const;
export type ToneCurve = (typeof TONE_CURVES)[number];

export const NORMAL_EXPOSURE = 1.6; // CONVENTIONS.md

export interface Tone {
  exposure: number;
  curve: ToneCurve;
}
