#import part
#import bilinear

// A surface as one sub-sample sees it. The exact path (`exact`) and the fast one (`interpolated`) each fill these in; all
// that follows is the same for both.

const NEIGHBOUR_STEP = 0.25;  // pixels from a sub-sample to the neighbours that its LOD follows from
const FARTHEST_BARYCENTRIC = 20.0;  // neighbours on a plane seen edge-on are cut off here

// The point of a triangle's plane under one pixel position.
struct Point {
  ray: vec3f,      // view ray, of unit length
  p: vec3f,
  normal: vec3f,   // interpolated, of any length
  tangent: vec4f,  // likewise, with glTF's handedness; 0 where the part has no texture, as uv
  uv: vec2f,
  triangle: u32,   // drawn number
  b: vec2f,        // barycentric coordinates, of the second and third corner
}

struct Sample {
  here: Point,
  right: Point,    // neighbours on the same triangle's plane
  down: Point,
  b: vec2f,        // barycentric coordinates, of the second and third corner
  triangle: u32,
  bits: u32,       // of the triangle
  ng: vec3f,       // geometric normal: unit, facing the viewer
  back: bool,
  visible: bool,   // false for the back of a single-sided face, which is black
}

// v with unit length; ng where v has none.
fn unit(v: vec3f, ng: vec3f) -> vec3f {
  let squared = dot(v, v);
  return select(ng, v * inverseSqrt(max(squared, 1e-30)), squared > 1e-24);
}

// A vertex value (0: position and u, 1: normal and v, 2: tangent) of a triangle at barycentric coordinates b.
fn vertex_value(triangle: u32, which: u32, b: vec2f) -> vec4f {
  let corners = 3u * triangles[triangle] + which;
  let first = vertices[corners.x];
  return first + b.x * (vertices[corners.y] - first) + b.y * (vertices[corners.z] - first);
}

// Beyond those three a part's vertices may have a colour, and texture coordinates 1, 2 (one vec4f) and 3: behind the values
// of all vertices, from a place on that counts from vertex 0. Those of a point, 0 its colour.
fn extra_value(extras: u32, bits: u32, which: u32, at: Point) -> vec4f {
  let count = select(1u, 3u, (bits & PART_MORE_UV) != 0u);
  let places = vec3u(extras + which) + count * triangles[at.triangle].xyz;
  let first = vertices[places.x];
  return first + at.b.x * (vertices[places.y] - first) + at.b.y * (vertices[places.z] - first);
}

// Texture coordinates by which a texture is looked up; `sampling` is its byte.
fn coordinates(sampling: u32, extras: u32, at: Point) -> vec2f {
  let number = sampling >> 4u;
  if (number == 0u) {
    return at.uv;
  }
  let two = extra_value(extras, PART_MORE_UV, 1u + number / 3u, at);
  return select(two.xy, two.zw, number == 2u);
}

fn part_uv(which: u32, at: Point) -> vec2f {
  if (!part_is(PART_MORE_UV)) {
    return at.uv;
  }
  return coordinates(part_sampling(which), part.extras, at);
}

// Colour and alpha of the part's vertices.
fn part_color(at: Point) -> vec4f {
  if (!part_is(PART_COLORS)) {
    return vec4f(1.0);
  }
  return extra_value(part.extras, select(0u, PART_MORE_UV, part_is(PART_MORE_UV)), 0u, at);
}

// A unit normal bent by a texel of a normal map.
fn normal_mapped(n: vec3f, tangent: vec4f, texel: vec3f, scale: f32, ng: vec3f) -> vec3f {
  let along = unit(tangent.xyz, vec3f(0.0));
  let across = cross(n, along) * tangent.w;
  let local = texel * 2.0 - 1.0;
  return unit(scale * (local.x * along + local.y * across) + local.z * n, ng);
}

// Unit interpolated normal on the side of ng.
fn unbent_normal(at: Point, ng: vec3f) -> vec3f {
  let n = unit(at.normal, ng);
  return select(n, -n, dot(n, ng) < 0.0);
}

// Unit shading normal: interpolated, normal-mapped where the part says so, and turned to the side of ng.
fn shading_normal(at: Point, ng: vec3f) -> vec3f {
  var n = unit(at.normal, ng);
  if (part_is(PART_NORMAL_TEXTURE)) {
    let texel = bilinear(normal_texture, part_uv(2u, at), part_sampling(2u)).xyz;
    n = normal_mapped(n, at.tangent, texel, part.normal_scale, ng);
  }
  return select(n, -n, dot(n, ng) < 0.0);
}
