import { readFileSync } from "node:fs";
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

const LICENSES = "licenses.md";
const APACHE = "## The Apache License 2.0, as of the packages above that name it\n";

/** urdf-loader names the licence of this project, without its text. */
const withApacheText: Plugin = {
  name: "licenses-with-apache-text",
  apply: "build",
  generateBundle: {
    order: "post",
    handler(_, bundle) {
      const notices = bundle[LICENSES];
      if (notices?.type !== "asset") throw new Error(`there is no ${LICENSES}`);
      const text = readFileSync(new URL("../LICENSE", import.meta.url), "utf8");
      notices.source = `${String(notices.source)}\n${APACHE}\n${text}`;
    },
  },
};

export default defineConfig({
  plugins: [withoutCollada, withApacheText],
  // bundled beforehand, it would bring the reader along again
  optimizeDeps: { exclude: ["urdf-loader"] },
  base: "./",
  build: {
    outDir: "../src/tool0/panel/static",
    emptyOutDir: true,
    license: { fileName: LICENSES },
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
