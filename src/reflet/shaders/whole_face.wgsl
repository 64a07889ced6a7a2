// One triangle over a whole face of a map, for each instance a face.

struct Place {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) face: u32,
}

@vertex
fn vertex_face(@builtin(vertex_index) vertex: u32, @builtin(instance_index) face: u32) -> Place {
  return Place(vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0), face);
}
