#import place
#import surface

// The fast path: what the rasterizer interpolates, and its derivatives. Drivers interpolate each in their own way, so this
// is for motion; maps are inferred and measured on the exact path.

struct Interpolated {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) identity: vec3u,   // triangle, its bits, sub-sample
  @location(1) @interpolate(perspective) b: vec2f,
  @location(2) @interpolate(perspective) p: vec3f,
  @location(3) @interpolate(perspective) normal: vec3f,
  @location(4) @interpolate(perspective) tangent: vec4f,
  @location(5) @interpolate(perspective) uv: vec2f,
}

// The same at each of four sub-samples, which costs software adapters more even where there is but one.
struct InterpolatedMulti {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat, either) identity: vec3u,   // triangle, its bits, sub-sample
  @location(1) @interpolate(perspective, sample) b: vec2f,
  @location(2) @interpolate(perspective, sample) p: vec3f,
  @location(3) @interpolate(perspective, sample) normal: vec3f,
  @location(4) @interpolate(perspective, sample) tangent: vec4f,
  @location(5) @interpolate(perspective, sample) uv: vec2f,
}

fn interpolated(vertex: u32) -> Interpolated {
  let corner = 3u * corner_of(vertex);
  let position_u = vertices[corner];
  let normal_v = vertices[corner + 1u];
  let b = vec2f(f32(vertex % 3u == 1u), f32(vertex % 3u == 2u));
  return Interpolated(
    clip_of(position_u.xyz), vec3u(vertex / 3u, triangles[vertex / 3u].w, 0u), b, position_u.xyz, normal_v.xyz,
    vertices[corner + 2u], vec2f(position_u.w, normal_v.w));
}

@vertex
fn vertex_single_fast(@builtin(vertex_index) vertex: u32, @builtin(instance_index) sub_sample: u32) -> Interpolated {
  var out = interpolated(vertex);
  out.position = shifted(out.position, sub_sample);
  out.identity.z = sub_sample;
  return out;
}

@vertex
fn vertex_multi_fast(@builtin(vertex_index) vertex: u32) -> InterpolatedMulti {
  let v = interpolated(vertex);
  return InterpolatedMulti(v.position, v.identity, v.b, v.p, v.normal, v.tangent, v.uv);
}

fn unit_ray_to(p: vec3f) -> vec3f {
  return normalize(p - frame.eye);
}

// Takes derivatives: call it first of all. Drivers interpolate positions a little off their triangle, at sub-samples above all.
// They are put back on it: else traced rays would start behind it, and meet it.
fn interpolated_sample(in: Interpolated, front: bool) -> Sample {
  let p_x = dpdx(in.p);
  let p_y = dpdy(in.p);
  let corners = triangles[in.identity.x];
  let corner = vertices[3u * corners.x].xyz;
  let normal = unit(
    cross(vertices[3u * corners.y].xyz - corner, vertices[3u * corners.z].xyz - corner), vec3f(0.0));
  let p = in.p - dot(in.p - corner, normal) * normal;
  let right = p + NEIGHBOUR_STEP * p_x;
  let down = p + NEIGHBOUR_STEP * p_y;
  let ray = unit_ray_to(p);
  return Sample(
    Point(ray, p, in.normal, in.tangent, in.uv, in.identity.x, in.b),
    Point(unit_ray_to(right), right, in.normal + NEIGHBOUR_STEP * dpdx(in.normal),
          in.tangent + NEIGHBOUR_STEP * dpdx(in.tangent), in.uv + NEIGHBOUR_STEP * dpdx(in.uv), in.identity.x,
          in.b + NEIGHBOUR_STEP * dpdx(in.b)),
    Point(unit_ray_to(down), down, in.normal + NEIGHBOUR_STEP * dpdy(in.normal),
          in.tangent + NEIGHBOUR_STEP * dpdy(in.tangent), in.uv + NEIGHBOUR_STEP * dpdy(in.uv), in.identity.x,
          in.b + NEIGHBOUR_STEP * dpdy(in.b)),
    in.b, in.identity.x, in.identity.y, select(normal, -normal, dot(ray, normal) > 0.0), !front,
    front || part_is(PART_DOUBLE_SIDED));
}
