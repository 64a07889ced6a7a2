// Bind group 0 of programs that draw meshes from any point, onto a plane or a map's face. The host's side of this layout
// is `reflet.render.meshes.views`.
//
//   binding  resource                     stages             contents
//   0        uniform View, 176 bytes      vertex, fragment   where from, and onto what
//   1        storage array<mat4x4f>       vertex             world_from_mesh of every instance; rigid

struct View {
  clip_from_world: mat4x4f,  // reversed depth, infinite far plane: 1 near, 0 infinitely far; drawn with "greater"
  eye: vec3f,
  near: f32,                 // distance of the near plane
  ray_corner: vec3f,         // the ray through pixel coordinates (x, y) is ray_corner + x ray_dx + y ray_dy
  front_is_clockwise: u32,   // 1 for views that mirror: fronts come out clockwise
  ray_dx: vec3f,
  face: u32,                 // of a map, where one is drawn
  ray_dy: vec3f,
  row: f32,                  // height of a pixel in v, where a map's face is drawn
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> world_from_mesh: array<mat4x4f>;

// The view ray (not of unit length) through pixel coordinates `at`.
fn view_ray(at: vec2f) -> vec3f {
  return view.ray_corner + at.x * view.ray_dx + at.y * view.ray_dy;
}

// One triangle over the whole picture, infinitely far.
fn far_corner(vertex: u32) -> vec4f {
  return vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

struct Vertex {
  @location(0) position: vec3f,
  @location(1) normal: vec3f,
  @location(2) uv: vec2f,
}

// A vertex in world space.
fn placed(in: Vertex, instance: u32) -> Vertex {
  let world = world_from_mesh[instance];
  return Vertex((world * vec4f(in.position, 1.0)).xyz, (world * vec4f(in.normal, 0.0)).xyz, in.uv);
}
