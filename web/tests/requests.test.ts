import { afterEach, expect, test, vi } from "vitest";
import { postAction } from "../src/api/client";
import { readHandover } from "../src/api/handover";
import { readIntegral } from "../src/api/viewer";
import { chooseLanguage, texts } from "../src/texts";

const HOLD = { action: "hold", vehicleIds: null } as const;

afterEach(() => vi.unstubAllGlobals());

test("a page of a proxy in place of an answer is not taken for a lost connection", async () => {
  vi.stubGlobal("fetch", vi.fn().mockResolvedValue(new Response("<html>Bad gateway</html>", { status: 502 })));
  expect(await postAction(HOLD)).toMatchObject({ ok: false, message: texts.requests.unreadableAnswer });
});

test("nor is it where a hand-over is asked for", async () => {
  vi.stubGlobal("navigator", { language: "en-GB" });
  vi.stubGlobal("fetch", vi.fn().mockResolvedValue(new Response("<html>Bad gateway</html>", { status: 502 })));
  expect(await readHandover("decimal")).toMatchObject({ ok: false, message: texts.requests.unreadableAnswer });
});

test("nor is it where a step's picture is asked for", async () => {
  vi.stubGlobal("fetch", vi.fn().mockResolvedValue(new Response("<html>Bad gateway</html>", { status: 502 })));
  const answer = await readIntegral({ step: 7, kind: "thermal", height_m: null, isDraft: false });
  expect(answer).toMatchObject({ ok: false, message: texts.requests.unreadableAnswer });
});

test("a lost connection is told as one", async () => {
  vi.stubGlobal("fetch", vi.fn().mockRejectedValue(new TypeError("network")));
  expect(await postAction(HOLD)).toEqual({ ok: false, message: texts.requests.notSent });
});

test("a refusal of a step's picture is told in the operator's language", async () => {
  await chooseLanguage("de");
  const refused = new Response(JSON.stringify({ id: "x", message: "m-1 has no step 7" }), { status: 422 });
  vi.stubGlobal("fetch", vi.fn().mockResolvedValue(refused));
  const answer = await readIntegral({ step: 7, kind: "thermal", height_m: null, isDraft: false });
  expect(answer).toMatchObject({ ok: false, message: "m-1 hat keinen Schritt 7", status: 422 });
  await chooseLanguage("en");
});
