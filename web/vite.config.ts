import { defineConfig } from "vitest/config";

export default defineConfig({
  // tsconfig.json names preact's JSX runtime; Vite's transformer reads it from there.
  build: {
    outDir: "../aos_gcs/api/static",
    emptyOutDir: true,
    target: "es2022",
    chunkSizeWarningLimit: 1100, // MapLibre
    rollupOptions: {
      input: { index: "index.html", "service-worker": "src/offline/service_worker.ts" },
      // A service worker serves what lies below its own path, under a name that stays.
      output: {
        entryFileNames: ({ name }) => (name === "service-worker" ? "[name].js" : "assets/[name]-[hash].js"),
        // What all views share is one file, with the styles of all: their order stays the same whatever is opened first.
        // Beside it there is one file per view and language, and one for what draws maps.
        codeSplitting: {
          groups: [
            {
              name: "shared",
              test: /uplot\/.*\.css$|\/src\/(?!texts\/|views\/.*\.tsx?$|offline\/(service|page_cache)|map\/view|map\/layers\/basemap)/,
            },
            { name: "maplibre", test: /\/node_modules\/maplibre-gl\/|\/src\/map\/view/ },
          ],
        },
      },
    },
  },
  server: {
    proxy: { "/api": { target: "http://127.0.0.1:8080", ws: true } },
  },
  test: { include: ["tests/**/*.test.ts"], environment: "node", setupFiles: "tests/setup.ts" },
});
