// Reads a PEM by the viewer's own modules: node read_pem.mjs FOLDER OUT, with the files of a folder for a server's. Writes
// the numbers of its scene as one JSON document, floats as their bits; or prints the sentence that it is refused by.

import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { createServer } from "vite";

const [folder, out] = process.argv.slice(2);
globalThis.document = { baseURI: "http://folder/" };
globalThis.location = { origin: "http://folder" };
globalThis.createImageBitmap = async () => ({ width: 1, height: 1 });
globalThis.fetch = async (address) => {
  const data = await readFile(join(folder, decodeURIComponent(new URL(address).pathname))).catch(() => undefined);
  return new Response(data ?? null, { status: data === undefined ? 404 : 200 });
};

const bits = (_key, value) =>
  value instanceof Float32Array
    ? Array.from(new Uint32Array(value.buffer, value.byteOffset, value.length))
    : ArrayBuffer.isView(value)
      ? Array.from(value)
      : value;

const server = await createServer({ server: { middlewareMode: true }, appType: "custom", logLevel: "error" });
try {
  const { openSceneFile } = await server.ssrLoadModule("/src/files/gltf.ts");
  const { readPem } = await server.ssrLoadModule("/src/scene/pem.ts");
  const pem = await readPem(await openSceneFile("http://folder/scene.gltf"));
  await writeFile(out, JSON.stringify(pem, bits));
  console.log(JSON.stringify("read"));
} catch (error) {
  console.log(JSON.stringify(error.message));
} finally {
  await server.close();
}
