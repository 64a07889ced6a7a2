// Prints the text of programs as the viewer's linker puts it together: node link.mjs picture backdrop …

import { createServer } from "vite";

const server = await createServer({ server: { middlewareMode: true }, appType: "custom", logLevel: "error" });
const { link } = await server.ssrLoadModule("/src/shaders.ts");
console.log(JSON.stringify(Object.fromEntries(process.argv.slice(2).map((program) => [program, link(program)]))));
await server.close();
