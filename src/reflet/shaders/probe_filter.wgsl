#import parameterization
#import whole_face

// Programs: a cube filtered with radially symmetric lobes, every frame, by few taps a texel from a smooth pyramid
// (reflet.reflectance.lobes.lobe_taps, which says what the taps are). The pyramid is a cube whose texels stand at equal angles on
// each face: nearly of one size, so that one lobe serves everywhere. It holds radiance, and in alpha the solid angle that
// it stands for: the product is flux, of which none is lost or made on the way to coarser levels. Draw three vertices into
// a face, instance = face. What is filtered may be maps of any parameterization, one after the other: a map for each lobe.
//
//   bind group 0   first_level, mirrored   0 texture_cube<f32>: the cube that comes   1 filtering sampler
//                  next_level    2 texture_2d_array<f32>: the level above alone
//                  prefiltered   0 texture_cube<f32>: the pyramid   1 filtering sampler   3 storage: Lobes
//                  coarser_map   2 texture_2d_array<f32>: the level above alone of maps that are filtered
//                  diffuse       2 texture_2d_array<f32>: a level of the pyramid alone, of MOST_ROWS rows at most

override SIZE: f32 = 1.0;  // rows of what is drawn
override KIND: u32 = CUBE;  // and its parameterization: of maps that are filtered

const MOST_TAPS = 64;
const MOST_ROWS = 16;

struct Tap {
  direction: vec3f,  // around +z
  lod: f32,  // in a face's middle
  weight: vec3f,  // of red, green and blue
}

struct Lobe {
  reflected: vec3f,  // ∫ k dω
  count: u32,
  taps: array<Tap, MOST_TAPS>,
}

@group(0) @binding(0) var cube: texture_cube<f32>;
@group(0) @binding(1) var cube_sampler: sampler;
@group(0) @binding(2) var finer: texture_2d_array<f32>;
@group(0) @binding(3) var<storage, read> lobes: array<Lobe>;

// To the nearest half float: some drivers cut off what they store, which would darken level after level.
fn rounded(value: vec4f) -> vec4f {
  let bits = (bitcast<vec4u>(clamp(value, vec4f(0.0), vec4f(65504.0))) + 0x1000u) & vec4u(0xffffe000u);
  return bitcast<vec4f>(bits);
}

// Flux, and solid angle in alpha, of radiance and solid angle; and back.
fn flux(texel: vec4f) -> vec4f {
  return texel.a * vec4f(texel.rgb, 1.0);
}

fn mean(sum: vec4f) -> vec4f {
  return rounded(vec4f(sum.rgb / sum.a, sum.a));
}

// Solid angle of a texel of the pyramid around (s, t) of a face, as a share of that in its middle.
fn solid_angle(st: vec2f) -> f32 {
  let square = 1.0 + dot(st, st);
  return (1.0 + st.x * st.x) * (1.0 + st.y * st.y) * inverseSqrt(square) / square;
}

// What comes, in texels of the pyramid: the mean of nine lookups. Those at the edges are 1.6 times as wide as a cube's: with
// two in a row the light of a sun as small as a texel would depend on its place by a tenth, with three by some hundredths.
@fragment
fn first_level(in: Place) -> @location(0) vec4f {
  let lod = max(log2(f32(textureDimensions(cube).y) / SIZE), 0.0);
  var sum = vec4f(0.0);
  for (var k = 0; k < 9; k++) {
    let place = in.position.xy + (vec2f(vec2i(k % 3, k / 3)) - 1.0) / 3.0;
    let st = tan(0.25 * MAP_PI * (2.0 * place / SIZE - 1.0));
    let d = from_cube_face(in.face, vec3f(st, 1.0));
    sum += solid_angle(st) / 9.0 * vec4f(textureSampleLevel(cube, cube_sampler, d, lod).rgb, 1.0);
  }
  return mean(sum);
}

