#import frame

// Vertex entry points: vertices are pulled from storage, the triangle's number is all that reaches the fragment stage.
// Draw with draw(3 * count, 1, 3 * first_triangle, sub_sample): vertex numbers run through all parts.

struct Raster {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) triangle: u32,
  @location(1) @interpolate(flat, either) sub_sample: u32,
}

fn corner_position(vertex: u32) -> vec4f {
  let triangle = triangles[vertex / 3u];
  let corner = select(select(triangle.z, triangle.y, vertex % 3u == 1u), triangle.x, vertex % 3u == 0u);
  return frame.clip_from_world * vec4f(vertices[3u * corner].xyz, 1.0);
}

// One sub-sample a pixel: the picture is shifted so that the sub-sample's position comes to lie on the pixel's centre.
@vertex
fn vertex_single(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32) -> Raster {
  var clip = corner_position(vertex);
  let shift = vec2f(0.5) - frame.sub_samples[sub_sample].xy;
  clip.x += 2.0 * shift.x / frame.width * clip.w;
  clip.y -= 2.0 * shift.y / frame.height * clip.w;
  return Raster(clip, vertex / 3u, sub_sample);
}

// Multi-sampling by the hardware: its four positions are the table's first four.
@vertex
fn vertex_multi(@builtin(vertex_index) vertex: u32) -> Raster {
  return Raster(corner_position(vertex), vertex / 3u, 0u);
}

// Pixel coordinates of a sub-sample in the pixel that `position` lies in.
fn sub_sample_at(position: vec4f, sub_sample: u32) -> vec2f {
  return floor(position.xy) + frame.sub_samples[sub_sample].xy;
}
