// The LOD policy of env maps (CONVENTIONS.md, twin of reflet.envmap.lod): ours, as drivers differ in theirs.

// A direction with the given axis last: (s, t) up to sign and order, and depth. Distances on a face need no more.
fn on_face(axis: u32, direction: vec3f) -> vec3f {
  return select(select(direction, direction.xzy, axis == 1u), direction.zyx, axis == 0u);
}

// Squared distance on the face plane between a sample at (s, t) and its neighbour; infinite behind the plane.
fn squared_step(st: vec2f, depth_sign: f32, neighbour: vec3f) -> f32 {
  let depth = neighbour.z * depth_sign;
  let gap = neighbour.xy / neighbour.z - st;
  return select(1e30, dot(gap, gap), depth > 0.0);
}

// LOD of a lookup in direction d, from the directions dx and dy of the neighbours right and down.
fn cube_lod(d: vec3f, dx: vec3f, dy: vec3f, size: f32, lod_bias: f32, max_lod: f32) -> f32 {
  let m = abs(d);
  let axis = select(select(2u, 1u, m.y >= m.z), 0u, m.x >= m.y && m.x >= m.z);
  let q = on_face(axis, d);
  let st = q.xy / q.z;
  let depth_sign = sign(q.z);
  let rho_squared = max(squared_step(st, depth_sign, on_face(axis, dx)), squared_step(st, depth_sign, on_face(axis, dy)));
  return clamp(0.5 * log2(max(rho_squared * (0.25 * size * size), 1e-12)) + lod_bias, 0.0, max_lod);
}
