// Textures of one picture size, made when first drawn into, and the sum of pictures.

export const DEPTH: GPUTextureFormat = "depth32float";

export class Target {
  readonly sum: GPUBuffer;
  private readonly textures = new Map<string, GPUTexture>();

  constructor(
    private readonly device: GPUDevice,
    readonly width: number,
    readonly height: number,
  ) {
    this.sum = device.createBuffer({
      size: 16 * width * height,
      usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST,
    });
  }

  texture(format: GPUTextureFormat, sampleCount = 1): GPUTexture {
    const key = `${format} ${sampleCount}`;
    let texture = this.textures.get(key);
    if (texture === undefined) {
      const single = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_SRC;
      texture = this.device.createTexture({
        size: [this.width, this.height],
        format,
        sampleCount,
        usage: GPUTextureUsage.RENDER_ATTACHMENT | (sampleCount === 1 ? single : 0),
      });
      this.textures.set(key, texture);
    }
    return texture;
  }

  destroy(): void {
    this.sum.destroy();
    for (const texture of this.textures.values()) texture.destroy();
  }
}
