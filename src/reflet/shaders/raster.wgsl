#import frame
#import precise

// Vertex entry points: vertices are pulled from storage, and nothing that reaches the fragment stage is interpolated.
// Draw with draw(3 * count, 1, 3 * first_triangle, sub_sample): triangles are numbered through all parts.

// All that a fragment needs of its triangle, the same at its three corners. `corner` is the first corner's projection,
// (pixel position times depth, depth), and `edge1`, `edge2` lead from it to those of the others; all positions are seen from
// pixel `pixel`, near the corner, so that no digits are lost to the distance from the picture's border.
struct Raster {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) identity: vec4u,  // triangle, its bits, sub-sample, 0
  @location(1) @interpolate(flat, either) pixel: vec2f, 
  @location(2) @interpolate(flat, either) corner: vec3f,
  @location(3) @interpolate(flat, either) edge1: vec3f,
  @location(4) @interpolate(flat, either) edge2: vec3f,
  @location(5) @interpolate(flat, either) a: vec3f,         // first corner and edges to the others, in the world
  @location(6) @interpolate(flat, either) e1: vec3f,
  @location(7) @interpolate(flat, either) e2: vec3f,
  @location(8) @interpolate(flat, either) normal0: vec3f,   // of the corners
  @location(9) @interpolate(flat, either) normal1: vec3f,
  @location(10) @interpolate(flat, either) normal2: vec3f,
}

// Column k of the matrix that projects, times one coordinate of a point.
fn projected(column: vec3f, column_rest: vec3f, coordinate: f32, coordinate_rest: f32) -> Precise {
  return precise_product(Precise(column, column_rest), Precise(vec3f(coordinate), vec3f(coordinate_rest)));
}

fn raster(vertex: u32, sub_sample: u32) -> Raster {
  let number = vertex / 3u;
  let entry = triangles[number];
  let a = vertices[3u * entry.x].xyz;
  let b = vertices[3u * entry.y].xyz;
  let c = vertices[3u * entry.z].xyz;
  var out: Raster;
  let place = select(select(c, b, vertex % 3u == 1u), a, vertex % 3u == 0u);
  out.position = frame.clip_from_world * vec4f(place, 1.0);
  out.identity = vec4u(number, entry.w, sub_sample, 0u);
  out.a = a;
  out.e1 = b - a;
  out.e2 = c - a;
  out.normal0 = vertices[3u * entry.x + 1u].xyz;
  out.normal1 = vertices[3u * entry.y + 1u].xyz;
  out.normal2 = vertices[3u * entry.z + 1u].xyz;

  // float32 alone would misplace the corner by 1e-4 pixels. The edges are short and need no such care.
  let s = precise_difference(Precise(a, vec3f(0.0)), Precise(frame.eye, frame.eye_rest));
  let rows = transpose(mat3x3f(frame.pixel_x, frame.pixel_y, frame.depth));
  let rests = transpose(mat3x3f(frame.pixel_x_rest, frame.pixel_y_rest, frame.depth_rest));
  let corner = precise_sum(
    precise_sum(projected(rows[0], rests[0], s.value.x, s.rest.x), projected(rows[1], rests[1], s.value.y, s.rest.y)),
    projected(rows[2], rests[2], s.value.z, s.rest.z));
  let limit = 2.0 * vec2f(frame.width, frame.height);
  out.pixel = clamp(round(corner.value.xy / corner.value.z), -limit, limit);
  let moved = projected(vec3f(out.pixel, 0.0), vec3f(0.0), corner.value.z, corner.rest.z);
  out.corner = precise_difference(corner, moved).value;
  let row_x = frame.pixel_x - out.pixel.x * frame.depth;
  let row_y = frame.pixel_y - out.pixel.y * frame.depth;
  out.edge1 = vec3f(dot(row_x, out.e1), dot(row_y, out.e1), dot(frame.depth, out.e1));
  out.edge2 = vec3f(dot(row_x, out.e2), dot(row_y, out.e2), dot(frame.depth, out.e2));
  return out;
}

fn place(vertex: u32) -> vec4f {
  let entry = triangles[vertex / 3u];
  let corner = select(select(entry.z, entry.y, vertex % 3u == 1u), entry.x, vertex % 3u == 0u);
  return frame.clip_from_world * vec4f(vertices[3u * corner].xyz, 1.0);
}

fn shifted(clip: vec4f, sub_sample: u32) -> vec4f {
  let shift = vec2f(0.5) - frame.sub_samples[sub_sample].xy;
  return clip + vec4f(2.0 * shift.x / frame.width, -2.0 * shift.y / frame.height, 0.0, 0.0) * clip.w;
}

// One sub-sample a pixel: the picture is shifted so that the sub-sample's position comes to lie on the pixel's centre.
@vertex
fn vertex_single(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32) -> Raster {
  var out = raster(vertex, sub_sample);
  out.position = shifted(out.position, sub_sample);
  return out;
}

// The same for what needs no more than a place.
@vertex
fn vertex_single_place(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32)
    -> @builtin(position) vec4f {
  return shifted(place(vertex), sub_sample);
}

@vertex
fn vertex_multi_place(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return place(vertex);
}

// Multi-sampling by the hardware: its four positions are the table's first four.
@vertex
fn vertex_multi(@builtin(vertex_index) vertex: u32) -> Raster {
  return raster(vertex, 0u);
}

// Pixel coordinates of a sub-sample in the pixel that `position` lies in.
fn sub_sample_at(position: vec4f, sub_sample: u32) -> vec2f {
  return floor(position.xy) + frame.sub_samples[sub_sample].xy;
}
