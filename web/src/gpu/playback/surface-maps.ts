// Local light of rough surfaces on the device: twin of reflet.render.playback.surface_maps, described in surface_light.wgsl.

import type { SurfaceLayer } from "../../scene/surface-layer";

const ROWS = 4096; // sites in a layer of the texture

/** (resolution, offset) of each triangle, and behind them the sites of all samples. */
export function sitesOf({ resolution, offset, site }: SurfaceLayer): Uint32Array {
  const out = new Uint32Array(2 * resolution.length + site.length + (site.length % 2));
  resolution.forEach((value, k) => {
    out[2 * k] = value;
    out[2 * k + 1] = offset[k] as number;
  });
  out.set(site, 2 * resolution.length);
  return out;
}

/** All maps, a row of texels each; without them one texel. */
export function createSurfaceMaps(device: GPUDevice, surface: SurfaceLayer | undefined): GPUTexture {
  const light = surface?.light ?? new Uint16Array(4);
  const texels = surface ? surface.side ** 2 : 1;
  const sites = light.length / (4 * texels);
  const texture = device.createTexture({
    size: [texels, Math.min(sites, ROWS), Math.ceil(sites / ROWS)],
    format: "rgba16float",
    usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
  });
  for (let first = 0; first < sites; first += ROWS) {
    const rows = Math.min(ROWS, sites - first);
    const some = light.subarray(4 * texels * first, 4 * texels * (first + rows)) as Uint16Array<ArrayBuffer>;
    const target = { texture, origin: [0, 0, first / ROWS] };
    device.queue.writeTexture(target, some, { bytesPerRow: 8 * texels, rowsPerImage: rows }, [texels, rows, 1]);
  }
  return texture;
}
