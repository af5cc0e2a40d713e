import { defineConfig } from "vitest/config";

export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/tool0/panel/static",
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
  test: { environment: "happy-dom", include: ["tests/**/*.test.{ts,tsx}"] },
});
