// Fresnel reflectance of unpolarized light. Twin: reflet.reflectance.brdfs.fresnel. Cosines are clamped to [0, 1].

// [Schlick94]
fn fresnel_schlick(f0: vec3f, f90: f32, n_dot_v: f32) -> vec3f {
  let c = 1.0 - clamp(n_dot_v, 0.0, 1.0);
  let c2 = c * c;
  return f0 + (f90 - f0) * (c2 * c2 * c);
}

// [Heidrich00, eq. 13]; index of the inside over that of the outside.
fn fresnel_dielectric(index: f32, n_dot_v: f32) -> f32 {
  let c = clamp(n_dot_v, 0.0, 1.0);
  let g2 = (index - 1.0) * (index + 1.0) + c * c;
  if (g2 <= 0.0) {
    return 1.0;
  }
  let g = sqrt(g2);
  let r_s = (g - c) / (g + c);
  let ratio = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
  return 0.5 * r_s * r_s * (1.0 + ratio * ratio);
}

// [BornWolf99, sec. 14.2]; complex index n - ik for each channel.
fn fresnel_conductor(n: vec3f, k: vec3f, n_dot_v: f32) -> vec3f {
  let c = clamp(n_dot_v, 0.0, 1.0);
  let s2 = 1.0 - c * c;
  let real = n * n - k * k - s2;
  let modulus = sqrt(real * real + 4.0 * n * n * k * k);
  let odd_s = 2.0 * c * sqrt(max(0.5 * (modulus + real), vec3f(0.0)));
  let even_s = modulus + c * c;
  let even_p = c * c * modulus + s2 * s2;
  let odd_p = odd_s * s2;
  let r_s = (even_s - odd_s) / max(even_s + odd_s, vec3f(1e-30));
  return 0.5 * r_s * (1.0 + (even_p - odd_p) / max(even_p + odd_p, vec3f(1e-30)));
}
