import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { defineConfig } from "vite";

const LIBRARIES = { "ktx-parse": "LICENSE", meshoptimizer: "LICENSE.md" };
const LICENCES = Object.entries(LIBRARIES).map(
  ([name, file]) => `In it is ${name}:\n${readFileSync(`node_modules/${name}/${file}`, "utf8")}`,
);

export default defineConfig({
  base: "./",
  // Its decoder without WebAssembly, which a page's content security policy would have to allow.
  resolve: {
    alias: { "meshoptimizer/decoder": resolve("node_modules/meshoptimizer/meshopt_decoder_reference.js") },
  },
  build: {
    outDir: "../src/reflet/view/static",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
    // One script of a fixed name: other pages can load it and use <reflet-viewer>.
    rollupOptions: {
      output: { entryFileNames: "reflet-viewer.js", banner: `/*! reflet-viewer, Apache-2.0. ${LICENCES.join("\n")}*/` },
    },
  },
});
