// Calls functions of the viewer's modules: node call.mjs CALLS.json, with [[module, function, arguments], …], prints what
// they return. Maps become lists of pairs, typed arrays lists of numbers.

import { readFile } from "node:fs/promises";
import { createServer } from "vite";

const plain = (_key, value) =>
  value instanceof Map ? [...value] : ArrayBuffer.isView(value) ? Array.from(value) : value;

const calls = JSON.parse(await readFile(process.argv[2], "utf8"));
const server = await createServer({ server: { middlewareMode: true }, appType: "custom", logLevel: "error" });
const results = [];
for (const [module, name, parameters] of calls) {
  const loaded = await server.ssrLoadModule(`/src/${module}.ts`);
  results.push(loaded[name](...parameters));
}
await server.close();
console.log(JSON.stringify(results, plain));
