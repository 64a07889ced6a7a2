#import view
#import env_map

// Programs: one env map drawn as another, face by face. Draw three vertices.

// The parameterization that is drawn.
override TO_KIND: u32 = 0u;

@vertex
fn vertex_warp(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return far_corner(vertex);
}

@fragment
fn warp(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let step = vec2f(view.row * select(1.0, 0.5, TO_KIND == LATLONG), view.row);
  let uv = position.xy * step;
  let radiance = env_radiance(
    map_direction(TO_KIND, view.face, uv),
    map_direction(TO_KIND, view.face, uv + vec2f(step.x, 0.0)),
    map_direction(TO_KIND, view.face, uv + vec2f(0.0, step.y)));
  return min(radiance, vec4f(65504.0));  // half float's largest: a sun beyond it stays finite
}
