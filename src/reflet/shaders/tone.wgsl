// From linear radiance to a display's sRGB values, written explicitly so that all targets show the same.

const TONE_EXPONENTIAL = 0u;  // 1 - exp(-radiance): the project's measure (CONVENTIONS.md)
const TONE_LINEAR = 1u;       // clamped at 1
const TONE_NEUTRAL = 2u;      // Khronos PBR Neutral: keeps base colours, compresses highlights

fn srgb_from_linear(x: vec3f) -> vec3f {
  let c = clamp(x, vec3f(0.0), vec3f(1.0));
  return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn pbr_neutral(radiance: vec3f) -> vec3f {
  let start = 0.8 - 0.04;
  let least = min(radiance.r, min(radiance.g, radiance.b));
  let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
  let colour = radiance - offset;
  let peak = max(colour.r, max(colour.g, colour.b));
  if (peak < start) {
    return colour;
  }
  let room = 1.0 - start;
  let new_peak = 1.0 - room * room / (peak + room - start);
  let white = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
  return mix(colour * (new_peak / peak), vec3f(new_peak), white);
}

// Display values of linear radiance that is already multiplied by the exposure.
fn tone_mapped(exposed: vec3f, curve: u32) -> vec3f {
  if (curve == TONE_LINEAR) {
    return srgb_from_linear(exposed);
  }
  if (curve == TONE_NEUTRAL) {
    return srgb_from_linear(pbr_neutral(exposed));
  }
  return srgb_from_linear(1.0 - exp(-exposed));
}
