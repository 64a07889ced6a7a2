#import gloss
#import mirror
#import mesh_colours

// What rough surfaces show of lights without extent; mirrors show none of them. The host's side is
// `reflet.render.playback.punctual_lights`.
//
//   13  storage array<vec4u>, read   (number of lights, 0, 0, 0), then each light's three vec4f, then, a byte each, the share of
//                                    every light that is seen from every sample of mesh colours: all lights of the first come first
//
// A light's floats: intensity and 1/range; position and 1, or the direction towards it and 0; scale·axis and offset of its cone.

@group(0) @binding(13) var<storage, read> lights: array<vec4u>;

override LIGHT_COUNT: u32 = 0xffffffffu;

const LEAST_ROUGHNESS = 0.03;    // smoother surfaces are mirrors; twin: reflet.scene.roughness
const BRIGHTEST = 60000.0;       // that half floats hold

fn light_count() -> u32 {
  return select(LIGHT_COUNT, lights[0].x, LIGHT_COUNT == 0xffffffffu);
}

fn light_row(light: u32, row: u32) -> vec4f {
  return bitcast<vec4f>(lights[1u + 3u * light + row]);
}

fn light_seen(light: u32, sample: u32) -> f32 {
  let byte = sample * light_count() + light;
  let words = lights[1u + 3u * light_count() + byte / 16u];
  return f32((words[(byte / 4u) % 4u] >> (8u * (byte % 4u))) & 255u) / 255.0;
}

// A surface where a ray along the unit vector `ray` meets it; n is its shading normal and ng its geometric one, facing the ray.
struct Shiny {
  p: vec3f,
  ray: vec3f,
  n: vec3f,
  ng: vec3f,
  base_color: vec3f,
  metallic: f32,
  dielectric: vec4f,  // f0 and f90
  roughness: f32,
  ggx: vec4f,         // of the table
  triangle: u32,      // drawn number
  b: vec2f,           // barycentric coordinates, of the second and third corner
  back: bool,
}

// Radiance sent back along the ray. Twin: reflet.trace.light.punctual.
fn highlights(s: Shiny) -> vec3f {
  let grid = colour_grids[s.triangle];
  if (!any_is(PART_ROUGH) || light_count() == 0u || s.roughness < LEAST_ROUGHNESS || grid.x == 0u) {
    return vec3f(0.0);
  }
  let cell = cell_at(grid, s.b, s.back);
  let bent = dot(s.ray - 2.0 * dot(s.ray, s.n) * s.n, s.ng) < GRAZING;
  let n = select(s.n, normalize(mirrored(s.ray, s.n, s.ng) - s.ray), bent);
  let alpha = s.roughness * s.roughness;
  let square = alpha * alpha;
  let n_dot_v = clamp(-dot(s.ray, n), 1e-5, 1.0);
  let lost = 1.0 / (s.ggx.x + s.ggx.y) - 1.0;
  let paint = 1.0 + s.dielectric.rgb * lost;
  let metal = 1.0 + s.base_color * lost;
  let f0 = mix(s.dielectric.rgb * paint, s.base_color * metal, s.metallic);
  let f90 = mix(s.dielectric.a * paint, metal, s.metallic);
  var sum = vec3f(0.0);
  for (var k = 0u; k < light_count(); k++) {
    let place = light_row(k, 1u);
    let away = place.xyz - place.w * s.p;
    let distance = max(length(away), 1e-9);
    let l = away / distance;
    let n_dot_l = dot(n, l);
    if (n_dot_l <= 0.0 || dot(s.ng, l) <= 0.0) {
      continue;
    }
    let intensity = light_row(k, 0u);
    let cone_row = light_row(k, 2u);
    let cone = clamp(dot(cone_row.xyz, l) + cone_row.w, 0.0, 1.0);
    let near = distance * intensity.w;
    let fades = cone * cone * select(1.0, max(1.0 - near * near * near * near, 0.0) / (distance * distance), place.w > 0.5);
    let h = normalize(l - s.ray);
    let off = cross(n, h);  // 1 - (n·h)² would round
    let n_dot_h = dot(n, h);
    let spread = dot(off, off) + square * n_dot_h * n_dot_h;
    let d = square / max(3.14159265 * spread * spread, 1e-30);
    let masking = n_dot_l * sqrt(square + (1.0 - square) * n_dot_v * n_dot_v);
    let shadowing = n_dot_v * sqrt(square + (1.0 - square) * n_dot_l * n_dot_l);
    let grazing = 1.0 - clamp(-dot(s.ray, h), 0.0, 1.0);
    let grazing_2 = grazing * grazing;
    let f = f0 + (f90 - f0) * (grazing_2 * grazing_2 * grazing);
    let seen = dot(
      cell.weight, vec3f(light_seen(k, cell.sample.x), light_seen(k, cell.sample.y), light_seen(k, cell.sample.z)));
    sum += f * (d * 0.5 / max(masking + shadowing, 1e-12) * n_dot_l * fades * seen) * intensity.rgb;
  }
  return min(sum, vec3f(BRIGHTEST));
}
