import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

/** urdf-loader brings its own COLLADA reader along; ours is fetched when a mesh needs it. */
const withoutCollada: Plugin = {
  name: "urdf-loader-without-collada",
  enforce: "pre",
  resolveId(source, importer) {
    const stranger = importer?.includes("urdf-loader") ?? false;
    return stranger && source.endsWith("/ColladaLoader.js") ? "\0no-collada" : null;
  },
  load(id) {
    return id === "\0no-collada" ? "export class ColladaLoader {}" : null;
  },
};

export default defineConfig({
  plugins: [withoutCollada],
  // bundled beforehand, it would bring the reader along again
  optimizeDeps: { exclude: ["urdf-loader"] },
  base: "./",
  build: {
    outDir: "../src/tool0/interfaces/panel/static",
    emptyOutDir: true,
    target: "es2022",
    chunkSizeWarningLimit: 900,
  },
  server: {
    // `npm run dev` beside a running `tool0 bringup`
    proxy: Object.fromEntries(
      ["/ws", "/robot.urdf", "/meshes"].map((path) => [
        path,
        { target: "http://127.0.0.1:8085", ws: true, changeOrigin: true },
      ]),
    ),
  },
  test: {
    environment: "happy-dom",
    reporters: "dot",
    include: ["tests/**/*.test.{ts,tsx}"],
  },
});
