// Program: keeps what has enough samples out of a pass. Draw three vertices first of all, after depth is cleared, with depth
// writes, compared with "always", and no colour written: where a pixel needs no more, nothing is nearer than this, and the
// depth test rejects all that comes before it is shaded.
//
//   bind group 0   0 uniform, 4 bytes of 16: the picture's width in pixels at byte 8, as in accumulate.wgsl and display.wgsl
//                  1 storage array<u32>, read: after how many samples a pixel had enough, 0 while it takes all, row-major

struct Picture {
  padding: vec2u,
  width: u32,
}

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var<storage, read> enough: array<u32>;

@vertex
fn vertex_enough(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return vec4f(vec2f(f32(vertex & 1u), f32(vertex >> 1u)) * 4.0 - 1.0, 1.0, 1.0);
}

@fragment
fn enough_single(@builtin(position) position: vec4f) {
  let at = vec2u(position.xy);
  if (enough[at.y * picture.width + at.x] == 0u) {
    discard;
  }
}
