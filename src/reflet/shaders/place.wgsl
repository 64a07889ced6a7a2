#import frame

// Where the rasterizer draws: draw(3 * count, 1, 3 * first_triangle, sub_sample); triangles are numbered through all
// parts, vertices are pulled from storage.

// Number of a corner among all vertices; `vertex` counts three a triangle.
fn corner_of(vertex: u32) -> u32 {
  let entry = triangles[vertex / 3u];
  return select(select(entry.z, entry.y, vertex % 3u == 1u), entry.x, vertex % 3u == 0u);
}

fn clip_of(position: vec3f) -> vec4f {
  return frame.clip_from_world * vec4f(position, 1.0);
}

// For one sub-sample a pixel: the picture is shifted so that the sub-sample's position comes to lie on the pixel's centre.
fn shifted(clip: vec4f, sub_sample: u32) -> vec4f {
  let shift = vec2f(0.5) - sub_sample_position(sub_sample);
  return clip + vec4f(2.0 * shift.x / frame.width, -2.0 * shift.y / frame.height, 0.0, 0.0) * clip.w;
}

// Vertex entry points for what needs no more than a place.
@vertex
fn vertex_single_place(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32)
    -> @builtin(position) vec4f {
  return shifted(clip_of(vertices[3u * corner_of(vertex)].xyz), sub_sample);
}

@vertex
fn vertex_multi_place(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return clip_of(vertices[3u * corner_of(vertex)].xyz);
}
