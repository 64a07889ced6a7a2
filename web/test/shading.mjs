// Uses the viewer of a shaded mesh as a person would and writes down what it shows: node shading.mjs ADDRESS FOLDER
// MATERIALS, with MATERIALS (JSON: settings by name) set one after the other. Judging is tests/view/test_shading.py's part.

import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { loseDevice, withPage } from "./browser.mjs";

const [address, folder, materials] = process.argv.slice(2);
const browser = { width: 480, height: 360, scale: 0.25 }; // few pixels on the screen: they are drawn by software
const [width, height] = [64, 48];
const seen = { complaints: [], settings: {} };

await withPage(async (page) => {
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) seen.complaints.push(message.text());
  });
  page.on("pageerror", (error) => seen.complaints.push(error.message));

  const viewer = (use, argument) =>
    page.evaluate(`(${use})(document.querySelector("reflet-viewer"), ${JSON.stringify(argument)})`);
  const keep = async (name, samples = 1) => {
    const radiance = await viewer(
      async (element, [w, h, s]) => Array.from((await element.rawFrame(w, h, s)).radiance),
      [width, height, samples],
    );
    await writeFile(join(folder, `${name}.f32`), new Float32Array(radiance));
    seen.settings[name] = await viewer((element) => element.settings);
  };

  await page.goto(address);
  await viewer((element) => element.ready);
  await keep("home");
  for (const [name, settings] of Object.entries(JSON.parse(materials))) {
    await viewer((element, value) => element.configure(value), settings);
    await keep(name);
  }
  await keep("all-samples", 16);
  await keep("multisampled", "multisampled");
  await viewer((element) => element.settled());

  // By the panel, found as a person finds things: by their names.
  await page.getByRole("button", { name: "Settings" }).click();
  await page.getByRole("combobox", { name: "Material" }).selectOption("Phong");
  await keep("phong-again");
  await page.getByRole("slider", { name: "Exponent" }).focus();
  for (let k = 0; k < 10; k++) await page.keyboard.press("ArrowRight");
  await keep("phong-by-keys");
  await page.getByRole("combobox", { name: "Material" }).selectOption("metal");
  await page.getByRole("combobox", { name: "Metal" }).selectOption("Cu");
  await keep("copper");
  await page.getByRole("checkbox", { name: "Backdrop" }).uncheck();
  await keep("alone");

  // The light by shift-drag and by keys.
  const { x, y, width: w, height: h } = await page.locator("canvas").boundingBox();
  await page.keyboard.down("Shift");
  await page.mouse.move(x + w / 8, y + h / 2);
  await page.mouse.down();
  await page.mouse.move(x + w / 8 + 40, y + h / 2, { steps: 2 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  await keep("turned");
  seen.viewpoint = await viewer((element) => element.viewpoint);
  await page.locator("canvas").focus();
  await page.keyboard.press("]");
  await page.keyboard.press("l");
  await page.keyboard.press(".");
  seen.lampByKeys = (await viewer((element) => element.settings)).lamp;
  await page.getByRole("slider", { name: "Radius" }).focus();
  await page.keyboard.press("ArrowRight");
  await page.getByRole("checkbox", { name: "Circling" }).check();
  seen.lampByPanel = (await viewer((element) => element.settings)).lamp;
  await page.waitForFunction(
    (azimuth) => document.querySelector("reflet-viewer").settings.lamp.azimuth !== azimuth,
    seen.lampByPanel.azimuth,
  );
  await page.getByRole("checkbox", { name: "Circling" }).uncheck();
  await page.getByRole("checkbox", { name: "Lamp" }).uncheck();
  seen.afterKey = await viewer((element) => element.settings);
  seen.unknown = await viewer((element) =>
    ["map", "table", "velvet"].map((kind) => {
      try {
        return element.configure({ material: { kind, [kind]: "nothing" } });
      } catch (error) {
        return error.message;
      }
    }),
  );

  // The graphics process ends while a lamp shines.
  await viewer((element) => element.configure({ lamp: { on: true } }));
  await keep("before-loss");
  const complaints = [...seen.complaints]; // the browser tells of its own crash
  await loseDevice(page);
  await keep("after-loss");
  seen.complaints = complaints;
}, browser);

await writeFile(join(folder, "seen.json"), JSON.stringify(seen));
