import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { ProtocolError, parseServerMessage } from "../src/api/check";
import { backoffMs, type Connection, EventSocket, isGap, type PageMessage, type StateOrEvent } from "../src/api/socket";
import { CAPABILITIES, figures, mission, step } from "./samples";

const HELLO = {
  kind: "hello",
  seq: 1,
  schema_version: 5,
  mission_age_s: 0,
  seen: "m-1/0/0",
  capabilities: CAPABILITIES,
  mission: mission(),
  steps: [figures(1)],
  latest_step: step(1),
  notices: [],
  pictures: [],
} as const;

describe("parseServerMessage", () => {
  test("takes what the schema allows", () => {
    expect(parseServerMessage(JSON.stringify(HELLO)).kind).toBe("hello");
    const heartbeat = { kind: "heartbeat", seq: 4, mission_age_s: 0.5, seen: "m-1/0/0" };
    expect(parseServerMessage(JSON.stringify(heartbeat))).toEqual(heartbeat);
  });
  test.each([
    ["no JSON", "{"],
    ["an unknown kind", '{"kind":"toString","seq":1}'],
    ["no number", '{"kind":"heartbeat","mission_age_s":0,"seen":"m-1/0/0"}'],
    ["a heartbeat that does not tell of the mission", '{"kind":"heartbeat","seq":1}'],
    ["another version", JSON.stringify({ ...HELLO, schema_version: 1 })],
    ["a vehicle without an id", JSON.stringify({ ...HELLO, mission: { ...mission(), vehicles: [{}] } })],
  ])("refuses %s", (_, text) => {
    expect(() => parseServerMessage(text)).toThrow(ProtocolError);
  });
});

test("events count on by one, all other messages repeat the number before them", () => {
  const heartbeat = (seq: number): StateOrEvent => ({ kind: "heartbeat", seq, mission_age_s: 0, seen: "m-1/0/0" });
  const changes = (seq: number): StateOrEvent => ({
    kind: "changes",
    seq,
    mission_age_s: 0,
    seen: "m-1/0/0",
    utc_s: 0,
    mission: {},
    vehicles: [],
    preflight: [],
  });
  const event = (seq: number): StateOrEvent => ({ kind: "step", seq, utc_s: 0, step: step(2) });
  expect(isGap(4, HELLO as unknown as StateOrEvent)).toBe(false);
  expect([event(5), changes(4), heartbeat(4)].map((message) => isGap(4, message))).toEqual([false, false, false]);
  expect([event(6), changes(5), heartbeat(5)].map((message) => isGap(4, message))).toEqual([true, true, true]);
});

test("waits longer and longer, up to five seconds", () => {
  expect([0, 1, 2, 10].map(backoffMs)).toEqual([250, 500, 1000, 5000]);
});

