// Tells the service worker which files the built page consists of, and names the build after them.
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const folder = fileURLToPath(new URL("../../aos_gcs/api/static", import.meta.url));
const worker = join(folder, "service-worker.js");
/** Literal in the worker's source, in the quotes of the minifier's choice. */
const PLACE = /JSON\.parse\((?:'"PAGE_FILES"'|"\\"PAGE_FILES\\""|`"PAGE_FILES"`)\)/;

const paths = readdirSync(join(folder, "assets"))
  .map((name) => `/assets/${name}`)
  .sort();
const build = createHash("sha256");
for (const path of ["/index.html", ...paths]) build.update(path).update(readFileSync(join(folder, path)));
const files = { build: build.digest("hex").slice(0, 16), paths };

const source = readFileSync(worker, "utf-8");
if (!PLACE.test(source)) throw new Error("service-worker.js has no place for the list of files");
writeFileSync(
  worker,
  source.replace(PLACE, () => JSON.stringify(files)),
);
