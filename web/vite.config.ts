import { defineConfig } from "vite";

export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/reflet/view/static",
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
    // One script of a fixed name: other pages can load it and use <reflet-viewer>.
    rollupOptions: { output: { entryFileNames: "reflet-viewer.js" } },
  },
});