class FakeSocket {
  static opened: FakeSocket[] = [];
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;
  isClosed = false;
  constructor() {
    FakeSocket.opened.push(this);
  }
  readonly sent: string[] = [];
  close(): void {
    this.isClosed = true;
  }
  send(text: string): void {
    this.sent.push(text);
  }
  say(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
}

describe("EventSocket", () => {
  const connections: Connection[] = [];
  const heard: PageMessage[] = [];
  let events: EventSocket;
  const latest = (): FakeSocket => FakeSocket.opened.at(-1) as FakeSocket;

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("WebSocket", FakeSocket);
    FakeSocket.opened = [];
    connections.length = 0;
    heard.length = 0;
    events = new EventSocket("ws://test", {
      onMessage: (message) => heard.push(message),
      onConnection: (connection) => connections.push(connection),
    });
  });
  afterEach(() => {
    events.close();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  test("calls two seconds of silence a lost connection and comes back", () => {
    latest().say(HELLO);
    vi.advanceTimersByTime(1000);
    latest().say({ kind: "heartbeat", seq: 1, mission_age_s: 0, seen: "m-1/0/0" });
    vi.advanceTimersByTime(1400);
    expect(connections).toEqual(["open"]);
    vi.advanceTimersByTime(600);
    expect(connections).toEqual(["open", "lost"]);
    expect(FakeSocket.opened[0]?.isClosed).toBe(true);
    vi.advanceTimersByTime(250);
    latest().say(HELLO);
    expect(connections).toEqual(["open", "lost", "open"]);
  });

  test("tells changes as the snapshot that they lead to", () => {
    latest().say(HELLO);
    const told = { seq: 1, mission_age_s: 0.1, seen: "m-1/0/0", utc_s: 7 };
    latest().say({ kind: "changes", ...told, mission: { elapsed_s: 42 }, vehicles: [], preflight: [] });
    expect(heard.at(-1)).toEqual({ kind: "snapshot", ...told, mission: { ...mission(), elapsed_s: 42 } });
  });

  test("fetches the events that it has missed, once, and takes each once", async () => {
    const event = (seq: number) => ({ kind: "step", seq, utc_s: 0, step: step(seq) });
    const missed = { mission_id: "m1", seq: 4, events: [event(2), event(3), event(4)], hello: null };
    const fetched = vi.fn().mockResolvedValue(new Response(JSON.stringify(missed)));
    vi.stubGlobal("fetch", fetched);
    latest().say(HELLO);
    latest().say(event(4));
    latest().say(event(4));
    const numbers = (): number[] => heard.map((message) => message.seq);
    await vi.waitFor(() => expect(numbers()).toEqual([1, 2, 3, 4]));
    expect(fetched.mock.calls.map(([path]) => path as string)).toEqual(["/api/events?after=1"]);
    latest().say(event(5));
    expect(numbers().at(-1)).toBe(5);
    expect(FakeSocket.opened).toHaveLength(1);
  });

  test("is opened anew without a loss of the connection, where it is open", () => {
    latest().say(HELLO);
    const former = latest();
    events.renew();
    expect(former.isClosed).toBe(true);
    expect(FakeSocket.opened).toHaveLength(2);
    latest().say(HELLO);
    expect(connections).not.toContain("lost");
    events.close();
    events.renew();
    expect(FakeSocket.opened).toHaveLength(2);
  });

  test("connects again when what was missed is no longer kept", async () => {
    const missed = { mission_id: "m1", seq: 900, events: [], hello: HELLO };
    vi.stubGlobal("fetch", vi.fn().mockResolvedValue(new Response(JSON.stringify(missed))));
    latest().say(HELLO);
    latest().say({ kind: "heartbeat", seq: 900, mission_age_s: 0, seen: "m-1/0/0" });
    await vi.waitFor(() => expect(FakeSocket.opened).toHaveLength(2));
    expect(FakeSocket.opened[0]?.isClosed).toBe(true);
    expect(connections).toEqual(["open"]);
  });

  test("sends a hold on the open stream and returns its answer, or that the stream was lost", async () => {
    expect(events.hold("press-1")).toBeNull();
    latest().say(HELLO);
    const [held, refused, lost] = ["press-2", "press-3", "press-4"].map((id) => events.hold(id));
    expect(latest().sent[0]).toBe('{"kind":"hold","request_id":"press-2"}');
    const answer = { kind: "answer", request_id: "press-2", status: 200, response: { results: [] }, error: null };
    latest().say(answer);
    const error = { id: "operators_only", message: "Observers cannot" };
    latest().say({ ...answer, request_id: "press-3", status: 403, response: null, error });
    latest().say({ ...answer, request_id: "of-nobody" });
    vi.advanceTimersByTime(2000);
    expect(await held).toEqual({ ok: true, value: { results: [] } });
    expect(await refused).toEqual({ ok: false, message: "Observers cannot", status: 403 });
    expect(await lost).toMatchObject({ ok: false });
    expect(events.hold("press-5")).toBeNull();
    expect(heard.map((message) => message.kind)).toEqual(["hello"]);
  });

  test("stops when the service speaks another version", () => {
    vi.spyOn(console, "error").mockImplementation(() => undefined);
    latest().say({ ...HELLO, schema_version: 9 });
    vi.advanceTimersByTime(20_000);
    expect(connections).toEqual(["incompatible"]);
    expect(FakeSocket.opened).toHaveLength(1);
  });
});
