// Bind group 0: what a whole frame shares. The host's side of this layout is `reflet.render.playback.layouts`.
//
//   binding  resource                         stages             contents
//   0        uniform Frame, 1856 bytes        vertex, fragment   camera, sub-sample table, blended samples, switches
//   1        storage array<vec4f>, read       vertex, fragment   vertices, 3 vec4f each: (position, u) (normal, v) (tangent);
//                                                                      behind them what some have besides, see `surface`
//   2        storage array<vec4u>, read       vertex, fragment   triangles by part: three vertex numbers, bits
//   3        storage array<vec2u>, read       fragment           mesh colours of each triangle: (resolution, offset); where there
//                                                                      are surface_maps theirs follow, then the sites of two samples each
//   4        storage array<f32>, read         fragment           irradiance/pi of all mesh-colour samples, 3 floats each; where
//                                                                      any part has a normal texture their gradients follow
//   5        texture_2d<f32> rgba16float      fragment           the HDR environment, lat-long, with mip levels (1x1 if none)
//   6        filtering sampler                fragment           linear in all three; repeats in u, clamps in v
//   7 to 10  what mirrored rays meet            fragment           see bvh.wgsl and traced.wgsl
//   11       texture_2d<f32> rgba16float      fragment           that of ggx_table.wgsl (1x1 where no part is rough)
//   12       texture_2d_array<f32> rgba16float  fragment         see surface_light.wgsl (1 texel if none)
//   13       storage array<vec4u>, read       fragment           see highlights.wgsl
//
// Tangents have glTF's handedness in w. Frame's bytes (offset: member):
//   0 clip_from_world (columns)   64 eye   76 lod_bias   80 ray_corner   92 texture_lod_bias   96 ray_dx   108 width
//   112 ray_dy   124 height   128 sub_samples[64] (x, y, 0, 0)   1152 blend[9] (weight, slot, 0, 0)   1296 blend_count
//   1300 switches   1304 zero   1312 eye_rest   1328 pixel_x   1344 pixel_y   1360 depth   1376 pixel_x_rest
//   1392 pixel_y_rest   1408 depth_rest; a *_rest is what float32 rounds off its namesake   1424 map_from_world[9] (columns)

struct Frame {
  clip_from_world: mat4x4f,       // reversed depth, infinite far plane: 1 near, 0 infinitely far; drawn with "greater"
  eye: vec3f,
  lod_bias: f32,                  // added to the LOD of env maps
  ray_corner: vec3f,              // the ray through pixel coordinates (x, y) is ray_corner + x ray_dx + y ray_dy
  texture_lod_bias: f32,          // added to the LOD of picture textures: -log2(sub-samples a pixel)/2
  ray_dx: vec3f,
  width: f32,                     // of the picture in pixels
  ray_dy: vec3f,
  height: f32,
  sub_samples: array<vec4f, 64>,  // see sub_sample_position
  blend: array<vec4f, 9>,         // blended samples of the parameter space: weight, slot in the arrays of maps; then BASE_MAP
  blend_count: u32,
  switches: u32,                  // SHOW_*, OBJECT_ONLY, HIDE_SHELL and BY_ORIGIN bits
  zero: u32,                      // always 0, see precise.wgsl
  eye_rest: vec3f,
  pixel_x: vec3f,                 // a point v from the eye lies at depth z = depth·v and pixel (pixel_x·v, pixel_y·v)/z:
  pixel_y: vec3f,                 // the rows of the inverse of the matrix with columns ray_dx, ray_dy, ray_corner
  depth: vec3f,
  pixel_x_rest: vec3f,
  pixel_y_rest: vec3f,
  depth_rest: vec3f,
  map_from_world: array<mat3x3f, 9>,  // of blended samples and the base: into the frames of their view-dependent maps
}

const SHOW_DIFFUSE = 1u;
const SHOW_FRESNEL = 2u;
const SHOW_DISTANT = 4u;
const SHOW_LOCAL = 8u;
const OBJECT_ONLY = 16u;          // only fronts of reflective parts have radiance and coverage; the rest hides, unseen

const HIDE_SHELL = 32u;           // the nearest; the bits of those behind it follow

const BY_ORIGIN = 256u;           // mirrored light in the colour of where it comes from, as bright as it is

const BASE_MAP = 8u;              // the maps that serve every viewpoint, in `blend`: their share of the distant light, their slot

const TRIANGLE_ON_HULL = 1u;      // the triangle's number in the scene follows from bit 1 on

// Pipelines may be built for one setting of the switches, one number of blended samples, and for frames that show nothing
// of the base (0), something (1) or it alone (2), so that code which is off costs nothing and loops are unrolled; else they
// are read from the uniform.
override SWITCHES: u32 = 0xffffffffu;
override BLEND_COUNT: u32 = 0xffffffffu;
override BASE: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> vertices: array<vec4f>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4u>;
@group(0) @binding(3) var<storage, read> colour_grids: array<vec2u>;
@group(0) @binding(4) var<storage, read> radiosity: array<f32>;
@group(0) @binding(5) var environment: texture_2d<f32>;
@group(0) @binding(6) var environment_sampler: sampler;
@group(0) @binding(11) var ggx_table: texture_2d<f32>;
@group(0) @binding(12) var surface_maps: texture_2d_array<f32>;

// Of a sub-sample from its pixel's top left corner, in pixels. After 64 the pattern repeats, moved by half a pixel diagonally,
// then across, then down (reflet.scene.views.sample_pattern).
fn sub_sample_position(k: u32) -> vec2f {
  let turn = k >> 6u;
  let moved = vec2f(select(0.0, 0.5, turn == 1u || turn == 2u), select(0.0, 0.5, turn == 1u || turn == 3u));
  return fract(frame.sub_samples[k & 63u].xy + moved);
}

fn switched_on(bit: u32) -> bool {
  return (select(SWITCHES, frame.switches, SWITCHES == 0xffffffffu) & bit) != 0u;
}

// The view ray (not of unit length) through pixel coordinates `at`.
fn view_ray(at: vec2f) -> vec3f {
  return frame.ray_corner + at.x * frame.ray_dx + at.y * frame.ray_dy;
}

fn blend_count() -> u32 {
  return select(BLEND_COUNT, frame.blend_count, BLEND_COUNT == 0xffffffffu);
}

// Whether the base brings any of the distant light, and whether samples do.
fn base_shown() -> bool {
  return select(BASE > 0u, frame.blend[BASE_MAP].x > 0.0, BASE == 0xffffffffu);
}

fn samples_shown() -> bool {
  return select(BASE < 2u, frame.blend[BASE_MAP].x < 1.0, BASE == 0xffffffffu);
}
