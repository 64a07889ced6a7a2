// Opens PEMs of several kinds and writes down what the viewer shows: node kinds.mjs FOLDER KINDS, with KINDS (JSON: by name
// {address, viewpoint, steps}) served, where each is seen from, and what else is done there. Judging is
// tests/view/test_kinds.py's part.

import { withViewer } from "./viewer-page.mjs";

const [folder, kinds] = process.argv.slice(2);

await withViewer(folder, async ({ page, viewer, keep, picture, seen }) => {
  const check = async (role, name, as = true) => await page.getByRole(role, { name }).setChecked(as);
  // Frames are named by kind and step. Each step leaves the settings as it found them, but for the last.
  const STEPS = {
    multisampled: (frame) => keep(frame, "multisampled"),
    origin: async (frame) => {
      await check("radio", "By origin");
      await keep(frame, 4);
      await check("radio", "As seen");
    },
    without: async (frame) => {
      await check("checkbox", "Local", false);
      await keep(frame, 4);
      await check("checkbox", "Local");
    },
    maps: async () => {
      await picture("alpha", { view: "maps", layer: 0, mapShows: "alpha" });
      await picture("distance", { view: "maps", layer: 0, mapShows: "distance" });
      await picture("base", { view: "maps", layer: 1, mapShows: "distance", mapOf: "base" }); // it has no relief
    },
    far: async (frame) => {
      await check("checkbox", "balls 0", false);
      await keep(frame, 4);
      await STEPS.origin(`${frame}-origin`);
      await check("checkbox", "balls 0");
    },
    "infinite-sphere": async (frame) => {
      await page.getByRole("combobox", { name: "Geometry" }).selectOption("infinite sphere, all shells");
      await keep(frame, 4);
    },
  };

  for (const [name, { address, viewpoint, steps }] of Object.entries(JSON.parse(kinds))) {
    await page.goto(address);
    await viewer((element) => element.ready);
    if (name === "static") {
      seen.settledSize = await viewer(async (element) => {
        await element.settled();
        const { width, height } = element.shadowRoot.querySelector("canvas");
        return [width, height];
      });
    }
    await viewer((element, to) => {
      element.viewpoint = to;
    }, viewpoint);
    await keep(name, 4);
    const panel = steps.findIndex((step) => !["multisampled", "maps"].includes(step)); // pictures are taken without it
    for (const [k, step] of steps.entries()) {
      if (k === panel) await page.getByRole("button", { name: "Settings" }).click();
      await STEPS[step](`${name}-${step}`);
    }
  }
});
