#import tone

// Program: one map laid flat, as in [Hakura01, Figure 5]: its faces from left to right, mip level 0 on top, each further level
// half as large below: its radiance, its alpha, or distances, nearer ones brighter. The sheet is two faces high. Draw three
// vertices.
//
//   bind group 0   0 uniform MapView, 48 bytes   1 texture_2d_array<f32>: the maps of one layer, an array layer for each face of each slot

struct MapView {
  origin: vec2f,     // pixel coordinates of the sheet's top left corner
  face_size: f32,    // pixels from top to bottom of a face at level 0
  exposure: f32,
  curve: u32,     // TONE_*
  slot: u32,
  level_count: u32,
  face_count: u32,
  shows: u32,        // SHOWS_*
}

const SHOWS_RADIANCE = 0u;
const SHOWS_ALPHA = 1u;
const SHOWS_DISTANCE = 2u;  // inverse distances, times `exposure`

@group(0) @binding(0) var<uniform> view: MapView;
@group(0) @binding(1) var maps: texture_2d_array<f32>;

const SHEET_MARGIN = 0.12;  // display value around the faces

// What shows through where a local map is transparent: a checkerboard of 8 pixels.
fn board(at: vec2f) -> f32 {
  let cell = vec2i(floor(at / 8.0));
  return select(0.25, 0.4, ((cell.x + cell.y) & 1) == 0);
}

@vertex
fn vertex_map_view(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn map_view(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let margin = vec4f(vec3f(SHEET_MARGIN), 1.0);
  let sheet = (position.xy - view.origin) / view.face_size;
  if (any(sheet < vec2f(0.0)) || sheet.y >= 2.0) {
    return margin;
  }
  // Level l covers the rows [2 - 2^(1-l), 2 - 2^-l).
  let level = min(u32(-log2(max(1.0 - 0.5 * sheet.y, 1e-6))), view.level_count - 1u);
  let shrink = exp2(f32(level));
  let on_row = vec2f(sheet.x, sheet.y - (2.0 - 2.0 / shrink)) * shrink;
  let size = max(textureDimensions(maps) >> vec2u(level), vec2u(1u));
  let in_faces = on_row.x * f32(size.y) / f32(size.x);
  let face = u32(in_faces);
  if (face >= view.face_count || on_row.y >= 1.0) {
    return margin;
  }
  let texel = min(vec2u(vec2f(fract(in_faces), on_row.y) * vec2f(size)), size - 1u);
  let value = textureLoad(maps, vec2i(texel), i32(view.slot * view.face_count + face), i32(level));
  if (view.shows == SHOWS_ALPHA) {
    return vec4f(vec3f(value.a), 1.0);
  }
  if (view.shows == SHOWS_DISTANCE) {
    return vec4f(tone_mapped(vec3f(value.r * view.exposure), TONE_LINEAR), 1.0);
  }
  // The board stands for a display value; compositing happens in display values, where it shows evenly.
  return vec4f(tone_mapped(value.rgb * view.exposure, view.curve) + (1.0 - value.a) * board(position.xy), 1.0);
}
