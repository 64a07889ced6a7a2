#import map_lookup
#import whole_face

// Programs: a dual paraboloid filtered with a radially symmetric lobe by shift-invariant filters, every frame
// [Heidrich00, sec. 3.2.5] (reflet.reflectance.prefilter.plane_filter). Draw three vertices into a face, instance = face. Textures
// between the passes hold flux: radiance times the solid angle of a texel, and that in alpha, so that plain means and sums
// are weighted ones. A face has SIZE rows, and in these textures a border BORDER texels wide that shows the other face.
//
//   bind group 0   with_border      0 texture_2d_array<f32>: the map that comes, of parameterization KIND
//                  halved           1 texture_2d_array<f32>: the level above alone
//                  filtered         1 texture_2d_array<f32>: the level that is filtered, alone   2 uniform: the filter
//                  blended          3, 4 texture_2d_array<f32>: the filtered maps S and L, one level each

override KIND: u32 = DUAL_PARABOLOID;
override SIZE: f32 = 1.0;
override BORDER: f32 = 0.0;

const REACH = 3;

@group(0) @binding(0) var source: texture_2d_array<f32>;
@group(0) @binding(1) var finer: texture_2d_array<f32>;
@group(0) @binding(2) var<uniform> weights: array<vec4f, 13>;  // row by row
@group(0) @binding(3) var small: texture_2d_array<f32>;
@group(0) @binding(4) var large: texture_2d_array<f32>;

// With a border, over which the face goes on into the other hemisphere.
@fragment
fn with_border(in: Place) -> @location(0) vec4f {
  let uv = (in.position.xy - BORDER) / SIZE;
  let texel = 1.0 / SIZE;
  let d = map_direction(DUAL_PARABOLOID, in.face, uv);
  let right = map_direction(DUAL_PARABOLOID, in.face, uv + vec2f(texel, 0.0));
  let down = map_direction(DUAL_PARABOLOID, in.face, uv + vec2f(0.0, texel));
  let rows = f32(textureDimensions(source).y);
  let lod = map_lod(KIND, d, right, down, rows, 0.0, f32(textureNumLevels(source)) - 1.0);
  let p = 2.0 * uv - 1.0;
  let height = 1.0 + dot(p, p);
  let solid_angle = 1.0 / (height * height);  // up to a factor
  return solid_angle * vec4f(sample_map(KIND, source, 0, d, lod).rgb, 1.0);
}

// The next mip level.
@fragment
fn halved(in: Place) -> @location(0) vec4f {
  let texel = 2 * vec2i(in.position.xy);
  let face = i32(in.face);
  return 0.25 * (textureLoad(finer, texel, face, 0) + textureLoad(finer, texel + vec2i(1, 0), face, 0)
    + textureLoad(finer, texel + vec2i(0, 1), face, 0) + textureLoad(finer, texel + vec2i(1, 1), face, 0));
}

// Radiance, filtered. Where a filter reaches beyond the border, what is inside counts.
@fragment
fn filtered(in: Place) -> @location(0) vec4f {
  let middle = vec2i(in.position.xy);
  let extent = vec2i(textureDimensions(finer));
  var sum = vec4f(0.0);
  for (var row = -REACH; row <= REACH; row++) {
    for (var column = -REACH; column <= REACH; column++) {
      let k = (row + REACH) * (2 * REACH + 1) + column + REACH;
      let weight = weights[k >> 2u][k & 3];
      let texel = middle + vec2i(column, row);
      if (weight > 0.0 && all(texel >= vec2i(0)) && all(texel < extent)) {
        sum += weight * textureLoad(finer, texel, i32(in.face), 0);
      }
    }
  }
  return sum / sum.a;
}

// S in the middle, L at the rim.
@fragment
fn blended(in: Place) -> @location(0) vec4f {
  let p = 2.0 * in.position.xy / SIZE - 1.0;
  let place = in.position.xy + BORDER;
  return mix(stretched(small, place, in.face), stretched(large, place, in.face), min(dot(p, p), 1.0));
}

// A level, bilinear, at a place in texels of the finest.
fn stretched(level: texture_2d_array<f32>, place: vec2f, face: u32) -> vec4f {
  let extent = vec2i(textureDimensions(level));
  let at = place / (SIZE + 2.0 * BORDER) * vec2f(extent) - 0.5;
  let low = vec2i(floor(at));
  let share = at - floor(at);
  var rows: array<vec4f, 2>;
  for (var k = 0; k < 2; k++) {
    let left = clamp(low + vec2i(0, k), vec2i(0), extent - 1);
    let right = clamp(low + vec2i(1, k), vec2i(0), extent - 1);
    rows[k] = mix(textureLoad(level, left, i32(face), 0), textureLoad(level, right, i32(face), 0), share.x);
  }
  return mix(rows[0], rows[1], share.y);
}
