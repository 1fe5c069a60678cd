/** Pages without the station: what is kept, what is answered from it, and what never is. */
import { beforeEach, describe, expect, test, vi } from "vitest";
import type { PageMessage } from "../src/api/socket";
import { type KeptState, LastState, SAVE_INTERVAL_MS, type Shelf } from "../src/offline/last_state";
import { PageCache, type PageFiles } from "../src/offline/page_cache";
import { INITIAL_STATE, reduce, restore, type State } from "../src/state/state";
import { mission } from "./samples";

const ORIGIN = "https://station";
const FILES: PageFiles = { build: "b1", paths: ["/assets/german-2.js", "/assets/index-1.js"] };
const PAGE_TEXT = '<script src="/assets/index-1.js">';

/** Caches of a browser, by name and path. */
class FakeCaches {
  readonly stored = new Map<string, Map<string, Response>>();
  async open(name: string): Promise<Cache> {
    const files = this.stored.get(name) ?? new Map<string, Response>();
    this.stored.set(name, files);
    return {
      match: async (path: string) => files.get(path)?.clone(),
      put: async (path: string, response: Response) => void files.set(path, response),
    } as unknown as Cache;
  }
  keys = async (): Promise<string[]> => [...this.stored.keys()];
  delete = async (name: string): Promise<boolean> => this.stored.delete(name);
}

const navigation = (path: string) => ({ method: "GET", mode: "navigate" as const, url: ORIGIN + path });
const script = (path: string, method = "GET") => ({ method, mode: "cors" as const, url: ORIGIN + path });

describe("files of the page", () => {
  let caches: FakeCaches;
  let station: Record<string, () => Response>;
  let cache: PageCache;

  beforeEach(async () => {
    caches = new FakeCaches();
    station = {
      "/": () => new Response(PAGE_TEXT),
      "/assets/index-1.js": () => new Response("index"),
      "/assets/german-2.js": () => new Response("german"),
    };
    const fetch = async (request: Request | string): Promise<Response> => {
      const answer = station[String(request)];
      if (answer === undefined) throw new TypeError("no network");
      return answer();
    };
    cache = new PageCache(FILES, { caches, fetch });
    await cache.install();
  });

  test("are answered without the station", async () => {
    station = {};
    const page = await cache.answer(navigation("/"), ORIGIN);
    expect(await page?.text()).toBe(PAGE_TEXT);
    const index = await cache.answer(script("/assets/index-1.js"), ORIGIN);
    expect(await index?.text()).toBe("index");
  });

  test("the page is the station's own whenever that answers, a refusal as well", async () => {
    station["/"] = () => new Response("newer");
    expect(await (await cache.answer(navigation("/"), ORIGIN))?.text()).toBe("newer");
    station["/"] = () => new Response("not built", { status: 503 });
    expect((await cache.answer(navigation("/"), ORIGIN))?.status).toBe(503);
  });

  test.each([502, 504])("a proxy that answers %i has no station", async (status) => {
    station["/"] = () => new Response("", { status });
    expect(await (await cache.answer(navigation("/"), ORIGIN))?.text()).toBe(PAGE_TEXT);
  });

  test.each([
    script("/api/session"),
    script("/api/session", "POST"),
    script("/api/mission"),
    script("/api/findings/1/thermal.png"),
    script("/"),
    script("/assets/index-1.js?x=1"),
    script("/assets/index-1.js", "POST"),
    script("/assets/index-0.js"),
    navigation("/elsewhere"),
    { method: "GET", mode: "cors" as const, url: "https://elsewhere/assets/index-1.js" },
  ])("nothing else is answered: $method $url", (request) => {
    expect(cache.answer(request, ORIGIN)).toBeNull();
  });

  test("only files of the build are stored", () => {
    expect([...(caches.stored.get("aos-gcs-page-b1")?.keys() ?? [])]).toEqual(["/", ...FILES.paths]);
  });

  test("a station with another build is no source for this one, and nothing half stored is left", async () => {
    station["/"] = () => new Response('<script src="/assets/index-9.js">');
    const another = new PageCache({ ...FILES, build: "b2" }, { caches, fetch: async (at) => station[String(at)]!() });
    await expect(another.install()).rejects.toThrow("another build");
    expect(await caches.keys()).toEqual(["aos-gcs-page-b1"]);
  });

  test("files of former builds are removed, those of other programs are not", async () => {
    await caches.open("aos-gcs-page-b0");
    await caches.open("of-another-program");
    await cache.removeOthers();
    expect(await caches.keys()).toEqual(["aos-gcs-page-b1", "of-another-program"]);
  });

  test("forbidden storage leaves the page to the station", async () => {
    const open = () => Promise.reject(new Error("SecurityError"));
    const forbidden = { ...caches, open, keys: caches.keys, delete: caches.delete };
    const own = new PageCache(FILES, { caches: forbidden, fetch: async (at) => station[String(at)]!() });
    await expect(own.install()).rejects.toThrow("SecurityError");
    expect(await (await own.answer(script("/assets/index-1.js"), ORIGIN))?.text()).toBe("index");
  });
});

