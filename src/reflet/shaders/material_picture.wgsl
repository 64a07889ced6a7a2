#import view
#import env_map
#import material
#import mirror
#import lookup
#import lobes

// Programs: meshes of an environment-mapped material, and env maps as their backdrop. Linear radiance; alpha is 1 on meshes, 0
// behind them. Reflection is found for every fragment, from interpolated position and normal.

struct Shaded {
  @builtin(position) position: vec4f,
  @location(0) p: vec3f,
  @location(1) normal: vec3f,
}

@vertex
fn vertex_material(in: Vertex, @builtin(instance_index) instance: u32) -> Shaded {
  let world = placed(in, instance);
  return Shaded(view.clip_from_world * vec4f(world.position, 1.0), world.position, world.normal);
}

// Whether backs are seen.
override DOUBLE_SIDED: bool = false;

// The unit view ray, and the unit normals of surface and triangle on the side that it comes from.
struct Met {
  ray: vec3f,
  n: vec3f,
  ng: vec3f,
}

// Takes derivatives.
fn met(in: Shaded) -> Met {
  let ray = normalize(in.p - view.eye);
  let across = cross(dpdx(in.p), dpdy(in.p));  // the triangle's own normal, up to sign
  let ng = normalize(select(across, -across, dot(across, ray) > 0.0));
  return Met(ray, normalize(select(in.normal, -in.normal, dot(in.normal, ng) < 0.0)), ng);
}

@fragment
fn material_mesh(in: Shaded, @builtin(front_facing) front: bool) -> @location(0) vec4f {
  let at = met(in);
  let ray = at.ray;
  let n = at.n;
  let r = mirrored(ray, n, at.ng);
  let n_dot_v = mirror_cosine(ray, r);
  let ggx = ggx_at(n_dot_v);
  // The hardware's derivatives are differences within a block of 2×2 pixels: drivers differ in which pixel's, and near a
  // triangle's edge the others' are extrapolated. That may move the LOD by a fraction of a level. A map whose levels are
  // filtered copies of each other hardly shows it; a PEM's are not, which is why its LOD has a rule of its own.
  var incident: vec4f;
  if (LOOKUP == LOOKUP_REFLECTION) {
    let along = lobe(r, n, ggx);
    let d = along.direction;
    incident = env_radiance_widened(d, d + dpdx(d), d + dpdy(d), along.widening);
  } else {
    let d = shown_direction(n, ray);
    let footprint = longest(dpdx(d), dpdy(d));
    if (LOOKUP == LOOKUP_NORMAL) {
      incident = env_radiance(d, d + footprint, d);
    } else {
      incident = map_radiance(d, d + footprint, d);
    }
  }
  return vec4f(select(vec3f(0.0), reflected(incident.rgb, n, n_dot_v, ggx), front || DOUBLE_SIDED), 1.0);
}

// A material given by its lobes. A normal that is interpolated away from the viewer is turned back until it grazes.
@fragment
fn material_lobes(in: Shaded, @builtin(front_facing) front: bool) -> @location(0) vec4f {
  let at = met(in);
  let n = normalize(at.n - max(dot(at.n, at.ray) + GRAZING, 0.0) * at.ray);
  return vec4f(select(vec3f(0.0), reflected_by_lobes(n, -at.ray), front || DOUBLE_SIDED), 1.0);
}

@vertex
fn vertex_backdrop(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return far_corner(vertex);
}

@fragment
fn material_backdrop(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let at = position.xy;
  let ray = view_ray(at);
  let radiance = env_radiance(ray, view_ray(at + vec2f(1.0, 0.0)), view_ray(at + vec2f(0.0, 1.0)));
  return vec4f(radiance.rgb, 0.0);
}
