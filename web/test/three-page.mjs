// A glTF file under an environment as three.js shows it by its own loaders: what benchmarks/beside_three.py compares.
// Served to a browser; see three.mjs.

import {
  EquirectangularReflectionMapping,
  FloatType,
  MeshStandardMaterial,
  NearestFilter,
  NoToneMapping,
  PerspectiveCamera,
  Scene,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";

const LIBRARIES = "/node_modules/three/examples/jsm/libs";
const PLACE = 32768; // bytes that become characters at a time

const renderer = new WebGLRenderer({ antialias: false });
renderer.toneMapping = NoToneMapping;
const loader = new GLTFLoader()
  .setDRACOLoader(new DRACOLoader().setDecoderPath(`${LIBRARIES}/draco/gltf/`))
  .setKTX2Loader(new KTX2Loader().setTranscoderPath(`${LIBRARIES}/basis/`).detectSupport(renderer))
  .setMeshoptDecoder(MeshoptDecoder);
const loaded = new Map(); // by address: a model's scene, an environment's texture

async function model(address) {
  if (!loaded.has(address)) {
    const { scene, parser } = await loader.loadAsync(address);
    scene.traverse((mesh) => {
      if (!mesh.isMesh) return;
      if (parser.associations.get(mesh.material)?.materials === undefined) mesh.material = withoutMaterial();
      // What neither the path traced reference nor reflet has.
      Object.assign(mesh.material, { sheen: 0, iridescence: 0, anisotropy: 0, dispersion: 0 });
    });
    loaded.set(address, scene);
  }
  return loaded.get(address);
}

/** What reflet takes a mesh without a material for: a mirror. */
function withoutMaterial() {
  const material = new MeshStandardMaterial({ metalness: 1, roughness: 0 });
  material.color.setRGB(0.65, 0.65, 0.65);
  return material;
}

async function environment(address) {
  if (!loaded.has(address)) {
    const texture = await new HDRLoader().loadAsync(address);
    texture.mapping = EquirectangularReflectionMapping;
    loaded.set(address, texture);
  }
  return loaded.get(address);
}

/**
 * Linear radiance, three float32 a pixel in rows from the top, each the mean over `across`² points; as base64.
 *
 * `shot` has the addresses `model` and `environment`, and the camera's `position`, `target`, `up`, `fov` (degrees, vertical),
 * `near` and `far`; pictures have `size`² pixels.
 */
export async function picture(shot, size, across) {
  const scene = new Scene();
  scene.add(await model(shot.model));
  scene.environment = scene.background = await environment(shot.environment);
  const camera = new PerspectiveCamera(shot.fov, 1, shot.near, shot.far);
  camera.position.fromArray(shot.position);
  camera.up.fromArray(shot.up);
  camera.lookAt(...shot.target);
  const points = size * across;
  const target = new WebGLRenderTarget(points, points, {
    type: FloatType,
    minFilter: NearestFilter,
    magFilter: NearestFilter,
  });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const read = new Float32Array(points * points * 4); // rows from the bottom
  renderer.readRenderTargetPixels(target, 0, 0, points, points, read);
  renderer.setRenderTarget(null);
  target.dispose();
  const mean = new Float32Array(size * size * 3);
  for (let y = 0; y < points; y++)
    for (let x = 0; x < points; x++) {
      const pixel = (size - 1 - Math.floor(y / across)) * size + Math.floor(x / across);
      for (let c = 0; c < 3; c++) mean[pixel * 3 + c] += read[(y * points + x) * 4 + c] / across ** 2;
    }
  return base64(new Uint8Array(mean.buffer));
}

function base64(bytes) {
  let text = "";
  for (let at = 0; at < bytes.length; at += PLACE) text += String.fromCharCode(...bytes.subarray(at, at + PLACE));
  return btoa(text);
}
