// Decodes coded maps and pictures in a browser: node coded-maps.mjs FOLDER. FOLDER/files.json lists {file, map?: {shape,
// channels}, picture?: {rows, columns}}; what they hold in half-float RGBA goes to FOLDER/FILE.u16, or what is said of a
// file that cannot be read to FOLDER/said.json, by its name. Judging is tests/view/test_coded_maps.py's part.

import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "vite";
import { withPage } from "./browser.mjs";

const folder = process.argv[2];
const items = JSON.parse(await readFile(join(folder, "files.json"), "utf8"));
const entry = fileURLToPath(new URL("../src/files/coded-light.ts", import.meta.url));
const lib = { entry, formats: ["iife"], name: "coded" };
const [{ output }] = await build({ configFile: false, logLevel: "error", build: { write: false, lib } });
const said = {};

await withPage(
  async (page) => {
    await page.route("**/blank", (route) => route.fulfill({ contentType: "text/html", body: "<!doctype html>" }));
    await page.goto("http://localhost/blank");
    await page.addScriptTag({ content: output[0].code });
    for (const item of items) {
      const data = (await readFile(join(folder, item.file))).toString("base64");
      const found = await page.evaluate(
        async ({ file, map, picture, data }) => {
          const buffer = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)).buffer;
          try {
            const parts = map
              ? await coded.codedMapLevels(buffer, map.shape, map.channels, file)
              : [await coded.codedPicture(buffer, picture, file)];
            return { halves: Array.from(new Uint16Array(await new Blob(parts).arrayBuffer())) };
          } catch (error) {
            return { said: error.message };
          }
        },
        { ...item, data },
      );
      if (found.halves) await writeFile(join(folder, `${item.file}.u16`), new Uint16Array(found.halves));
      else said[item.file] = found.said;
    }
  },
  { width: 64, height: 64, scale: 1 },
);

await writeFile(join(folder, "said.json"), JSON.stringify(said));
