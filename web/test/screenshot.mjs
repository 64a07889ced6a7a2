// A picture of the viewer with its settings open, once it has settled: node screenshot.mjs ADDRESS FILE.png

import { withPage } from "./browser.mjs";

const [address, file] = process.argv.slice(2);

await withPage(
  async (page) => {
    await page.goto(address);
    await page.evaluate(() => document.querySelector("reflet-viewer").settled());
    await page.screenshot({ path: file, timeout: 0 });
  },
  { width: 1100, height: 680, scale: 1 },
);
