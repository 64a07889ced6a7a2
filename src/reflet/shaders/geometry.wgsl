// Geometries: where the mirrored ray meets the shape that stands for the environment (twin of reflet.envmap.shapes).

// The twelve floats of `reflet.envmap.geometry.pack`.
struct Geometry {
  kind_a: vec4f,   // kind, then the box's lower corner or the centre
  floor_b: vec4f,  // the floor's height or a relief's limit, then the box's upper corner or the radii
  origin: vec4f,   // 0, then the env map's origin
}

const INFINITE_SPHERE = 0.0;
const SPHERE = 1.0;
const ELLIPSOID = 2.0;
const BOX = 3.0;
const HEMISPHERE = 4.0;
const RELIEF = 5.0;

const SMALL_COMPONENT = 1e-12;  // direction components below this are taken as this: keeps slabs finite

const LEAST_HALF_CHORD = 0.1;       // of rays that graze or miss an ellipsoid, in radii: keeps the root well-conditioned

// Distance from p along r to where the ray leaves the ellipsoid; q and v are p and r in its unit sphere.
fn leave_unit_sphere(q: vec3f, v: vec3f) -> f32 {
  let a = dot(v, v);
  let b = dot(q, v);
  let c = dot(q, q) - 1.0;
  return max((sqrt(max(b * b - a * c, LEAST_HALF_CHORD * LEAST_HALF_CHORD * a)) - b) / a, 0.0);
}

// A ray's direction with no component too small for slabs.
fn finite_slopes(r: vec3f) -> vec3f {
  return select(r, vec3f(SMALL_COMPONENT), abs(r) < vec3f(SMALL_COMPONENT));
}

// Distance from p along r, of finite slopes, to where the ray leaves the box.
fn box_exit(g: Geometry, p: vec3f, r: vec3f) -> f32 {
  let t = max((g.kind_a.yzw - p) / r, (g.floor_b.yzw - p) / r);
  return min(t.x, min(t.y, t.z));
}

// The direction (not of unit length) in which the mirrored unit ray r at point p samples the map of a shape of this kind; for
// RELIEF, which is none, see relief.wgsl.
fn lookup_direction(kind: f32, g: Geometry, p: vec3f, r: vec3f) -> vec3f {
  let a = g.kind_a.yzw;
  let b = g.floor_b.yzw;
  let origin = g.origin.yzw;
  if (kind == INFINITE_SPHERE) {
    return r;
  }
  if (kind == BOX) {
    let safe = finite_slopes(r);
    return p + box_exit(g, p, safe) * safe - origin;
  }
  let q = (p - a) / b;
  let v = r / b;
  var t = leave_unit_sphere(q, v);
  if (kind != HEMISPHERE) {
    return q + t * v + (a - origin) / b;
  }
  if (r.y < -SMALL_COMPONENT) {
    t = min(t, max((g.floor_b.x - p.y) / r.y, 0.0));
  }
  return p + t * r - origin;
}
