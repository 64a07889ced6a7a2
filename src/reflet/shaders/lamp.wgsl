#import parameterization
#import whole_face

// Programs: a cube with a lamp in it (twin of reflet.envmap.lamp), level by level, from its levels without. Alpha is the
// lamp's share of a texel: coarser levels take the mean of that, and what else there is stays what it was. Draw three
// vertices into a face, instance = face.
//
//   bind group 0   0 texture_2d_array<f32>: this level without, alone   2 uniform Lamp
//                  coarser   1 texture_2d_array<f32>: the level above with the lamp, alone

override SIZE: f32 = 1.0;  // rows of what is drawn

const POINTS = 4;  // of a texel, an axis, that the lamp's edge is found at

struct Lamp {
  direction: vec3f,  // unit
  square_chord: f32,  // between the disc's middle and its rim
  radiance: vec3f,
}

@group(0) @binding(0) var alone: texture_2d_array<f32>;
@group(0) @binding(1) var finer: texture_2d_array<f32>;
@group(0) @binding(2) var<uniform> lamp: Lamp;

fn lit(in: Place, share: f32) -> vec4f {
  let texel = textureLoad(alone, vec2i(in.position.xy), i32(in.face), 0).rgb;
  let sum = min(vec4f(texel + share * lamp.radiance, share), vec4f(65504.0));
  // To the nearest half float: some drivers cut off what they store.
  return bitcast<vec4f>((bitcast<vec4u>(sum) + 0x1000u) & vec4u(0xffffe000u));
}

@fragment
fn finest(in: Place) -> @location(0) vec4f {
  var share = 0.0;
  for (var k = 0; k < POINTS * POINTS; k++) {
    let point = (vec2f(vec2i(k % POINTS, k / POINTS)) + 0.5) / f32(POINTS) - 0.5;
    let apart = map_direction(CUBE, in.face, (in.position.xy + point) / SIZE) - lamp.direction;
    share += smoothstep(0.0, 1.0, 1.5 - dot(apart, apart) / lamp.square_chord);
  }
  return lit(in, share / f32(POINTS * POINTS));
}

@fragment
fn coarser(in: Place) -> @location(0) vec4f {
  var sum = vec2f(0.0);
  for (var k = 0; k < 4; k++) {
    let texel = 2 * vec2i(in.position.xy) + vec2i(k & 1, k >> 1u);
    let d = map_direction(CUBE, in.face, (vec2f(texel) + 0.5) / (2.0 * SIZE));
    sum += vec2f(textureLoad(finer, texel, i32(in.face), 0).a, 1.0) / sampling_rate(CUBE, d);
  }
  return lit(in, sum.x / sum.y);
}
