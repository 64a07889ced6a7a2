#import exact
#import interpolated
#import shade
#import holes

// Entry points of the picture's programs. Linear radiance, coverage in alpha.

// Backs of single-sided faces are black. A part may be drawn at once, or its fronts by the pipelines below and its backs
// by these, which is faster. The vertex stage is vertex_single_place or vertex_multi_place.
fn back() -> vec4f {
  return vec4f(0.0, 0.0, 0.0, select(1.0, 0.0, switched_on(OBJECT_ONLY)));
}

@fragment
fn picture_single_back() -> @location(0) vec4f {
  return back();
}

@fragment
fn picture_multi_back() -> @location(0) vec4f {
  return back();
}

const LARGEST_HALF = 65504.0;

// Draws sub-sample `sub_sample` alone, into one sample a pixel.
@fragment
fn picture_single(in: Raster) -> @location(0) vec4f {
  let s = exact_sample(in, sub_sample_at(in.position, in.identity.z));
  if (goes_through(s, in.position, in.identity.z)) {
    discard;
  }
  set_chances(in.position, in.identity.z);
  return shade(s);
}

// Draws four sub-samples at once, into a half-float target of four samples a pixel.
@fragment
fn picture_multi(in: Raster, @builtin(sample_index) sub_sample: u32) -> @location(0) vec4f {
  let s = exact_sample(in, sub_sample_at(in.position, sub_sample));
  if (goes_through(s, in.position, sub_sample)) {
    discard;
  }
  set_chances(in.position, sub_sample);
  return min(shade(s), vec4f(LARGEST_HALF));
}

// The same on the fast path.
@fragment
fn picture_single_fast(in: Interpolated, @builtin(front_facing) front: bool) -> @location(0) vec4f {
  let s = interpolated_sample(in, front);
  if (goes_through(s, in.position, in.identity.z)) {
    discard;
  }
  set_chances(in.position, in.identity.z);
  return shade(s);
}

@fragment
fn picture_multi_fast(
  in: InterpolatedMulti, @builtin(front_facing) front: bool, @builtin(sample_index) sub_sample: u32
) -> @location(0) vec4f {
  let one = Interpolated(in.position, in.identity, in.b, in.p, in.normal, in.tangent, in.uv);
  let s = interpolated_sample(one, front);
  if (goes_through(s, in.position, sub_sample)) {
    discard;
  }
  set_chances(in.position, sub_sample);
  return min(shade(s), vec4f(LARGEST_HALF));
}
