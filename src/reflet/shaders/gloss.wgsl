#import part
#import ggx_table
#import fresnel
#import mirror

// Rough surfaces: what they reflect, and where their lobe is looked up (CONVENTIONS.md, "Surfaces", "LOD").

const TRACED_ROUGHNESS = 0.2;  // rays of rougher surfaces are not traced; twin: reflet.scene.roughness
const WIDEST = 0.6816387600233341;  // the sine of 3/4 of the largest tilt, 1 rad
// sin(p asin x) = x Σ c_k x²ᵏ with c_0 = p, c_k = c_(k-1) ((2k - 1)² - p²)/(2k (2k + 1)), p = 4/3: good to 1e-7 up to WIDEST.
const TILT = array<f32, 14>(
  1.3333333, -0.17283951, -0.062414266, -0.034509475, -0.022633529, -0.016300713, -0.012457739, -0.0099200514, -0.008141088,
  -0.0068371385, -0.0058477431, -0.0050760054, -0.0044603047, -0.0039597735);

// Sine of the angle by which a rough surface's lookup is tilted for its LOD; 0 of a mirror. Twin: reflet.envmap.lod.lobe_spread.
// Drivers' asin and sin are too coarse.
fn lobe_spread(roughness: f32) -> f32 {
  let alpha = roughness * roughness;
  let square = alpha * alpha;
  let x = min(sqrt(0.41421356 * square / max(1.0 - square, 1e-6)), WIDEST);
  var sum = 0.0;
  for (var k = 13; k >= 0; k--) {
    sum = sum * x * x + TILT[k];
  }
  return sum * x;
}

// Of a lobe that is seen in another.
fn wider(spread: f32, by: f32) -> f32 {
  return min(sqrt(spread * spread + by * by), lobe_spread(1.0));
}

// A unit ray at an angle from the unit vector r, whose sine is `spread`; `across` says in which of two directions.
fn tilted(r: vec3f, spread: f32, across: bool) -> vec3f {
  let t = normalize(select(vec3f(0.0, r.z, -r.y), vec3f(-r.z, 0.0, r.x), abs(r.y) < 0.9));
  return sqrt(1.0 - spread * spread) * r + spread * select(t, cross(r, t), across);
}

// Numbers in [0, 1) of a sub-sample, evenly spread over those of its pixel, by which rays are drawn from lobes. 0 where a picture
// has too few sub-samples for that: it follows their peaks.
var<private> chances: vec3f = vec3f(0.0);

const MANY = -1.99;  // the LOD bias of textures in pictures of 16 samples or more

fn set_chances(position: vec4f, sub_sample: u32) {
  if (!any_is(PART_ROUGH) || frame.texture_lod_bias > MANY) {
    return;
  }
  let pixel = u32(position.y) * u32(frame.width) + u32(position.x);
  var x = pixel * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  x = (x >> 22u) ^ x;
  let bits = vec3u(x, x * 2654435769u, x * 2246822519u);
  // powers of 1/φ, φ⁴ = φ + 1
  let spread = f32(sub_sample) * vec3f(0.81917251, 0.67104361, 0.54970048);
  chances = fract(vec3f(bits >> vec3u(8u)) * 0x1p-24 + spread);
}

// What turns the unit vector r into a ray of the lobe about it that is as wide as `spread` says: half vectors of n = v = r with
// tan² θ = α² u/(1 - u), α² of the spread's arc taken for its sine.
fn drawn_offset(r: vec3f, spread: f32) -> vec3f {
  let x = 0.75 * spread;
  let squared_tangent = x * x / (0.41421356 + x * x) * chances.x / (1.0 - chances.x);
  let squared_cosine = 1.0 / (1.0 + squared_tangent);
  let sine = 2.0 * sqrt(squared_tangent) * squared_cosine;
  let t = normalize(select(vec3f(0.0, r.z, -r.y), vec3f(-r.z, 0.0, r.x), abs(r.y) < 0.9));
  let turn = 6.2831853 * chances.y;
  return (2.0 * squared_cosine - 2.0) * r + sine * (cos(turn) * t + sin(turn) * cross(r, t));
}

// `ray` mirrored at n as the lobe's peak leans from there towards the normal of the two; without that of mirrors, whose lean is 0.
fn leaning(ray: vec3f, n: vec3f, ng: vec3f, lean: f32) -> vec3f {
  let r = mirrored(ray, n, ng);
  if (!any_is(PART_ROUGH) || lean == 0.0) {
    return r;
  }
  return normalize(r + lean * (normalize(r - ray) - r));
}

// Share of the light about its mirrored ray that a surface reflects. `dielectric` is f0 and f90 of what is no metal, `ggx` of the
// table, `rough` where it is no mirror.
fn reflectance(
  base_color: vec3f, metallic: f32, dielectric: vec4f, n_dot_v: f32, rough: bool, ggx: vec4f
) -> vec3f {
  if (rough) {
    return mix(specular_albedo(dielectric.rgb, dielectric.a, ggx), specular_albedo(base_color, 1.0, ggx), metallic);
  }
  return fresnel_schlick(mix(dielectric.rgb, base_color, metallic), mix(dielectric.a, 1.0, metallic), n_dot_v);
}

// Share of the light that it scatters diffusely.
fn diffuse_share(base_color: vec3f, metallic: f32, dielectric: vec4f, rough: bool, ggx: vec4f) -> vec3f {
  let share = base_color * (1.0 - metallic);
  if (rough) {
    return share * (1.0 - specular_albedo(dielectric.rgb, dielectric.a, ggx));
  }
  return share;
}
