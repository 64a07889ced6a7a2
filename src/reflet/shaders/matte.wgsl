#import view

// Programs: matte and glowing surfaces under a `SkyLight`, in any view: through cameras, onto faces of cubes, onto
// paraboloids. Linear radiance, alpha 1.
//
//   bind group 1   0 uniform Matte, 96 bytes   1 base colour texture   2 its sampler   3 emission texture   4 its sampler

struct Matte {
  base_color: vec3f,
  double_sided: u32,
  emission: vec3f,
  padding: f32,
  sky: vec3f,      // of `SkyLight`, as its other members
  ground: vec3f,
  sun: vec3f,
  towards_sun: vec3f,
}

@group(1) @binding(0) var<uniform> matte: Matte;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;
@group(1) @binding(3) var emission_texture: texture_2d<f32>;
@group(1) @binding(4) var emission_sampler: sampler;

struct Surface {
  @builtin(position) position: vec4f,
  @location(0) normal: vec3f,
  @location(1) uv: vec2f,
}

@vertex
fn vertex_matte(in: Vertex, @builtin(instance_index) instance: u32) -> Surface {
  let world = placed(in, instance);
  return Surface(view.clip_from_world * vec4f(world.position, 1.0), world.normal, world.uv);
}

fn radiance(normal: vec3f, uv: vec2f, front_facing: bool) -> vec4f {
  let albedo = matte.base_color * textureSample(base_color_texture, base_color_sampler, uv).rgb;
  let emission = matte.emission * textureSample(emission_texture, emission_sampler, uv).rgb;
  let front = front_facing != (view.front_is_clockwise == 1u);
  if (!front && matte.double_sided == 0u) {
    return vec4f(0.0, 0.0, 0.0, 1.0);
  }
  let n = normalize(select(-normal, normal, front));
  let irradiance_over_pi = mix(matte.ground, matte.sky, 0.5 + 0.5 * n.y) + max(dot(n, matte.towards_sun), 0.0) * matte.sun;
  return vec4f(emission + albedo * irradiance_over_pi, 1.0);
}

@fragment
fn matte_plane(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
  return radiance(in.normal, in.uv, front);
}

// Onto a paraboloid: vertices fall where the map has their directions, edges between them stay straight. The larger the
// angle that an edge spans, seen from the eye, the farther it is from the arc that it should be.

struct ParaboloidSurface {
  @builtin(position) position: vec4f,
  @location(0) normal: vec3f,
  @location(1) uv: vec2f,
  @location(2) outward: f32,  // cosine of the angle to the middle of the face
}

// The corners of a face lie at radius sqrt(2), where outward is -1/3: so far the front's picture goes on into the back.
// What lies farther is left out, for around the pole at -1 a triangle would come out spread over the whole face.
const FARTHEST = -0.5;
const FARTHEST_VERTEX = -0.9;

@vertex
fn vertex_matte_paraboloid(in: Vertex, @builtin(instance_index) instance: u32) -> ParaboloidSurface {
  let world = placed(in, instance);
  let from_eye = (view.clip_from_world * vec4f(world.position, 1.0)).xyz;  // in the map's space
  let distance = length(from_eye);
  let d = from_eye / distance;
  let outward = select(-d.z, d.z, view.face == 0u);
  let position = vec4f(d.xy / (1.0 + max(outward, FARTHEST_VERTEX)), view.near / distance, 1.0);
  return ParaboloidSurface(position, world.normal, world.uv, outward);
}

@fragment
fn matte_paraboloid(in: ParaboloidSurface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
  let shown = radiance(in.normal, in.uv, front);
  if (in.outward < FARTHEST) {
    discard;
  }
  return shown;
}
