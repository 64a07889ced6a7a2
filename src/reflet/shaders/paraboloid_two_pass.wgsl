#import view

// Programs: a dual paraboloid by texture matrices, as graphics systems without environment lookups draw it
// [Heidrich98, sec. 5; Heidrich00, eqs 9 to 12]. The reflected ray is found at the vertices, in eye space, and is their
// texture coordinate; a matrix and the division of perspective textures do the rest. Twin of
// reflet.envmap.paraboloid_matrices.
//
//   bind group 1   0 uniform Paraboloids, 176 bytes   1, 2 texture_2d<f32>: front, back; alpha marks what they may show
//                  3 filtering sampler, which clamps

struct Paraboloids {
  eye_from_world: mat3x3f,
  texture_matrices: array<mat4x4f, 2>,
}

@group(1) @binding(0) var<uniform> paraboloids: Paraboloids;
@group(1) @binding(1) var front_map: texture_2d<f32>;
@group(1) @binding(2) var back_map: texture_2d<f32>;
@group(1) @binding(3) var map_sampler: sampler;

struct Reflection {
  @builtin(position) position: vec4f,
  @location(0) r: vec3f,  // in eye space
}

@vertex
fn vertex_paraboloid(in: Vertex, @builtin(instance_index) instance: u32) -> Reflection {
  let world = placed(in, instance);
  let v = paraboloids.eye_from_world * normalize(view.eye - world.position);
  let n = paraboloids.eye_from_world * world.normal;
  return Reflection(view.clip_from_world * vec4f(world.position, 1.0), 2.0 * dot(n, v) * n - v);
}

// A texture as those systems show it: by its implicit derivatives, and with a border of alpha 0.
fn bordered(image: texture_2d<f32>, coordinate: vec4f) -> vec4f {
  let st = coordinate.xy / coordinate.w;
  let texel = textureSample(image, map_sampler, st);
  return vec4f(texel.rgb, select(0.0, texel.a, all(st == saturate(st))));
}

fn front_texel(r: vec3f) -> vec4f {
  return bordered(front_map, paraboloids.texture_matrices[0] * vec4f(r, 1.0));
}

fn back_texel(r: vec3f) -> vec4f {
  return bordered(back_map, paraboloids.texture_matrices[1] * vec4f(r, 1.0));
}

// glAlphaFunc(GL_EQUAL, 1): a filtered alpha may miss 1 by rounding.
const FULL = 0.9999;

@fragment
fn paraboloid_front(in: Reflection) -> @location(0) vec4f {
  let texel = front_texel(in.r);
  if (texel.a < FULL) {
    discard;
  }
  return vec4f(texel.rgb, 1.0);
}

@fragment
fn paraboloid_back(in: Reflection) -> @location(0) vec4f {
  let texel = back_texel(in.r);
  if (texel.a < FULL) {
    discard;
  }
  return vec4f(texel.rgb, 1.0);
}

// Both in one pass: over the back, which needs no marks, the front by its alpha [Heidrich00, sec. 2.3.2].
@fragment
fn paraboloid_blended(in: Reflection) -> @location(0) vec4f {
  let front = front_texel(in.r);
  return vec4f(mix(back_texel(in.r).rgb, front.rgb, front.a), 1.0);
}
