// A page with a viewer, and what tests do with it. Frames and what was seen are written into a folder.

import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { withPage } from "./browser.mjs";

const browser = { width: 480, height: 360, scale: 0.25 }; // few pixels on the screen: they are drawn by software
const small = [64, 48];

/**
 * Runs `use(hands)` and writes `hands.seen` into the folder's seen.json. The hands: `page`; `viewer(f, argument)`, which
 * runs f with the element; its `viewpoint()`; `keep(name, samples, size)`, which writes a raw frame; and
 * `picture(name, settings)`, which writes the canvas alone.
 */
export async function withViewer(folder, use) {
  const seen = { complaints: [], frames: {} };
  await withPage(async (page) => {
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type())) seen.complaints.push(message.text());
    });
    page.on("pageerror", (error) => seen.complaints.push(error.message));

    const viewer = (use, argument) =>
      page.evaluate(`(${use})(document.querySelector("reflet-viewer"), ${JSON.stringify(argument)})`);
    const viewpoint = () => viewer((element) => element.viewpoint);
    const keep = async (name, samples, [width, height] = small) => {
      const radiance = await viewer(
        async (element, [w, h, s]) => Array.from((await element.rawFrame(w, h, s)).radiance),
        [width, height, samples],
      );
      await writeFile(join(folder, `${name}.f32`), new Float32Array(radiance));
      seen.frames[name] = { width, height, viewpoint: await viewpoint() };
    };
    const picture = async (name, settings) => {
      await page.addStyleTag({ content: "body { background: none }" });
      const show = (visibility) =>
        viewer((element, value) => {
          for (const part of element.shadowRoot.querySelectorAll(".toggle, .panel")) part.style.visibility = value;
        }, visibility);
      await show("hidden");
      await viewer((element, changed) => element.configure(changed), settings);
      await viewer((element) => element.settled());
      await page.screenshot({ path: join(folder, `${name}.png`) });
      await viewer((element) => element.configure({ view: "picture" }));
      await show("");
    };
    await use({ page, viewer, viewpoint, keep, picture, seen });
  }, browser);
  await writeFile(join(folder, "seen.json"), JSON.stringify(seen));
}