class FakeShelf implements Shelf {
  value: unknown = undefined;
  problem: Error | null = null;
  puts = 0;
  async put(value: KeptState): Promise<void> {
    if (this.problem !== null) throw this.problem;
    this.puts += 1;
    this.value = value;
  }
  async get(): Promise<unknown> {
    if (this.problem !== null) throw this.problem;
    return this.value;
  }
  async clear(): Promise<void> {
    if (this.problem !== null) throw this.problem;
    this.value = undefined;
  }
}

const CLOCK_MS = 1_700_000_000_000;
const open = (changes: Partial<State> = {}): State => ({
  ...INITIAL_STATE,
  ...{ connection: "open", mission: mission(), missionAtMs: 900 },
  ...changes,
});

describe("the last state", () => {
  let shelf: FakeShelf;
  let nowMs: number;
  let last: LastState;

  beforeEach(() => {
    shelf = new FakeShelf();
    nowMs = 1000;
    last = new LastState(
      shelf,
      "b1",
      () => nowMs,
      () => CLOCK_MS,
    );
    last.admit(true);
  });

  test("is kept with the time at which it was valid, and recalled by the same build alone", async () => {
    await last.follow(open());
    expect(last.keeping).toBe("kept");
    expect(await last.recall()).toMatchObject({ validAtMs: CLOCK_MS - 100, mission: { mission_id: "m1" } });
    expect(await new LastState(shelf, "b2").recall()).toBeNull();
  });

  test("is written every few seconds, and only when something has changed", async () => {
    await last.follow(open());
    await last.follow(open({ missionAtMs: 950 }));
    nowMs += SAVE_INTERVAL_MS;
    await last.follow(open());
    expect(shelf.puts).toBe(1);
    await last.follow(open({ missionAtMs: 1100 }));
    expect(shelf.puts).toBe(2);
  });

  test("holds only what admitted screens are shown, live", async () => {
    last.admit(false);
    await last.follow(open());
    last.admit(true);
    await last.follow(open({ connection: "lost" }));
    await last.follow(open({ mission: null }));
    await last.follow(open({ mission: mission({ replay: { time_s: 0, duration_s: 1 } as never }) }));
    expect(shelf.puts).toBe(0);
  });

  test("is removed from a screen that may no longer see the mission, also while it is written", async () => {
    await last.follow(open());
    last.admit(false);
    await vi.waitFor(() => expect(shelf.value).toBeUndefined());
    last.admit(true);
    const writing = last.follow(open());
    last.admit(false);
    await writing;
    expect(shelf.value).toBeUndefined();
  });

  test("full or forbidden storage is said, and stops nothing", async () => {
    shelf.problem = new DOMException("full", "QuotaExceededError");
    const warn = vi.spyOn(console, "warn").mockReturnValue();
    await last.follow(open());
    expect(last.keeping).toBe("failed");
    expect(await last.recall()).toBeNull();
    shelf.problem = null;
    nowMs += SAVE_INTERVAL_MS;
    await last.follow(open({ missionAtMs: 2000 }));
    expect(last.keeping).toBe("kept");
    expect(warn).toHaveBeenCalledTimes(1);
  });

  test.each([undefined, null, 1, {}, { build: "b1", validAtMs: "x" }, { build: "b1", validAtMs: 1, mission: null }])(
    "what is none is not recalled: %j",
    async (value) => {
      shelf.value = value;
      expect(await last.recall()).toBeNull();
    },
  );
});

describe("a restored state", () => {
  const { capabilities, steps, latestStep, notices } = INITIAL_STATE;
  const told = { capabilities, steps, latestStep, notices };
  const kept: KeptState = { build: "b1", validAtMs: CLOCK_MS, mission: mission(), ...told };
  const lost = { ...INITIAL_STATE, connection: "lost" as const };

  test("is as old as the clock says, and unknown after a clock was set back", () => {
    const hour = restore(lost, kept, 5000, CLOCK_MS + 3_600_000);
    expect(5000 - hour.missionAtMs).toBe(3_600_000);
    expect([hour.connection, hour.keptAtMs]).toEqual(["lost", CLOCK_MS]);
    expect(5000 - restore(lost, kept, 5000, CLOCK_MS - 1).missionAtMs).toBe(Infinity);
  });

  test("is replaced by the station's, whatever its mission is", () => {
    const hello = {
      kind: "hello",
      ...{ seq: 1, utc_s: 0, schema_version: 5, mission_age_s: 0, seen: "s" },
      ...{ capabilities, steps, latest_step: null, notices, pictures: [], mission: mission({ mission_id: "m2" }) },
    } as unknown as PageMessage;
    const state = reduce(restore(lost, kept, 5000, CLOCK_MS), hello, 6000);
    expect([state.mission?.mission_id, state.formerMissionId, state.keptAtMs]).toEqual(["m2", null, null]);
    expect(state.missionAtMs).toBe(6000);
  });
});
