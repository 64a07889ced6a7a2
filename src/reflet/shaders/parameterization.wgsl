// Parameterizations: how directions become texture coordinates (twin of reflet.envmap.parameterizations.parameterization and its files, which
// say what and why; CONVENTIONS.md, "Maps"). Give `kind` as a constant or an override: the rest of the switch then costs nothing.

// Where a map holds a direction: uv in [0, 1]² of a face, origin top left.
struct MapPoint {
  face: u32,
  uv: vec2f,
}

const CUBE = 0u;
const LATLONG = 1u;
const DUAL_PARABOLOID = 2u;
const GAZING_BALL = 3u;
const ANGULAR = 4u;
const OCTAHEDRAL = 5u;
const EQUAL_AREA_OCTAHEDRAL = 6u;

const MAP_PI = 3.14159265358979;
const LEAST_SINE = 1e-3;  // sines below this are taken as this: keeps sampling rates finite at poles

// atan2(y, x) in [-π, π], 0 for (0, 0). Ours, as devices may err by 4096 units in the last place, more than a texel; the
// polynomial errs by 2e-8 [Abramowitz64, 4.4.49].
fn angle_of(y: f32, x: f32) -> f32 {
  let a = abs(vec2f(x, y));
  let long = max(a.x, a.y);
  let q = select(0.0, min(a.x, a.y) / long, long > 0.0);
  let s = q * q;
  var angle = -0.0161657367 + s * 0.0028662257;
  angle = 0.0429096138 + s * angle;
  angle = -0.0752896400 + s * angle;
  angle = 0.1065626393 + s * angle;
  angle = -0.1420889944 + s * angle;
  angle = 0.1999355085 + s * angle;
  angle = -0.3333314528 + s * angle;
  angle = q + q * s * angle;
  angle = select(angle, 0.5 * MAP_PI - angle, a.y > a.x);
  angle = select(angle, MAP_PI - angle, x < 0.0);
  return select(angle, -angle, y < 0.0);
}

