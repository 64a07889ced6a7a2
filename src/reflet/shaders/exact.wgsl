#import raster
#import surface

// The exact path: the surface at any pixel position of a triangle's plane, from the triangle's own vertices. Nothing is
// interpolated by the rasterizer, so that all drivers agree.

fn barycentrics(area: vec3f) -> vec2f {
  return clamp(area.yz / (area.x + area.y + area.z), vec2f(-FARTHEST_BARYCENTRIC), vec2f(FARTHEST_BARYCENTRIC));
}

fn point_at(t: Raster, at: vec2f, b: vec2f) -> Point {
  let p = t.a + b.x * t.e1 + b.y * t.e2;
  let normal = t.normal0 + b.x * (t.normal1 - t.normal0) + b.y * (t.normal2 - t.normal0);
  var tangent = vec4f(0.0);
  var uv = vec2f(0.0);
  if (part_is(PART_TEXTURES)) {
    uv = vec2f(vertex_value(t.identity.x, 0u, b).w, vertex_value(t.identity.x, 1u, b).w);
    tangent = vec4f(vertex_value(t.identity.x, 2u, b).xyz, vertices[3u * triangles[t.identity.x].x + 2u].w);
  }
  return Point(normalize(view_ray(at)), p, normal, tangent, uv, t.identity.x, b);
}

// What one step adds. The step is a power of two: nothing is rounded.
fn a_step(per_pixel: Precise) -> Precise {
  return Precise(per_pixel.value * NEIGHBOUR_STEP, per_pixel.rest * NEIGHBOUR_STEP);
}

// A triangle at pixel coordinates `at`.
fn exact_sample(t: Raster, at: vec2f) -> Sample {
  let gap = at - vec2f(t.area.w, t.area_rest.w);
  let area_x = Precise(t.area_x, t.area_x_rest);
  let area_y = Precise(t.area_y, t.area_y_rest);
  let area = precise_sum(
    precise_sum(Precise(t.area.xyz, t.area_rest.xyz), scaled(area_x, gap.x, 0.0)), scaled(area_y, gap.y, 0.0));
  let b = barycentrics(area.value);
  let here = point_at(t, at, b);
  let ng = unit(cross(t.e1, t.e2), vec3f(0.0));
  let back = dot(here.ray, ng) > 0.0;
  return Sample(
    here,
    point_at(t, at + vec2f(NEIGHBOUR_STEP, 0.0), barycentrics(precise_sum(area, a_step(area_x)).value)),
    point_at(t, at + vec2f(0.0, NEIGHBOUR_STEP), barycentrics(precise_sum(area, a_step(area_y)).value)),
    b, t.identity.x, t.identity.y, select(ng, -ng, back), back, !back || part_is(PART_DOUBLE_SIDED));
}
