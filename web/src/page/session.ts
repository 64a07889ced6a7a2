// A scene that plays on a graphics device, whatever becomes of that.

import { openSceneFile } from "../files/gltf";
import { openDevice, reopenDevice } from "../gpu/device/device";
import { Playback } from "../players/playback";
import type { Listener, Player } from "../players/player";
import { Shading } from "../players/shading";
import { readPem } from "../scene/pem";
import { readShadedScene } from "../scene/shaded-scene";

const MOST_LOSSES = 3; // within
const SHORT_MS = 60_000;
const TELLING_MS = 1000; // in which a device says that it is lost, after something failed for that

/** Opens the scene at an address and plays it on a canvas until the signal is aborted. Rejects with one sentence. */
export async function play(
  canvas: HTMLCanvasElement,
  address: string,
  listener: Listener,
  signal: AbortSignal,
): Promise<Player> {
  const opening = openDevice(); // at the same time
  const reading = readPlayer(canvas, address, listener, signal);
  reading.catch(() => opening.then((device) => device.destroy()).catch(() => {}));
  const [player] = await Promise.all([reading, opening]);
  await new Promise<void>((started, failed) => {
    keepOnDevices(player, opening, listener, signal, started).catch((error: Error) => {
      failed(error);
      if (!signal.aborted) listener.failed(error.message);
    });
  });
  return player;
}

async function readPlayer(
  canvas: HTMLCanvasElement,
  address: string,
  listener: Listener,
  signal: AbortSignal,
): Promise<Player> {
  const scene = await openSceneFile(address, signal);
  const [pem, shaded] = await Promise.all([readPem(scene), readShadedScene(scene)]);
  if (pem) return new Playback(canvas, pem, listener);
  if (shaded) return new Shading(canvas, shaded, listener);
  throw new Error(`${address} is a plain glTF file, with nothing in it that this viewer knows to show.`);
}

/** Plays on one device after the other, each until it is lost: camera, settings and panel are the player's and stay. */
async function keepOnDevices(
  player: Player,
  first: Promise<GPUDevice>,
  listener: Listener,
  signal: AbortSignal,
  started: () => void,
): Promise<void> {
  let losses: number[] = [];
  let current: GPUDevice | undefined;
  signal.addEventListener("abort", () => {
    player.stop();
    current?.destroy();
  });
  for (let opening = first; ; opening = reopenDevice()) {
    const device = await opening;
    if (signal.aborted) return device.destroy();
    current = device;
    device.addEventListener("uncapturederror", ({ error }) => {
      if (error instanceof GPUOutOfMemoryError) {
        listener.failed(
          "The graphics device has too little memory for this; close other pages that use it, and reload.",
        );
      }
    });
    const works = await player.start(device).then(
      () => true,
      async (error: unknown) => {
        if (await isLost(device)) return false;
        throw error;
      },
    );
    if (works) started();
    await device.lost;
    player.stop();
    if (signal.aborted) return;
    const now = performance.now();
    losses = [...losses.filter((time) => now - time < SHORT_MS), now];
    if (losses.length >= MOST_LOSSES) {
      throw new Error(
        `The graphics device was lost ${losses.length} times within a minute; close other pages and programs that use ` +
          "it, and reload this one.",
      );
    }
  }
}

const isLost = (device: GPUDevice): Promise<boolean> =>
  Promise.race([
    device.lost.then(() => true),
    new Promise<boolean>((resolve) => setTimeout(() => resolve(false), TELLING_MS)),
  ]);
