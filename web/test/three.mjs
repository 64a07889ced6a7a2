// Pictures of glTF files by three.js: node three.mjs WANTED.json FOLDER, with WANTED {size, across, shots: [{name, model,
// environment, …}]}, `picture`'s parameters with paths for addresses; writes FOLDER/<name>.f32.

import { readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { createServer } from "vite";
import { withPage } from "./browser.mjs";

const [wanted, folder] = process.argv.slice(2);
const { size, across, shots } = JSON.parse(await readFile(wanted, "utf8"));
const server = await createServer({
  root: join(dirname(fileURLToPath(import.meta.url)), ".."),
  configFile: false,
  logLevel: "error",
  appType: "custom",
  optimizeDeps: { noDiscovery: true }, // it would reload the page
  server: { host: "127.0.0.1", hmr: false, ws: false, watch: null, fs: { strict: false } },
});
await server.listen();
const { port } = server.httpServer.address();
const origin = `http://127.0.0.1:${port}`;
const complaints = [];

try {
  await withPage(
    async (page) => {
      page.on("console", (message) => {
        if (message.type() === "error") complaints.push(message.text());
      });
      page.on("pageerror", (error) => complaints.push(error.message));
      await page.route(`${origin}/`, (route) => route.fulfill({ contentType: "text/html", body: "<!doctype html>" }));
      await page.goto(origin);
      for (const { name, model, environment, ...camera } of shots) {
        const shot = { ...camera, model: address(model), environment: address(environment) };
        const picture = await page.evaluate(
          async (parameters) => (await import("/test/three-page.mjs")).picture(...parameters),
          [shot, size, across],
        );
        await writeFile(join(folder, `${name}.f32`), Buffer.from(picture, "base64"));
      }
    },
    { width: 64, height: 64, scale: 1 },
  );
} finally {
  await server.close();
}
if (complaints.length > 0) {
  console.error(complaints.join("\n"));
  process.exitCode = 1;
}

function address(path) {
  return `/@fs${path.split("/").map(encodeURIComponent).join("/")}`;
}
