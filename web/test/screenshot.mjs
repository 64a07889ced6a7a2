// A picture of the viewer with its settings open, once it has settled: node screenshot.mjs ADDRESS FILE.png [SETTINGS]
// SETTINGS (JSON) are what `configure` takes.

import { withPage } from "./browser.mjs";

const [address, file, settings = "{}"] = process.argv.slice(2);

await withPage(
  async (page) => {
    await page.goto(address);
    await page.evaluate(async (chosen) => {
      const viewer = document.querySelector("reflet-viewer");
      await viewer.ready;
      viewer.configure(chosen);
      await viewer.settled();
    }, JSON.parse(settings));
    await page.screenshot({ path: file, timeout: 0 });
  },
  { width: 1100, height: 680, scale: 1 },
);
