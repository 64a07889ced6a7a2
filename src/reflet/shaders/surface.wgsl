#import frame
#import part
#import bilinear

// The exact path: the surface at any pixel position of a triangle's plane, from the triangle's own vertices. Nothing is
// interpolated by the rasterizer, so that all drivers agree.

// A triangle seen from the eye. A view ray d meets its plane at a + b1 e1 + b2 e2 with
// b1 = d·(e2 × s)/det, b2 = d·(s × e1)/det, det = -d·(e1 × e2), s = eye - a  (Cramer's rule for d t + s = b1 e1 + b2 e2).
struct Triangle {
  corners: vec3u,
  bits: u32,
  a: vec3f,
  e1: vec3f,
  e2: vec3f,
  row1: vec3f,
  row2: vec3f,
  normal: vec3f,  // e1 × e2: towards the front, not of unit length
}

const FARTHEST_BARYCENTRIC = 20.0;  // neighbours on a plane seen edge-on are cut off here

// The plane's point under one pixel position. Barycentric coordinates belong to the second and third corner.
struct Hit {
  ray: vec3f,     // unit
  b: vec2f,
  p: vec3f,
}

fn load_triangle(number: u32) -> Triangle {
  let entry = triangles[number];
  var t: Triangle;
  t.corners = entry.xyz * 3u;
  t.bits = entry.w;
  t.a = vertices[t.corners.x].xyz;
  t.e1 = vertices[t.corners.y].xyz - t.a;
  t.e2 = vertices[t.corners.z].xyz - t.a;
  let s = frame.eye - t.a;
  t.row1 = cross(t.e2, s);
  t.row2 = cross(s, t.e1);
  t.normal = cross(t.e1, t.e2);
  return t;
}

fn hit_plane(t: Triangle, at: vec2f) -> Hit {
  let d = view_ray(at);
  let b = clamp(vec2f(dot(d, t.row1), dot(d, t.row2)) / -dot(d, t.normal),
                vec2f(-FARTHEST_BARYCENTRIC), vec2f(FARTHEST_BARYCENTRIC));
  return Hit(normalize(d), b, t.a + b.x * t.e1 + b.y * t.e2);
}

// A vertex value (0: position and u, 1: normal and v, 2: tangent) at barycentric coordinates b.
fn interpolated(t: Triangle, which: u32, b: vec2f) -> vec4f {
  let first = vertices[t.corners.x + which];
  return first + b.x * (vertices[t.corners.y + which] - first) + b.y * (vertices[t.corners.z + which] - first);
}

fn texture_uv(t: Triangle, b: vec2f) -> vec2f {
  return vec2f(interpolated(t, 0u, b).w, interpolated(t, 1u, b).w);
}

// Unit shading normal: interpolated, normal-mapped where the part says so, and turned to the side of ng.
fn shading_normal(t: Triangle, b: vec2f, ng: vec3f) -> vec3f {
  var n = normalize(interpolated(t, 1u, b).xyz);
  if (part_is(PART_NORMAL_TEXTURE)) {
    let tangent = normalize(interpolated(t, 2u, b).xyz);
    let bitangent = cross(n, tangent) * vertices[t.corners.x + 2u].w;
    let texel = bilinear(normal_texture, texture_uv(t, b), part_is(PART_NORMAL_CLAMPS)).xyz * 2.0 - 1.0;
    n = normalize(part.normal_scale * (texel.x * tangent + texel.y * bitangent) + texel.z * n);
  }
  return select(n, -n, dot(n, ng) < 0.0);
}
