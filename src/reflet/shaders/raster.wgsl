#import place
#import precise

// The exact path's vertex entry points: nothing that reaches the fragment stage is interpolated.

// All that a fragment needs of its triangle, the same at its three corners. The view ray through pixel position q meets
// the triangle's plane at the barycentric coordinates area/Σ area, where area (components belong to the three corners) is
// linear in q: area + area_x (q - from).x + area_y (q - from).y, in precise numbers: their sums nearly cancel where a
// triangle is seen edge-on.
struct Raster {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) identity: vec4u,     // triangle, its bits, sub-sample, 0
  @location(1) @interpolate(flat, either) area: vec4f,        // ... and from.x
  @location(2) @interpolate(flat, either) area_rest: vec4f,   // ... and from.y
  @location(3) @interpolate(flat, either) area_x: vec3f,
  @location(4) @interpolate(flat, either) area_x_rest: vec3f,
  @location(5) @interpolate(flat, either) area_y: vec3f,
  @location(6) @interpolate(flat, either) area_y_rest: vec3f,
  @location(7) @interpolate(flat, either) a: vec3f,           // first corner and edges to the others
  @location(8) @interpolate(flat, either) e1: vec3f,
  @location(9) @interpolate(flat, either) e2: vec3f,
  @location(10) @interpolate(flat, either) normal0: vec3f,    // of the corners
  @location(11) @interpolate(flat, either) normal1: vec3f,
  @location(12) @interpolate(flat, either) normal2: vec3f,
}

fn scaled(a: Precise, factor: f32, factor_rest: f32) -> Precise {
  return precise_product(a, Precise(vec3f(factor), vec3f(factor_rest)));
}

// row·(x, y, z) of three points.
fn project(x: Precise, y: Precise, z: Precise, row: vec3f, rest: vec3f) -> Precise {
  return precise_sum(precise_sum(scaled(x, row.x, rest.x), scaled(y, row.y, rest.y)), scaled(z, row.z, rest.z));
}

// p_j q_k - p_k q_j for (j, k) = (1, 2), (2, 0), (0, 1).
fn precise_cross(p: Precise, q: Precise) -> Precise {
  return precise_difference(
    precise_product(Precise(p.value.yzx, p.rest.yzx), Precise(q.value.zxy, q.rest.zxy)),
    precise_product(Precise(p.value.zxy, p.rest.zxy), Precise(q.value.yzx, q.rest.yzx)));
}

fn from_eye(values: vec3f, eye: f32, eye_rest: f32) -> Precise {
  return precise_difference(Precise(values, vec3f(0.0)), Precise(vec3f(eye), vec3f(eye_rest)));
}

fn raster(vertex: u32, sub_sample: u32) -> Raster {
  let number = vertex / 3u;
  let entry = triangles[number];
  let a = vertices[3u * entry.x].xyz;
  let b = vertices[3u * entry.y].xyz;
  let c = vertices[3u * entry.z].xyz;
  var out: Raster;
  let corner = select(select(c, b, vertex % 3u == 1u), a, vertex % 3u == 0u);
  out.position = clip_of(corner);
  out.identity = vec4u(number, entry.w, sub_sample, 0u);
  out.a = a;
  out.e1 = b - a;
  out.e2 = c - a;
  out.normal0 = vertices[3u * entry.x + 1u].xyz;
  out.normal1 = vertices[3u * entry.y + 1u].xyz;
  out.normal2 = vertices[3u * entry.z + 1u].xyz;

  // The corners' projections: pixel position times depth, and depth. The ray through q meets the plane where
  // Σ b (x - q.x depth, y - q.y depth) = 0 over the corners, so that each b is the cross product of the other two's.
  let eye_x = from_eye(vec3f(a.x, b.x, c.x), frame.eye.x, frame.eye_rest.x);
  let eye_y = from_eye(vec3f(a.y, b.y, c.y), frame.eye.y, frame.eye_rest.y);
  let eye_z = from_eye(vec3f(a.z, b.z, c.z), frame.eye.z, frame.eye_rest.z);
  let depth = project(eye_x, eye_y, eye_z, frame.depth, frame.depth_rest);
  var x = project(eye_x, eye_y, eye_z, frame.pixel_x, frame.pixel_x_rest);
  var y = project(eye_x, eye_y, eye_z, frame.pixel_y, frame.pixel_y_rest);
  let limit = 2.0 * vec2f(frame.width, frame.height);
  let origin = clamp(round(vec2f(x.value.x, y.value.x) / depth.value.x), -limit, limit);
  x = precise_difference(x, scaled(depth, origin.x, 0.0));
  y = precise_difference(y, scaled(depth, origin.y, 0.0));
  let area = precise_cross(x, y);
  let area_x = precise_cross(y, depth);
  let area_y = precise_cross(depth, x);
  out.area = vec4f(area.value, origin.x);
  out.area_rest = vec4f(area.rest, origin.y);
  out.area_x = area_x.value;
  out.area_x_rest = area_x.rest;
  out.area_y = area_y.value;
  out.area_y_rest = area_y.rest;
  return out;
}

@vertex
fn vertex_single(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32) -> Raster {
  var out = raster(vertex, sub_sample);
  out.position = shifted(out.position, sub_sample);
  return out;
}

// Multi-sampling by the hardware: its four positions are the table's first four.
@vertex
fn vertex_multi(@builtin(vertex_index) vertex: u32) -> Raster {
  return raster(vertex, 0u);
}

// Pixel coordinates of a sub-sample in the pixel that `position` lies in.
fn sub_sample_at(position: vec4f, sub_sample: u32) -> vec2f {
  return floor(position.xy) + sub_sample_position(sub_sample);
}
