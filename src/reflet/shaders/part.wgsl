#import geometry
#import parameterization

// Bind group 1: one part, bound for its draw call. The host's side of this layout is `reflet.render.playback.layouts`.
//
//   binding  resource                                stages     contents
//   0        uniform Part, 416 bytes                 fragment   geometries of its maps, material
//   1        texture_2d<f32> rgba8unorm-srgb         fragment   base colour, with mip levels (1x1 white if none)
//   2        texture_2d<f32> rgba8unorm              fragment   roughness in green, metallic in blue (1x1 white if none)
//   3        texture_2d<f32> rgba8unorm              fragment   tangent-space normals (1x1 if none)
//   4        texture_2d<f32> rgba8unorm-srgb         fragment   emission, with mip levels (1x1 white if none)
//   5        filtering sampler                       fragment   base colour: linear, wrapping as its texture says
//   6        filtering sampler                       fragment   emission: linear, wrapping as its texture says
//   7        texture_cube_array<f32> rgba16float     fragment   distant cubes, a slot of shell_count cubes for each resident sample, and the base's
//   8        texture_cube_array<f32> rgba16float     fragment   local cubes, the same samples in the same slots (1 black texel if none)
//   9        filtering sampler                       fragment   cubes: linear in all three, clamping
//   10       texture_2d_array<f32> rgba16float       fragment   distant maps that are no cubes: each face of each of them a layer
//   11       texture_2d_array<f32> rgba16float       fragment   local maps that are no cubes
//   12       texture_cube_array<f32> r16float        fragment   reliefs of the shells (1 texel of 0 if none)
//   13       texture_2d_array<f32> rgba8unorm        fragment   see coat.wgsl (1 texel if none)
//
// Part's bytes: 0 distant[3], each: 0 geometry   48 size   52 max_lod   56 parameterization   192 local, likewise
//   256 base_color   268 metallic   272 emission   284 normal_scale   288 bits   292 shell_count   296 transmission
//   300 perceptual_roughness   304 absorption   316 index   320 sampling   324 extras   328 alpha   332 cutoff
//   336 dielectric_f0   348 dielectric_f90   352 coat   356 coat_roughness   360 coat_normal_scale   364 coat_sampling
//   368 coat_pictures[3]

struct Layer {
  geometry: Geometry,
  size: f32,              // rows of a face at level 0
  max_lod: f32,           // number of levels - 1
  parameterization: u32,  // its kind
}

const MOST_SHELLS = 3u;

struct Part {
  distant: array<Layer, MOST_SHELLS>,  // its shells, the nearest first
  local: Layer,
  base_color: vec3f,
  metallic: f32,
  emission: vec3f,
  normal_scale: f32,
  bits: u32,
  shell_count: u32,
  transmission: f32,  // of glass: the share of what is not reflected that goes through
  perceptual_roughness: f32,
  absorption: vec3f,  // of its inside, per metre
  index: f32,         // of refraction
  sampling: u32,      // a byte for each texture: how it wraps (see `bilinear`); from bit 4 on its set of texture coordinates
  extras: u32,        // where in `vertices` those of a vertex 0 would lie, see `surface`
  alpha: f32,
  cutoff: f32,        // of alpha, see `holes`
  dielectric_f0: vec3f,  // of what is no metal: reflectance at normal incidence, and along the surface
  dielectric_f90: f32,
  coat: f32,             // share of a clear coat
  coat_roughness: f32,   // perceptual
  coat_normal_scale: f32,
  coat_sampling: u32,    // as `sampling`: 0 its share, 1 its roughness, 2 its normals
  coat_pictures: array<vec4u, 3>,  // where these lie: column, row, layer, width + 65536 height; 0 where there is none
}

const PART_REFLECTIVE = 1u;
const PART_DOUBLE_SIDED = 2u;
const PART_HAS_LOCAL = 4u;
const PART_BASE_COLOR_TEXTURE = 8u;
const PART_METALLIC_ROUGHNESS_TEXTURE = 16u;
const PART_NORMAL_TEXTURE = 32u;
const PART_EMISSION_TEXTURE = 64u;
const PART_COLORS = 128u;         // its vertices have colours
const PART_MORE_UV = 256u;        // ... and further texture coordinates
const PART_HOLES = 512u;          // masked or blended
const PART_METAL = 1024u;         // metallic throughout, or glass that is clear throughout: no diffuse reflection
const PART_OFF_HULL = 2048u;      // no triangle of this draw call is on the hull: their bits need not be asked
const PART_UNLIT = 4096u;         // its base colour is its emission
const PART_REFRACTIVE = 8192u;    // glass
const PART_THIN = 16384u;         // glass without an inside
const PART_ROUGH = 32768u;        // reflects by a lobe, be it here and there
const PART_SURFACE = 65536u;      // its triangles have maps of surface_light.wgsl
const PART_COAT = 131072u;        // has a clear coat
const PART_COAT_TEXTURES = 262144u;  // ... and pictures of it
const PART_TEXTURES = 262264u;    // any

// Pipelines may be built for one setting of a part's bits and of how its textures are looked up, for its number of shells and
// for the kinds of its geometries and parameterizations, so that code which is off costs nothing; else they are read from the uniform.
override PART_BITS: u32 = 0xffffffffu;
override ANY_BITS: u32 = 0xffffffffu;  // all bits that any part has
override PART_SAMPLING: u32 = 0xffffffffu;
override SHELL_COUNT: u32 = 0xffffffffu;
override DISTANT_KIND_0: f32 = -1.0;
override DISTANT_KIND_1: f32 = -1.0;
override DISTANT_KIND_2: f32 = -1.0;
override LOCAL_KIND: f32 = -1.0;
override DISTANT_PARAMETERIZATION: u32 = 0xffffffffu;
override LOCAL_PARAMETERIZATION: u32 = 0xffffffffu;

@group(1) @binding(0) var<uniform> part: Part;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(3) var normal_texture: texture_2d<f32>;
@group(1) @binding(4) var emission_texture: texture_2d<f32>;
@group(1) @binding(5) var base_color_sampler: sampler;
@group(1) @binding(6) var emission_sampler: sampler;
@group(1) @binding(7) var distant_cubes: texture_cube_array<f32>;
@group(1) @binding(8) var local_cubes: texture_cube_array<f32>;
@group(1) @binding(9) var cube_sampler: sampler;
@group(1) @binding(10) var distant_maps: texture_2d_array<f32>;
@group(1) @binding(11) var local_maps: texture_2d_array<f32>;
@group(1) @binding(12) var reliefs: texture_cube_array<f32>;

// Whether any part may have it.
fn any_is(bit: u32) -> bool {
  return (ANY_BITS & bit) != 0u;
}

fn part_is(bit: u32) -> bool {
  return any_is(bit) && (select(PART_BITS, part.bits, PART_BITS == 0xffffffffu) & bit) != 0u;
}

// A texture's byte of `sampling`: 0 base colour, 1 metallic-roughness, 2 normals, 3 emission.
fn part_sampling(which: u32) -> u32 {
  return (select(PART_SAMPLING, part.sampling, PART_SAMPLING == 0xffffffffu) >> (8u * which)) & 255u;
}
