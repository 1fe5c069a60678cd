import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { ProtocolError, parseServerMessage } from "../src/api/check";
import { backoffMs, type Connection, EventSocket, isGap, type PageMessage } from "../src/api/socket";
import type { ServerMessage } from "../src/api/types";
import { mission, step } from "./samples";

const HELLO = {
  kind: "hello",
  seq: 1,
  schema_version: 2,
  mission: mission(),
  steps: [step(1)],
  notices: [],
  pictures: [],
} as const;

describe("parseServerMessage", () => {
  test("takes what the schema allows", () => {
    expect(parseServerMessage(JSON.stringify(HELLO)).kind).toBe("hello");
    expect(parseServerMessage('{"kind":"heartbeat","seq":4}')).toEqual({ kind: "heartbeat", seq: 4 });
  });
  test.each([
    ["no JSON", "{"],
    ["an unknown kind", '{"kind":"toString","seq":1}'],
    ["no number", '{"kind":"heartbeat"}'],
    ["another version", JSON.stringify({ ...HELLO, schema_version: 1 })],
    ["a vehicle without an id", JSON.stringify({ ...HELLO, mission: { ...mission(), vehicles: [{}] } })],
  ])("refuses %s", (_, text) => {
    expect(() => parseServerMessage(text)).toThrow(ProtocolError);
  });
});

test("gaps are seen; state and heartbeats do not count", () => {
  const heartbeat = (seq: number): ServerMessage => ({ kind: "heartbeat", seq });
  const snapshot = (seq: number): ServerMessage => ({ kind: "snapshot", seq, utc_s: 0, mission: mission() });
  expect(isGap(null, HELLO as unknown as ServerMessage)).toBe(false);
  const noticed = (seq: number) => ({ kind: "notice", seq }) as unknown as ServerMessage;
  expect(isGap(null, snapshot(2))).toBe(true);
  expect(isGap(2, snapshot(2))).toBe(false);
  expect(isGap(2, heartbeat(2))).toBe(false);
  expect(isGap(2, snapshot(4))).toBe(true);
  expect(isGap(2, noticed(3))).toBe(false);
  expect(isGap(2, noticed(4))).toBe(true);
  expect(isGap(7, HELLO as unknown as ServerMessage)).toBe(false);
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
  close(): void {
    this.isClosed = true;
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
    latest().say({ kind: "heartbeat", seq: 1 });
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
    latest().say({ kind: "changes", seq: 1, utc_s: 7, mission: { elapsed_s: 42 }, vehicles: [] });
    expect(heard.at(-1)).toEqual({ kind: "snapshot", seq: 1, utc_s: 7, mission: { ...mission(), elapsed_s: 42 } });
  });

  test("asks for the whole state again after a gap", () => {
    latest().say(HELLO);
    latest().say({ kind: "step", seq: 5, utc_s: 0, step: step(2) });
    expect(FakeSocket.opened).toHaveLength(2);
    expect(FakeSocket.opened[0]?.isClosed).toBe(true);
    expect(connections).toEqual(["open"]);
  });

  test("stops when the service speaks another version", () => {
    vi.spyOn(console, "error").mockImplementation(() => undefined);
    latest().say({ ...HELLO, schema_version: 9 });
    vi.advanceTimersByTime(20_000);
    expect(connections).toEqual(["incompatible"]);
    expect(FakeSocket.opened).toHaveLength(1);
  });
});
