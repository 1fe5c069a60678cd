import { afterEach, expect, test, vi } from "vitest";
import type { ActionAnswer } from "../src/api/client";
import { firstAnswer, holdAll, newRequestId } from "../src/api/hold";

const HELD: ActionAnswer = { ok: true, value: { action: "hold", results: [] } };
const LOST: ActionAnswer = { ok: false, message: "lost" };
const REFUSED: ActionAnswer = { ok: false, message: "refused", status: 403 };
const never = new Promise<ActionAnswer>(() => undefined);

afterEach(() => vi.unstubAllGlobals());

test("a hold of all goes out by both ways under one name, and the first answer counts", async () => {
  const fetched = vi.fn((_path: string, _init: { body: string }) => new Promise<Response>(() => undefined));
  vi.stubGlobal("fetch", fetched);
  const sent: string[] = [];
  const hold = (requestId: string): Promise<ActionAnswer> => {
    sent.push(requestId);
    return Promise.resolve(HELD);
  };
  expect(await holdAll({ hold })).toEqual(HELD);
  const body = JSON.parse(fetched.mock.calls[0]?.[1].body ?? "") as object;
  expect(body).toMatchObject({ action: "hold", vehicle_ids: null, request_id: sent[0] });
});

test("without a stream a hold goes out by its request alone", async () => {
  vi.stubGlobal("fetch", vi.fn().mockResolvedValue(new Response(JSON.stringify({ action: "hold", results: [] }))));
  expect(await holdAll({ hold: () => null })).toEqual(HELD);
});

test("a way that was lost says nothing about the other", async () => {
  expect(await firstAnswer([Promise.resolve(LOST), Promise.resolve(HELD)])).toEqual(HELD);
  expect(await firstAnswer([Promise.resolve(LOST), Promise.resolve(LOST)])).toEqual(LOST);
  expect(await firstAnswer([Promise.resolve(REFUSED), never])).toEqual(REFUSED);
});

test("names of requests differ", () => {
  const names = new Set(Array.from({ length: 100 }, newRequestId));
  expect(names.size).toBe(100);
  expect([...names][0]).toMatch(/^[0-9a-f]{32}$/);
});
