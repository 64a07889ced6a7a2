#import frame
#import part

// The plainest reflection there is, for comparison: interpolated position and normal, the mirrored ray looks one cube map
// up, LOD from the hardware. Stands in for picture.wgsl.

override LIGHT_COUNT: u32 = 0u;  // picture.wgsl is built for it

struct Plain {
  @builtin(position) clip: vec4f,
  @location(0) position: vec3f,
  @location(1) normal: vec3f,
}

fn plain(vertex: u32, sub_sample: u32) -> Plain {
  let triangle = triangles[vertex / 3u];
  let corner = 3u * select(select(triangle.z, triangle.y, vertex % 3u == 1u), triangle.x, vertex % 3u == 0u);
  let position = vertices[corner].xyz;
  var clip = frame.clip_from_world * vec4f(position, 1.0);
  let shift = vec2f(0.5) - frame.sub_samples[sub_sample].xy;
  clip.x += 2.0 * shift.x / frame.width * clip.w;
  clip.y -= 2.0 * shift.y / frame.height * clip.w;
  return Plain(clip, position, vertices[corner + 1u].xyz);
}

@vertex
fn vertex_single(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32) -> Plain {
  return plain(vertex, sub_sample);
}

@fragment
fn picture_single(in: Plain) -> @location(0) vec4f {
  let mirrored = reflect(normalize(in.position - frame.eye), normalize(in.normal));
  return vec4f(textureSample(distant_cubes, cube_sampler, mirrored, i32(frame.blend[0].y)).rgb, 1.0);
}

// Backs are black, as in picture.wgsl.
@vertex
fn vertex_single_place(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32)
    -> @builtin(position) vec4f {
  return plain(vertex, sub_sample).clip;
}

@fragment
fn picture_single_back() -> @location(0) vec4f {
  return vec4f(0.0, 0.0, 0.0, 1.0);
}
