#import frame
#import part
#import bilinear
#import precise

// The exact path: the surface at any pixel position of a triangle's plane, from the triangle's own vertices. Nothing is
// interpolated by the rasterizer, so that all drivers agree.

// A triangle seen from the eye. Its corners' projections (pixel position times depth, and depth) are kept precisely: what a
// ray far from the corners, or a triangle seen nearly edge-on, makes of them is a difference of nearly equal numbers.
struct Triangle {
  corners: vec3u,
  bits: u32,
  a: vec3f,
  e1: vec3f,
  e2: vec3f,
  normal: vec3f,     // e1 × e2: towards the front, not of unit length
  pixel_x: Precise,  // components belong to the three corners
  pixel_y: Precise,
  depth: Precise,
}

const FARTHEST_BARYCENTRIC = 20.0;  // neighbours on a plane seen edge-on are cut off here

// The plane's point under one pixel position. Barycentric coordinates belong to the second and third corner.
struct Hit {
  ray: vec3f,     // unit
  b: vec2f,
  p: vec3f,
}

fn scaled(a: Precise, factor: f32, factor_rest: f32) -> Precise {
  return precise_product(a, Precise(vec3f(factor), vec3f(factor_rest)));
}

fn load_triangle(number: u32) -> Triangle {
  let entry = triangles[number];
  var t: Triangle;
  t.corners = entry.xyz * 3u;
  t.bits = entry.w;
  t.a = vertices[t.corners.x].xyz;
  let b = vertices[t.corners.y].xyz;
  let c = vertices[t.corners.z].xyz;
  t.e1 = b - t.a;
  t.e2 = c - t.a;
  t.normal = cross(t.e1, t.e2);
  let none = vec3f(0.0);
  let x = precise_difference(Precise(vec3f(t.a.x, b.x, c.x), none), Precise(vec3f(frame.eye.x), vec3f(frame.eye_rest.x)));
  let y = precise_difference(Precise(vec3f(t.a.y, b.y, c.y), none), Precise(vec3f(frame.eye.y), vec3f(frame.eye_rest.y)));
  let z = precise_difference(Precise(vec3f(t.a.z, b.z, c.z), none), Precise(vec3f(frame.eye.z), vec3f(frame.eye_rest.z)));
  t.pixel_x = project(x, y, z, frame.pixel_x, frame.pixel_x_rest);
  t.pixel_y = project(x, y, z, frame.pixel_y, frame.pixel_y_rest);
  t.depth = project(x, y, z, frame.depth, frame.depth_rest);
  return t;
}

// row·(x, y, z) of the three corners.
fn project(x: Precise, y: Precise, z: Precise, row: vec3f, rest: vec3f) -> Precise {
  return precise_sum(precise_sum(scaled(x, row.x, rest.x), scaled(y, row.y, rest.y)), scaled(z, row.z, rest.z));
}

// From a pixel position to the corners', times their depths: (u, v). The ray through the position meets the plane where
// Σ b (u, v) = 0 over the corners, so that b is proportional to the cross products of the other two corners' (u, v).
fn hit_plane(t: Triangle, at: vec2f) -> Hit {
  let u = precise_difference(t.pixel_x, scaled(t.depth, at.x, 0.0));
  let v = precise_difference(t.pixel_y, scaled(t.depth, at.y, 0.0));
  let left = precise_product(Precise(u.value.yzx, u.rest.yzx), Precise(v.value.zxy, v.rest.zxy));
  let right = precise_product(Precise(u.value.zxy, u.rest.zxy), Precise(v.value.yzx, v.rest.yzx));
  let areas = precise_difference(left, right).value;
  let b = clamp(areas.yz / (areas.x + areas.y + areas.z), vec2f(-FARTHEST_BARYCENTRIC), vec2f(FARTHEST_BARYCENTRIC));
  return Hit(normalize(view_ray(at)), b, t.a + b.x * t.e1 + b.y * t.e2);
}

// A vertex value (0: position and u, 1: normal and v, 2: tangent) at barycentric coordinates b.
fn interpolated(t: Triangle, which: u32, b: vec2f) -> vec4f {
  let first = vertices[t.corners.x + which];
  return first + b.x * (vertices[t.corners.y + which] - first) + b.y * (vertices[t.corners.z + which] - first);
}

fn texture_uv(t: Triangle, b: vec2f) -> vec2f {
  return vec2f(interpolated(t, 0u, b).w, interpolated(t, 1u, b).w);
}

// v with unit length; ng where v has none.
fn unit(v: vec3f, ng: vec3f) -> vec3f {
  let squared = dot(v, v);
  return select(ng, v * inverseSqrt(max(squared, 1e-30)), squared > 1e-24);
}

// Unit shading normal: interpolated, normal-mapped where the part says so, and turned to the side of ng.
fn shading_normal(t: Triangle, b: vec2f, ng: vec3f) -> vec3f {
  var n = unit(interpolated(t, 1u, b).xyz, ng);
  if (part_is(PART_NORMAL_TEXTURE)) {
    let tangent = unit(interpolated(t, 2u, b).xyz, vec3f(0.0));
    let bitangent = cross(n, tangent) * vertices[t.corners.x + 2u].w;
    let texel = bilinear(normal_texture, texture_uv(t, b), part_is(PART_NORMAL_CLAMPS)).xyz * 2.0 - 1.0;
    n = unit(part.normal_scale * (texel.x * tangent + texel.y * bitangent) + texel.z * n, ng);
  }
  return select(n, -n, dot(n, ng) < 0.0);
}
