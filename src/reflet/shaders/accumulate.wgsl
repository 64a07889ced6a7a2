// Program: adds one picture to the sum of pictures. Clear the sum first; divide by their number when showing it.
//
//   bind group 0   0 texture_2d<f32> (any float format, not filtered)   1 storage array<vec4f>, read and written, row-major

@group(0) @binding(0) var addend: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> sum: array<vec4f>;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
  let size = textureDimensions(addend);
  if (id.x >= size.x || id.y >= size.y) {
    return;
  }
  let k = id.y * size.x + id.x;
  sum[k] = sum[k] + textureLoad(addend, vec2i(id.xy), 0);
}
