#import frame

// Program: the HDR environment behind everything. Draw three vertices at depth 0 ("greater-equal", no depth writes) with
// bind group 0 alone, instance = sub-sample.

const PI = 3.14159265358979;

struct Backdrop {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) sub_sample: u32,
}

@vertex
fn vertex_backdrop(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32) -> Backdrop {
  let corner = vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0;  // one triangle over the whole picture
  return Backdrop(vec4f(corner, 0.0, 1.0), sub_sample);
}

fn latlong_uv(d: vec3f) -> vec2f {
  return vec2f(0.5 + atan2(d.z, d.x) / (2.0 * PI), acos(clamp(d.y, -1.0, 1.0)) / PI);
}

// Radiance of the environment along the view ray through pixel coordinates `at`.
fn environment_at(at: vec2f) -> vec4f {
  let d = normalize(view_ray(at));
  let right = length(normalize(view_ray(at + vec2f(1.0, 0.0))) - d);
  let down = length(normalize(view_ray(at + vec2f(0.0, 1.0))) - d);
  // A texel is pi/height high, everywhere; towards the poles it is narrower, but there is nothing to see in that.
  let rho = max(right, down) * f32(textureDimensions(environment).y) / PI;
  let lod = log2(max(rho, 1e-6)) + frame.texture_lod_bias;
  return vec4f(textureSampleLevel(environment, environment_sampler, latlong_uv(d), lod).rgb, 1.0);
}

@fragment
fn backdrop_single(in: Backdrop) -> @location(0) vec4f {
  return environment_at(floor(in.position.xy) + sub_sample_position(in.sub_sample));
}

@fragment
fn backdrop_multi(in: Backdrop, @builtin(sample_index) sub_sample: u32) -> @location(0) vec4f {
  return environment_at(floor(in.position.xy) + sub_sample_position(sub_sample));
}
