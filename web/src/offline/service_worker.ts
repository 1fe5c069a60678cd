/** Service worker: opens the page while the station is out of reach. `scripts/list-files.mjs` fills in the files. */
import { PageCache, type PageFiles } from "./page_cache";

interface WorkerEvent extends Event {
  waitUntil(work: Promise<unknown>): void;
}

interface RequestEvent extends WorkerEvent {
  readonly request: Request;
  respondWith(answer: Promise<Response>): void;
}

/** What the worker uses of its global scope, whose types exclude those of pages. */
interface Worker {
  readonly caches: CacheStorage;
  readonly location: Location;
  readonly clients: { claim(): Promise<void> };
  fetch(request: Request | string, init?: RequestInit): Promise<Response>;
  skipWaiting(): Promise<void>;
  addEventListener(kind: "install" | "activate", listener: (event: WorkerEvent) => void): void;
  addEventListener(kind: "fetch", listener: (event: RequestEvent) => void): void;
}

const worker = globalThis as unknown as Worker;
const files = JSON.parse('"PAGE_FILES"') as PageFiles;
const cache = new PageCache(files, {
  caches: worker.caches,
  fetch: (request, init) => worker.fetch(request, init),
});

// A new worker takes over at once: it answers as the old one does as long as the station is reached.
worker.addEventListener("install", (event) => {
  event.waitUntil(cache.install().then(() => worker.skipWaiting()));
});
worker.addEventListener("activate", (event) => {
  event.waitUntil(cache.removeOthers().then(() => worker.clients.claim()));
});
worker.addEventListener("fetch", (event) => {
  const answer = cache.answer(event.request, worker.location.origin);
  if (answer !== null) event.respondWith(answer);
});
