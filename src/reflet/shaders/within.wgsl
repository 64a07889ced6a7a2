#import material_picture
#import relief

// Programs: meshes before an env map whose geometry is not infinitely far, and what lies behind them within it. Bind group 1 is that of
// `env_map` and these, in world space. The host's side is `reflet.render.maps.env_map_texture`.
//
//   binding  resource                     stages     contents
//   4        uniform Geometry, 48 bytes   fragment
//   5        texture_cube_array<f32>      fragment   a relief's inverse distances; for other geometries one texel

override GEOMETRY_KIND: f32 = 0.0;

@group(1) @binding(4) var<uniform> geometry: Geometry;
@group(1) @binding(5) var inverse_distances: texture_cube_array<f32>;

// Where a ray and those of the neighbouring pixels look the map up.
struct Lookups {
  d: vec3f,
  dx: vec3f,
  dy: vec3f,
}

// Of the unit ray r from p, where points and rays change by px and rx to the right, by py and ry down (twin of
// reflet.envmap.geometry.lookup_directions): a relief's neighbours are cut off where the ray itself meets it.
fn lookups(p: vec3f, px: vec3f, py: vec3f, r: vec3f, rx: vec3f, ry: vec3f) -> Lookups {
  if (GEOMETRY_KIND == RELIEF) {
    let w = inverse_hit(geometry, inverse_distances, 0, cube_sampler, p, r);
    let d = r + w * (p - geometry.origin.yzw);
    return Lookups(d, d + rx + w * px, d + ry + w * py);
  }
  return Lookups(
    lookup_direction(GEOMETRY_KIND, geometry, p, r),
    lookup_direction(GEOMETRY_KIND, geometry, p + px, r + rx),
    lookup_direction(GEOMETRY_KIND, geometry, p + py, r + ry));
}

// `material_mesh` of surfaces that mirror. What they diffuse comes from infinitely far: its map knows no places.
@fragment
fn material_mesh_within(in: Shaded, @builtin(front_facing) front: bool) -> @location(0) vec4f {
  let at = met(in);
  let bounced = mirrored(at.ray, at.n, at.ng);
  let n_dot_v = mirror_cosine(at.ray, bounced);
  let ggx = ggx_at(n_dot_v);
  let along = lobe(bounced, at.n, ggx);
  let r = along.direction;
  let to = lookups(in.p, dpdx(in.p), dpdy(in.p), r, dpdx(r), dpdy(r));
  let incident = env_radiance_widened(to.d, to.dx, to.dy, along.widening);
  return vec4f(select(vec3f(0.0), reflected(incident.rgb, at.n, n_dot_v, ggx), front || DOUBLE_SIDED), 1.0);
}

// What the eye sees of the geometry, as from inside it.
@fragment
fn material_backdrop_within(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let at = position.xy;
  let ray = normalize(view_ray(at));
  let right = normalize(view_ray(at + vec2f(1.0, 0.0))) - ray;
  let down = normalize(view_ray(at + vec2f(0.0, 1.0))) - ray;
  let to = lookups(view.eye, vec3f(0.0), vec3f(0.0), ray, right, down);
  return vec4f(env_radiance(to.d, to.dx, to.dy).rgb, 0.0);
}