// -1 below zero, 1 else.
fn sign_of(v: vec2f) -> vec2f {
  return select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

// v / |v|; (1, 0) for the zero vector.
fn unit_or_right(v: vec2f) -> vec2f {
  let norm = length(v);
  return select(vec2f(1.0, 0.0), v / norm, norm > 0.0);
}

// uv of (x, y) in [-1, 1]², x to the right and y up.
fn uv_from_plane(p: vec2f) -> vec2f {
  return 0.5 + vec2f(0.5, -0.5) * p;
}

fn plane_from_uv(uv: vec2f) -> vec2f {
  return vec2f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
}

// The cube's face that a direction meets, by the order px nx py ny pz nz; ties go to x before y before z.
fn cube_face(d: vec3f) -> u32 {
  let m = abs(d);
  if (m.x >= m.y && m.x >= m.z) {
    return select(0u, 1u, d.x < 0.0);
  }
  if (m.y >= m.z) {
    return select(2u, 3u, d.y < 0.0);
  }
  return select(4u, 5u, d.z < 0.0);
}

// A direction in a cube face's own axes: right, down, outward.
fn in_cube_face(face: u32, d: vec3f) -> vec3f {
  switch (face) {
    case 0u: { return vec3f(-d.z, -d.y, d.x); }
    case 1u: { return vec3f(d.z, -d.y, -d.x); }
    case 2u: { return vec3f(d.x, d.z, d.y); }
    case 3u: { return vec3f(d.x, -d.z, -d.y); }
    case 4u: { return vec3f(d.x, -d.y, d.z); }
    default: { return vec3f(-d.x, -d.y, -d.z); }
  }
}

// And back.
fn from_cube_face(face: u32, q: vec3f) -> vec3f {
  switch (face) {
    case 0u: { return vec3f(q.z, -q.y, -q.x); }
    case 1u: { return vec3f(-q.z, -q.y, q.x); }
    case 2u: { return vec3f(q.x, q.z, q.y); }
    case 3u: { return vec3f(q.x, -q.z, -q.y); }
    case 4u: { return vec3f(q.x, -q.y, q.z); }
    default: { return vec3f(-q.x, -q.y, -q.z); }
  }
}

// Face and uv of a direction of any length but zero.
fn map_point(kind: u32, d: vec3f) -> MapPoint {
  switch (kind) {
    case LATLONG: {
      return MapPoint(0u, vec2f(0.5 + angle_of(d.z, d.x) / (2.0 * MAP_PI), angle_of(length(d.xz), d.y) / MAP_PI));
    }
    case DUAL_PARABOLOID: {
      let n = normalize(d);
      return MapPoint(select(1u, 0u, n.z >= 0.0), uv_from_plane(n.xy / (1.0 + abs(n.z))));
    }
    case GAZING_BALL: {
      let n = normalize(d);
      // sin(θ/2), by the half-angle formula that does not cancel: sqrt((1 - z)/2) = |xy|/sqrt(2(1 + z)).
      let radius = select(sqrt(0.5 - 0.5 * min(n.z, 0.0)), length(n.xy) * inverseSqrt(2.0 + 2.0 * max(n.z, 0.0)), n.z >= 0.0);
      return MapPoint(0u, uv_from_plane(radius * unit_or_right(n.xy)));
    }
    case ANGULAR: {
      return MapPoint(0u, uv_from_plane(angle_of(length(d.xy), -d.z) / MAP_PI * unit_or_right(d.xy)));
    }
    case OCTAHEDRAL: {
      let p = d / (abs(d.x) + abs(d.y) + abs(d.z));
      let folded = (1.0 - abs(p.zx)) * sign_of(p.xz);
      return MapPoint(0u, 0.5 + 0.5 * select(folded, p.xz, p.y >= 0.0));
    }
    case EQUAL_AREA_OCTAHEDRAL: {
      let n = normalize(d);
      let radius = length(n.xz) * inverseSqrt(1.0 + abs(n.y));
      let across = radius * angle_of(abs(n.z), abs(n.x)) * (2.0 / MAP_PI);
      let st = vec2f(radius - across, across);
      return MapPoint(0u, 0.5 + 0.5 * select(1.0 - st.yx, st, n.y >= 0.0) * sign_of(n.xz));
    }
    default: {
      let face = cube_face(d);
      let q = in_cube_face(face, d);
      return MapPoint(face, 0.5 + 0.5 * q.xy / q.z);
    }
  }
}

// Unit direction of a place on a face; outside the disc of a round map its continuation.
fn map_direction(kind: u32, face: u32, uv: vec2f) -> vec3f {
  switch (kind) {
    case LATLONG: {
      let phi = (uv.x - 0.5) * (2.0 * MAP_PI);
      let theta = uv.y * MAP_PI;
      return vec3f(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
    }
    case DUAL_PARABOLOID: {
      let p = plane_from_uv(uv);
      let square = dot(p, p);
      return vec3f(2.0 * p, select(-1.0, 1.0, face == 0u) * (1.0 - square)) / (1.0 + square);
    }
    case GAZING_BALL: {
      var p = plane_from_uv(uv);
      let radius = length(p);
      p *= select(1.0, 1.0 - 2.0 / radius, radius > 1.0);  // past the rim the map goes on over its other side
      let height = sqrt(max(1.0 - dot(p, p), 0.0));
      return vec3f(2.0 * height * p, 2.0 * height * height - 1.0);
    }
    case ANGULAR: {
      let p = plane_from_uv(uv);
      let theta = MAP_PI * length(p);
      return vec3f(sin(theta) * unit_or_right(p), -cos(theta));
    }
    case OCTAHEDRAL: {
      let st = 2.0 * uv - 1.0;
      let y = 1.0 - abs(st.x) - abs(st.y);
      let xz = select((1.0 - abs(st.yx)) * sign_of(st), st, y >= 0.0);
      return normalize(vec3f(xz.x, y, xz.y));
    }
    case EQUAL_AREA_OCTAHEDRAL: {
      let st = 2.0 * uv - 1.0;
      let a = abs(st);
      let height = 1.0 - a.x - a.y;
      let radius = 1.0 - abs(height);
      let phi = 0.25 * MAP_PI * select(1.0, (a.y - a.x) / radius + 1.0, radius > 0.0);
      let xz = radius * sqrt(2.0 - radius * radius) * vec2f(cos(phi), sin(phi)) * sign_of(st);
      let y = 1.0 - radius * radius;
      return vec3f(xz.x, select(-y, y, height >= 0.0), xz.y);
    }
    default: {
      return normalize(from_cube_face(face, vec3f(2.0 * uv - 1.0, 1.0)));
    }
  }
}

// Texels per steradian around a unit direction, in a map of size 1.
fn sampling_rate(kind: u32, d: vec3f) -> f32 {
  switch (kind) {
    case LATLONG: {
      return 1.0 / (MAP_PI * MAP_PI * max(length(d.xz), LEAST_SINE));
    }
    case DUAL_PARABOLOID: {
      let h = 1.0 + abs(d.z);
      return 0.25 / (h * h);
    }
    case GAZING_BALL: {
      return 1.0 / 16.0;
    }
    case ANGULAR: {
      let ring = length(d.xy);
      let theta = angle_of(ring, -d.z);
      return select(theta / max(ring, LEAST_SINE), 1.0, theta < LEAST_SINE) / (4.0 * MAP_PI * MAP_PI);
    }
    case OCTAHEDRAL: {
      let sum = abs(d.x) + abs(d.y) + abs(d.z);
      return 0.25 / (sum * sum * sum);
    }
    case EQUAL_AREA_OCTAHEDRAL: {
      return 0.25 / MAP_PI;
    }
    default: {
      let m = max(max(abs(d.x), abs(d.y)), abs(d.z));
      return 0.25 / (m * m * m);
    }
  }
}

// Array layers that a map takes.
fn face_count(kind: u32) -> i32 {
  return select(select(1, 2, kind == DUAL_PARABOLOID), 6, kind == CUBE);
}

// (column, row, face) of the texel at a place up to one texel outside a face of `size` rows: the neighbour over the seam.
// The face is -1 where there is none: beyond a cube's corner.
fn across_seams(kind: u32, face: i32, texel: vec2i, size: i32) -> vec3i {
  let extent = vec2i(select(size, 2 * size, kind == LATLONG), size);
  if (all(texel >= vec2i(0)) && all(texel < extent)) {
    return vec3i(texel, face);
  }
  switch (kind) {
    case LATLONG: {
      let over_pole = texel.y < 0 || texel.y >= size;
      let row = select(texel.y, select(2 * size - 1 - texel.y, -1 - texel.y, texel.y < 0), over_pole);
      return vec3i((texel.x + select(2 * size, 3 * size, over_pole)) % (2 * size), row, face);
    }
    case DUAL_PARABOLOID: {
      let p = (2.0 * vec2f(texel) + 1.0) / f32(size) - 1.0;
      let inverse = vec2i(floor((p / dot(p, p) + 1.0) * (0.5 * f32(size))));
      return vec3i(clamp(inverse, vec2i(0), extent - 1), 1 - face);
    }
    case GAZING_BALL, ANGULAR: {
      // The whole rim is one direction: a path that leaves the disc at radius r comes back on the other side, at 2 - r.
      let p = (2.0 * vec2f(texel) + 1.0) / f32(size) - 1.0;
      let back = vec2i(floor((p * (1.0 - 2.0 / length(p)) + 1.0) * (0.5 * f32(size))));
      return vec3i(clamp(back, vec2i(0), extent - 1), face);
    }
    case OCTAHEDRAL, EQUAL_AREA_OCTAHEDRAL: {
      // Each edge meets itself, turned about its middle.
      var at = texel;
      if (at.x < 0 || at.x >= size) {
        at = vec2i(select(2 * size - 1 - at.x, -1 - at.x, at.x < 0), size - 1 - at.y);
      }
      if (at.y < 0 || at.y >= size) {
        at = vec2i(size - 1 - at.x, select(2 * size - 1 - at.y, -1 - at.y, at.y < 0));
      }
      return vec3i(at, face);
    }
    default: {
      let q = 2 * texel + 1 - size;  // on a face over [-size, size]²: whole numbers, so that nothing is rounded
      let outside = abs(q) > vec2i(size);
      if (all(outside)) {
        return vec3i(clamp(texel, vec2i(0), extent - 1), -1);
      }
      // A hair outside the edge, the other face's outermost texel is the neighbour.
      let d = from_cube_face(u32(face), vec3f(vec3i(q, size)));
      let on = cube_face(d);
      let st = clamp(vec2i(in_cube_face(on, d).xy), vec2i(1 - size), vec2i(size - 1));
      return vec3i((st + size - 1) / 2, i32(on));
    }
  }
}
