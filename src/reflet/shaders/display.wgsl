#import tone

// Program: the sum of pictures on a screen. Draw three vertices; the target is an 8-bit format without -srgb.
//
//   bind group 0   0 uniform Display, 16 bytes   1 storage array<vec4f>, read: the sum, row-major

struct Display {
  scale: f32,       // exposure / number of pictures in the sum
  curve: u32,    // TONE_*
  width: u32,       // of the picture in pixels
  padding: u32,
}

@group(0) @binding(0) var<uniform> display: Display;
@group(0) @binding(1) var<storage, read> sum: array<vec4f>;

@vertex
fn vertex_display(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn display_sum(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let at = vec2u(position.xy);
  return vec4f(tone_mapped(sum[at.y * display.width + at.x].rgb * display.scale, display.curve), 1.0);
}
