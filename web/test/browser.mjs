// Headless Chromium with WebGPU on its software rasterizer.

import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const FLAGS = [
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--enable-unsafe-webgpu",
  "--use-webgpu-adapter=swiftshader",
  "--enable-features=Vulkan",
  "--use-vulkan=swiftshader",
  "--use-angle=swiftshader",
  "--disable-gpu-watchdog", // which takes a rasterizer in software that compiles for long for one that hangs
];

const PATIENCE = 300_000; // ms for any one step: a hang, on a machine however busy

/** Runs `use(page)` in a fresh browser; pictures have `scale` pixels for each of the page's. */
export async function withPage(use, { width, height, scale }) {
  const profile = await mkdtemp(join(tmpdir(), "reflet-browser-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    headless: true,
    args: FLAGS,
    viewport: { width, height },
    deviceScaleFactor: scale,
    reducedMotion: "reduce",
    timeout: PATIENCE,
  });
  context.setDefaultTimeout(PATIENCE);
  await context.addInitScript(countLosses);
  try {
    return await use(context.pages()[0] ?? (await context.newPage()));
  } finally {
    await context.close();
    await rm(profile, { recursive: true, force: true });
  }
}

/** Ends the graphics process, and waits until the page's device is lost. */
export async function loseDevice(page) {
  const session = await page.context().newCDPSession(page);
  const before = await page.evaluate(() => window.losses);
  await session.send("Browser.crashGpuProcess");
  await page.waitForFunction((count) => window.losses > count, before);
}

function countLosses() {
  window.losses = 0;
  if (!window.GPUAdapter) return; // pages that are not secure have none
  const { requestDevice } = GPUAdapter.prototype;
  GPUAdapter.prototype.requestDevice = async function (description) {
    const device = await requestDevice.call(this, description);
    device.lost.then(() => {
      window.losses += 1;
    });
    return device;
  };
}
