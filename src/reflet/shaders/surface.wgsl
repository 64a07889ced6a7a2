#import raster
#import part
#import bilinear

// The exact path: the surface at any pixel position of a triangle's plane, from the triangle's own vertices. Nothing is
// interpolated by the rasterizer, so that all drivers agree.

const FARTHEST_BARYCENTRIC = 20.0;  // neighbours on a plane seen edge-on are cut off here

// The plane's point under one pixel position. Barycentric coordinates belong to the second and third corner.
struct Hit {
  ray: vec3f,     // unit
  b: vec2f,
  p: vec3f,
}

fn hit_at(t: Raster, at: vec2f, area: vec3f) -> Hit {
  let b = clamp(area.yz / (area.x + area.y + area.z), vec2f(-FARTHEST_BARYCENTRIC), vec2f(FARTHEST_BARYCENTRIC));
  return Hit(normalize(view_ray(at)), b, t.a + b.x * t.e1 + b.y * t.e2);
}

const NEIGHBOUR_STEP = 0.25;  // pixels from a sub-sample to the neighbours that its LOD follows from

// Under a pixel position, and under its neighbours to the right and below.
struct Hits {
  here: Hit,
  right: Hit,
  down: Hit,
}

// What one step adds. The step is a power of two: nothing is rounded.
fn a_step(per_pixel: Precise) -> Precise {
  return Precise(per_pixel.value * NEIGHBOUR_STEP, per_pixel.rest * NEIGHBOUR_STEP);
}

fn hits_of(t: Raster, at: vec2f) -> Hits {
  let gap = at - vec2f(t.area.w, t.area_rest.w);
  let area_x = Precise(t.area_x, t.area_x_rest);
  let area_y = Precise(t.area_y, t.area_y_rest);
  let area = precise_sum(
    precise_sum(Precise(t.area.xyz, t.area_rest.xyz), scaled(area_x, gap.x, 0.0)), scaled(area_y, gap.y, 0.0));
  return Hits(
    hit_at(t, at, area.value),
    hit_at(t, at + vec2f(NEIGHBOUR_STEP, 0.0), precise_sum(area, a_step(area_x)).value),
    hit_at(t, at + vec2f(0.0, NEIGHBOUR_STEP), precise_sum(area, a_step(area_y)).value));
}

// A vertex value (0: position and u, 1: normal and v, 2: tangent) at barycentric coordinates b.
fn interpolated(t: Raster, which: u32, b: vec2f) -> vec4f {
  let corners = 3u * triangles[t.identity.x] + which;
  let first = vertices[corners.x];
  return first + b.x * (vertices[corners.y] - first) + b.y * (vertices[corners.z] - first);
}

fn texture_uv(t: Raster, b: vec2f) -> vec2f {
  return vec2f(interpolated(t, 0u, b).w, interpolated(t, 1u, b).w);
}

// v with unit length; ng where v has none.
fn unit(v: vec3f, ng: vec3f) -> vec3f {
  let squared = dot(v, v);
  return select(ng, v * inverseSqrt(max(squared, 1e-30)), squared > 1e-24);
}

// Unit shading normal: interpolated, normal-mapped where the part says so, and turned to the side of ng.
fn shading_normal(t: Raster, b: vec2f, ng: vec3f) -> vec3f {
  var n = unit(t.normal0 + b.x * (t.normal1 - t.normal0) + b.y * (t.normal2 - t.normal0), ng);
  if (part_is(PART_NORMAL_TEXTURE)) {
    let tangent = unit(interpolated(t, 2u, b).xyz, vec3f(0.0));
    let bitangent = cross(n, tangent) * vertices[3u * triangles[t.identity.x].x + 2u].w;
    let texel = bilinear(normal_texture, texture_uv(t, b), part_is(PART_NORMAL_CLAMPS)).xyz * 2.0 - 1.0;
    n = unit(part.normal_scale * (texel.x * tangent + texel.y * bitangent) + texel.z * n, ng);
  }
  return select(n, -n, dot(n, ng) < 0.0);
}
