#import tone

// Program: the sum of pictures on a screen. Draw three vertices; the target is an 8-bit format without -srgb.
//
//   bind group 0   0 uniform Display, 16 bytes   1 storage array<vec4f>, read: the sum, row-major
//                  2 storage array<u32>, read: after how many pictures a pixel had enough, 0 where it took all, row-major

struct Display {
  exposure: f32,
  curve: u32,    // TONE_*
  width: u32,    // of the picture in pixels
  count: u32,    // of pictures in the sum
}

@group(0) @binding(0) var<uniform> display: Display;
@group(0) @binding(1) var<storage, read> sum: array<vec4f>;
@group(0) @binding(2) var<storage, read> enough: array<u32>;

@vertex
fn vertex_display(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn display_sum(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let at = vec2u(position.xy);
  let k = at.y * display.width + at.x;
  let count = select(enough[k], display.count, enough[k] == 0u);
  return vec4f(tone_mapped(sum[k].rgb * (display.exposure / f32(count)), display.curve), 1.0);
}
