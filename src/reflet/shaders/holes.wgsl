#import surface

// Surfaces that are masked or blended: where there is nothing, or nothing of a sub-sample. Twin of `reflet.trace.light.holes`.

// A number in [0, 1) for each sub-sample of a pixel and triangle of the scene: what its alpha has to exceed to be seen there.
// Evenly spread over a pixel's sub-samples.
fn threshold(pixel: u32, sub_sample: u32, triangle: u32) -> f32 {
  var x = pixel * 747796405u + triangle * 2891336453u + 277803737u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  x = (x >> 22u) ^ x;
  return fract(f32(x >> 8u) * 0x1p-24 + f32(sub_sample) * 0.618034);
}

// Whether alpha says that something is there. Cutoffs below 0 stand for blending.
fn is_there(alpha: f32, cutoff: f32, at_random: f32) -> bool {
  return select(alpha >= cutoff, alpha > at_random, cutoff < 0.0);
}

// Whether a sub-sample at `position` of the picture goes through the part.
fn goes_through(s: Sample, position: vec4f, sub_sample: u32) -> bool {
  if (!part_is(PART_HOLES)) {
    return false;
  }
  var alpha = part.alpha * part_color(s.here).a;
  if (part_is(PART_BASE_COLOR_TEXTURE)) {
    alpha *= bilinear(base_color_texture, part_uv(0u, s.here), part_sampling(0u)).a;
  }
  let pixel = u32(position.y) * u32(frame.width) + u32(position.x);
  return !is_there(alpha, part.cutoff, threshold(pixel, sub_sample, s.bits >> 1u));
}
