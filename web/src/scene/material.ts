// Environment-mapped materials: records, and how shaders read them. Twin of reflet.reflectance.materials.material.

import type { Vec3 } from "../maths/vectors";

export type Material =
  | { kind: "mirror"; reflectance: Vec3 }
  | { kind: "dielectric"; index: number }
  | { kind: "dielectric_over_diffuse"; index: number; albedo: Vec3 }
  | { kind: "coated"; index: number; albedo: Vec3 }
  | { kind: "conductor"; n: Vec3; k: Vec3 }
  | { kind: "phong"; exponent: number; specular: Vec3; diffuse: Vec3 }
  | { kind: "ggx"; baseColor: Vec3; metallic: number; roughness: number };

export const KINDS = [
  "mirror",
  "dielectric",
  "dielectric_over_diffuse",
  "coated",
  "conductor",
  "phong",
  "ggx",
] as const satisfies readonly Material["kind"][]; // in the order of their numbers in material.wgsl

/** The direction by which a surface looks its map up, in the order of lookup.wgsl's numbers. */
export const LOOKUPS = ["reflection", "normal", "view_reflection", "view_normal"] as const;
export type LookupDirection = (typeof LOOKUPS)[number];

export const MATERIAL_BYTES = 48;

/** Whether a material looks the diffuse map up. */
export const diffuses = ({ kind }: Material): boolean =>
  kind === "dielectric_over_diffuse" || kind === "coated" || kind === "phong" || kind === "ggx";

/** `Material` in material.wgsl. */
export function materialUniform(material: Material): ArrayBuffer {
  const data = new ArrayBuffer(MATERIAL_BYTES);
  const floats = new Float32Array(data);
  new Uint32Array(data)[3] = KINDS.indexOf(material.kind);
  const set = (specular: Vec3, diffuse: Vec3 = [0, 0, 0]) => {
    floats.set(specular, 0);
    floats.set(diffuse, 4);
  };
  switch (material.kind) {
    case "mirror":
      set(material.reflectance);
      break;
    case "dielectric":
      floats[7] = material.index;
      break;
    case "dielectric_over_diffuse":
    case "coated":
      set([0, 0, 0], material.albedo);
      floats[7] = material.index;
      break;
    case "conductor":
      set(material.n);
      floats.set(material.k, 8);
      break;
    case "phong":
      set(material.specular, material.diffuse);
      break;
    case "ggx": {
      const { baseColor, metallic, roughness } = material;
      const [r, g, b] = baseColor;
      set(baseColor, [r * (1 - metallic), g * (1 - metallic), b * (1 - metallic)]);
      floats[7] = metallic;
      floats[11] = roughness;
      break;
    }
  }
  return data;
}
