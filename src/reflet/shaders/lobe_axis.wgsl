// The axis of a lobe (twin of reflet.reflectance.prefilter.brdf_map, `lobe_axis`).

// Unit direction in the plane of incidence at the angle side·θ + apart from the normal n, θ between n and v, positive on
// the mirrored side. By the sum's sines and cosines, as devices' acos is none too good.
fn lobe_axis(n: vec3f, v: vec3f, side: f32, apart: f32) -> vec3f {
  let cosine = dot(n, v);
  let away = cosine * n - v;
  let sine = length(away);
  let tangent = select(vec3f(0.0), away / sine, sine > 1e-6);
  let along = cosine * cos(apart) - side * sine * sin(apart);
  let across = side * sine * cos(apart) + cosine * sin(apart);
  return normalize(along * n + across * tangent);
}
