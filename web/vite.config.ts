import { defineConfig } from "vitest/config";

export default defineConfig({
  // tsconfig.json names preact's JSX runtime; Vite's transformer reads it from there.
  build: {
    outDir: "../aos_gcs/api/static",
    emptyOutDir: true,
    target: "es2022",
    chunkSizeWarningLimit: 1300,
    rollupOptions: {
      input: { index: "index.html", "service-worker": "src/offline/service_worker.ts" },
      // A service worker serves what lies below its own path, under a name that stays.
      output: { entryFileNames: ({ name }) => (name === "service-worker" ? "[name].js" : "assets/[name]-[hash].js") },
    },
  },
  server: {
    proxy: { "/api": { target: "http://127.0.0.1:8080", ws: true } },
  },
  test: { include: ["tests/**/*.test.ts"], environment: "node" },
});
