/**
 * Files of the page in the browser's cache, so that it opens without the station.
 *
 * Only files of the build are ever stored or answered: whatever the API says, sign-ins among it, goes to the network.
 * The page itself comes from the station whenever that answers, so that a page is never older than its station.
 */

/** What the cache needs of a browser, so that tests can give it another. */
export interface Surroundings {
  readonly caches: Pick<CacheStorage, "open" | "keys" | "delete">;
  fetch(request: Request | string, init?: RequestInit): Promise<Response>;
}

/** Files of one build. */
export interface PageFiles {
  /** Name of the build. */
  readonly build: string;
  /** Paths below the root; the page itself is `/`. */
  readonly paths: readonly string[];
}

const PREFIX = "aos-gcs-page-";
const PAGE = "/";
/** Time after which a station that has not sent the page counts as out of reach: a network may swallow requests. */
const PAGE_WITHIN_MS = 5000;
/** Answers of proxies whose station is out of reach. */
const OUT_OF_REACH: ReadonlySet<number> = new Set([502, 504]);

export class PageCache {
  private readonly name: string;

  constructor(
    private readonly files: PageFiles,
    private readonly surroundings: Surroundings,
  ) {
    this.name = PREFIX + files.build;
  }

  /** Store all files of the build; fails, and stores none, if the station no longer has the same build. */
  async install(): Promise<void> {
    const { caches, fetch } = this.surroundings;
    try {
      const cache = await caches.open(this.name);
      const page = await fetch(PAGE, { cache: "no-cache" });
      const text = page.ok ? await page.clone().text() : "";
      if (!this.scripts.every((path) => text.includes(path))) throw new Error("the station has another build");
      await cache.put(PAGE, page);
      for (const path of this.files.paths) {
        const response = await fetch(path);
        if (!response.ok) throw new Error(`${path}: ${response.status}`);
        await cache.put(path, response);
      }
    } catch (error) {
      await caches.delete(this.name).catch(() => false);
      throw error;
    }
  }

  /** Remove the files of other builds. */
  async removeOthers(): Promise<void> {
    const { caches } = this.surroundings;
    const others = (await caches.keys()).filter((name) => name.startsWith(PREFIX) && name !== this.name);
    await Promise.all(others.map((name) => caches.delete(name)));
  }

  /** Answer to a request; null for what is none of the page's files, which is left to the browser. */
  answer(request: Pick<Request, "method" | "mode" | "url">, origin: string): Promise<Response> | null {
    const url = new URL(request.url);
    if (request.method !== "GET" || url.origin !== origin) return null;
    if (url.pathname === PAGE && request.mode === "navigate") return this.page();
    return this.files.paths.includes(url.pathname) && url.search === "" ? this.file(url.pathname) : null;
  }

  /** The page of the station, or the stored one while that is out of reach. */
  private async page(): Promise<Response> {
    const { fetch } = this.surroundings;
    const wanted = fetch(PAGE, { cache: "no-cache", signal: AbortSignal.timeout(PAGE_WITHIN_MS) });
    const sent = await wanted.catch(() => null);
    if (sent !== null && !OUT_OF_REACH.has(sent.status)) return sent;
    return (await this.stored(PAGE)) ?? sent ?? Response.error();
  }

  /** A file whose name changes with its content. */
  private async file(path: string): Promise<Response> {
    return (await this.stored(path)) ?? (await this.surroundings.fetch(path));
  }

  private async stored(path: string): Promise<Response | undefined> {
    try {
      const cache = await this.surroundings.caches.open(this.name);
      return await cache.match(path);
    } catch {
      return undefined; // storage that is forbidden
    }
  }

  private get scripts(): readonly string[] {
    return this.files.paths.filter((path) => /\/index-[^/]+\.js$/.test(path));
  }
}