// The next level: 1 3 3 1, the refinement of quadratic B-splines, on both axes and over the faces' edges. Each texel is
// shared out among the four nearest of the coarser level; a corner's keeps the share of the neighbour that it lacks.
@fragment
fn next_level(in: Place) -> @location(0) vec4f {
  let size = i32(textureDimensions(finer).y);
  let corner = 2 * vec2i(in.position.xy) - 1;
  var sum = vec4f(0.0);
  for (var row = 0; row < 4; row++) {
    for (var column = 0; column < 4; column++) {
      let texel = corner + vec2i(column, row);
      let at = across_seams(CUBE, i32(in.face), texel, size);
      let share = vec2f(select(1.0, 3.0, column == 1 || column == 2), select(1.0, 3.0, row == 1 || row == 2)) / 8.0;
      sum += share.x * share.y * flux(textureLoad(finer, at.xy, select(at.z, i32(in.face), at.z < 0), 0));
    }
  }
  return mean(sum);
}

// Level 0 of what is filtered: what comes.
@fragment
fn mirrored(in: Place) -> @location(0) vec4f {
  let lod = max(log2(f32(textureDimensions(cube).y) / SIZE), 0.0);
  let d = map_direction(CUBE, in.face, in.position.xy / SIZE);
  return rounded(textureSampleLevel(cube, cube_sampler, d, lod));
}

// The mean of taps around the texel's direction, times what the lobe reflects.
@fragment
fn prefiltered(in: Place) -> @location(0) vec4f {
  let faces = u32(face_count(KIND));
  let k = in.face / faces;
  let r = map_direction(KIND, in.face % faces, in.position.xy / SIZE);
  let across = from_cube_face(cube_face(r), vec3f(1.0, 0.0, 0.0));
  let right = normalize(across - dot(across, r) * r);
  let down = cross(r, right);
  var sum = vec3f(0.0);
  var total = vec3f(0.0);
  for (var t = 0u; t < lobes[k].count; t++) {
    let tap = lobes[k].taps[t];
    let d = tap.direction.x * right + tap.direction.y * down + tap.direction.z * r;
    let face = cube_face(d);
    let q = in_cube_face(face, d);
    let st = q.xy / q.z;
    let place = from_cube_face(face, vec3f(4.0 / MAP_PI * atan(st), 1.0));
    let light = flux(textureSampleLevel(cube, cube_sampler, place, tap.lod));
    let weight = tap.weight / solid_angle(st);
    sum += weight * light.rgb;
    total += weight * light.a;
  }
  return rounded(vec4f(lobes[k].reflected * sum / max(total, vec3f(1e-20)), 1.0));
}

// The next mip level of maps that are filtered: means by the solid angles of texels.
@fragment
fn coarser_map(in: Place) -> @location(0) vec4f {
  let faces = u32(face_count(KIND));
  let extent = vec2f(textureDimensions(finer));
  var sum = vec4f(0.0);
  for (var k = 0; k < 4; k++) {
    let texel = 2 * vec2i(in.position.xy) + vec2i(k & 1, k >> 1u);
    let d = map_direction(KIND, in.face % faces, (vec2f(texel) + 0.5) / extent);
    sum += vec4f(textureLoad(finer, texel, i32(in.face), 0).rgb, 1.0) / sampling_rate(KIND, d);
  }
  return rounded(vec4f(sum.rgb / sum.a, 1.0));
}

// Irradiance/π by the normal: the sum over a level, each texel's light times the cosine at its centre.
@fragment
fn diffuse(in: Place) -> @location(0) vec4f {
  let normal = map_direction(CUBE, in.face, in.position.xy / SIZE);
  let rows = min(i32(textureDimensions(finer).y), MOST_ROWS);
  var place: array<f32, MOST_ROWS>;
  for (var k = 0; k < rows; k++) {
    place[k] = tan(0.25 * MAP_PI * ((2.0 * f32(k) + 1.0) / f32(rows) - 1.0));
  }
  var sum = vec4f(0.0);
  for (var face = 0; face < 6; face++) {
    let n = in_cube_face(u32(face), normal);
    for (var row = 0; row < rows; row++) {
      for (var column = 0; column < rows; column++) {
        let d = vec3f(place[column], place[row], 1.0);
        let height = dot(n, d);
        if (height > 0.0) {
          sum += height * inverseSqrt(dot(d, d)) * flux(textureLoad(finer, vec2i(column, row), face, 0));
        }
      }
    }
  }
  return vec4f(mean(sum).rgb, 1.0);
}
