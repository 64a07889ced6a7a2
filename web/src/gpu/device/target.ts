// Textures of one picture size, made when first drawn into, and the sum of pictures: twin of reflet.render.playback.target.

export const DEPTH: GPUTextureFormat = "depth32float";

export class Target {
  readonly sum: GPUBuffer;
  /** After how many samples each pixel had enough, 0 while it takes all. */
  readonly enough: GPUBuffer;
  private spreads: GPUBuffer | undefined;
  private readonly textures = new Map<string, GPUTexture>();

  constructor(
    private readonly device: GPUDevice,
    readonly width: number,
    readonly height: number,
  ) {
    this.sum = this.buffer(16);
    this.enough = this.buffer(4);
  }

  /** How far each pixel's samples lie apart, where they are taken where they count. */
  get spread(): GPUBuffer {
    this.spreads ??= this.buffer(8);
    return this.spreads;
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
    for (const buffer of [this.sum, this.enough, this.spreads]) buffer?.destroy();
    for (const texture of this.textures.values()) texture.destroy();
  }

  private buffer(bytesAPixel: number): GPUBuffer {
    return this.device.createBuffer({
      size: bytesAPixel * this.width * this.height,
      usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST,
    });
  }
}
