#import part
#import ggx_table
#import fresnel

// Rough surfaces: what they reflect, and where their lobe is looked up (CONVENTIONS.md, "Surfaces", "LOD").

const TRACED_ROUGHNESS = 0.2;  // rays of rougher surfaces are not traced; twin: reflet.scene.roughness
const WIDEST = 0.3662725290860476;  // the sine of 3/4 of the largest tilt, 0.5 rad

// Sine of the angle by which a rough surface's lookup is tilted for its LOD; 0 of a mirror. Twin: reflet.envmap.lod.lobe_spread.
// Drivers' asin and sin are too coarse: both are series here, good to 1e-6.
fn lobe_spread(roughness: f32) -> f32 {
  let alpha = roughness * roughness;
  let square = alpha * alpha;
  let x = min(sqrt(0.41421356 * square / max(1.0 - square, 1e-6)), WIDEST);
  let s = x * x;
  let tilt = 4.0 / 3.0 * x * (1.0 + s * (1.0 / 6.0 + s * (3.0 / 40.0 + s * (15.0 / 336.0 + s * (105.0 / 3456.0)))));
  let t = tilt * tilt;
  return tilt * (1.0 - t / 6.0 * (1.0 - t / 20.0 * (1.0 - t / 42.0)));
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

// The mirrored ray r as the lobe's peak leans from it towards the normal; r itself of mirrors, whose lean is 0.
fn leaning(r: vec3f, n: vec3f, lean: f32) -> vec3f {
  if (!ROUGH || lean == 0.0) {
    return r;
  }
  return normalize(r + lean * (n - r));
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
