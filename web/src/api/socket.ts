/** Event stream: one WebSocket that reconnects on its own. Holds go by it, too. */
import { applyChanges } from "./changes";
import { checkedMission, ProtocolError, parseServerMessage } from "./check";
import { said, texts } from "../texts";
import { type ActionAnswer, readMissedEvents } from "./client";
import type { HoldStream } from "./hold";
import { noteSeen } from "./seen";
import type { Changes, Mission, ServerMessage, StreamAnswer } from "./types";

export type Connection = "connecting" | "open" | "lost" | "incompatible";

/** Messages for the page: changes are expanded to the snapshot that results from them. */
export type PageMessage = Exclude<ServerMessage, Changes | StreamAnswer>;
/** What every client is sent. */
export type StateOrEvent = Exclude<ServerMessage, StreamAnswer>;

export interface SocketEvents {
  onMessage(message: PageMessage): void;
  onConnection(connection: Connection): void;
}

const SILENCE_LIMIT_MS = 1600; // the station sends something at least every 500 ms
const WATCH_INTERVAL_MS = 200;
const OPENING_LIMIT_MS = 5000;
const FIRST_DELAY_MS = 250;
const LONGEST_DELAY_MS = 5000;

/** Delay before the given attempt (from 0) to reconnect. */
export function backoffMs(attempt: number): number {
  return Math.min(LONGEST_DELAY_MS, FIRST_DELAY_MS * 2 ** attempt);
}

const STATE_KINDS: ReadonlySet<StateOrEvent["kind"]> = new Set(["snapshot", "changes", "heartbeat"]);

/** Whether events before a message are missing. State messages repeat the number of the last event. */
export function isGap(previousSeq: number, message: StateOrEvent): boolean {
  if (message.kind === "hello") return false;
  return message.seq > (STATE_KINDS.has(message.kind) ? previousSeq : previousSeq + 1);
}

/**
 * Follows the service's events until closed. Every (re)connection begins with a hello that brings the whole state; events
 * that are missing afterwards, because this client was too slow, are fetched by their numbers.
 */
export class EventSocket implements HoldStream {
  private socket: WebSocket | null = null;
  private attempt = 0;
  private seq: number | null = null;
  private isCatchingUp = false;
  private mission: Mission | null = null;
  private heardAtMs = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly unanswered = new Map<string, (answer: ActionAnswer) => void>();
  private readonly watch: ReturnType<typeof setInterval>;

  constructor(
    private readonly url: string,
    private readonly events: SocketEvents,
  ) {
    this.watch = setInterval(() => this.checkSilence(), WATCH_INTERVAL_MS);
    this.connect();
  }

  close(): void {
    clearInterval(this.watch);
    clearTimeout(this.timer);
    this.timer = undefined;
    this.drop();
  }

  hold(requestId: string): Promise<ActionAnswer> | null {
    const { socket } = this;
    if (socket === null || this.seq === null) return null;
    return new Promise((resolve) => {
      this.unanswered.set(requestId, resolve);
      socket.send(JSON.stringify({ kind: "hold", request_id: requestId }));
    });
  }

  renew(): void {
    if (this.socket === null && this.timer === undefined) return;
    clearTimeout(this.timer);
    this.drop();
    this.connect();
  }

  private connect(): void {
    this.timer = undefined;
    this.seq = null;
    this.isCatchingUp = false;
    this.mission = null;
    this.heardAtMs = performance.now();
    const socket = new WebSocket(this.url);
    this.socket = socket;
    socket.onmessage = (event: MessageEvent<string>) => this.receive(event.data);
    socket.onclose = () => this.lose();
  }

  private receive(text: string): void {
    this.heardAtMs = performance.now();
    this.guard(() => this.take(parseServerMessage(text)));
  }

  private take(message: ServerMessage): void {
    if (message.kind === "answer") {
      this.unanswered.get(message.request_id)?.(answerOf(message));
      this.unanswered.delete(message.request_id);
      return;
    }
    if ("seen" in message) noteSeen(message.seen);
    if (message.kind === "hello") {
      this.attempt = 0;
      this.seq = message.seq;
      this.events.onMessage(this.expanded(message));
      this.events.onConnection("open");
      return;
    }
    if (this.seq === null) throw new ProtocolError("the first message of the service is not a hello");
    if (isGap(this.seq, message) && !this.isCatchingUp) void this.catchUp(this.seq);
    if (STATE_KINDS.has(message.kind)) this.events.onMessage(this.expanded(message));
    // An event waits for the missing ones before it: the pending answer contains it as well.
    else if (message.seq > this.seq && !this.isCatchingUp) {
      this.seq = message.seq;
      this.events.onMessage(this.expanded(message));
    }
  }

  /** Fetch the events after a number; if they are no longer kept, reconnect to get the whole state. */
  private async catchUp(after: number): Promise<void> {
    this.isCatchingUp = true;
    const { socket } = this;
    const answer = await readMissedEvents(after);
    if (this.socket !== socket) return;
    this.isCatchingUp = false;
    if (answer.ok && answer.value.hello === null) {
      this.guard(() => answer.value.events.forEach((event) => this.take(event)));
    } else {
      this.renew();
    }
  }

  /** Run an action; an invalid message closes the connection for good. */
  private guard(action: () => void): void {
    try {
      action();
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      console.error(error.message);
      this.close();
      this.events.onConnection("incompatible");
    }
  }

  private expanded(message: StateOrEvent): PageMessage {
    if (message.kind !== "changes") {
      if (message.kind === "hello" || message.kind === "snapshot") this.mission = message.mission;
      return message;
    }
    if (this.mission === null) throw new ProtocolError("changes came before the mission");
    this.mission = checkedMission(applyChanges(this.mission, message));
    const { seq, utc_s, mission_age_s, seen } = message;
    return { kind: "snapshot", seq, utc_s, mission_age_s, seen, mission: this.mission };
  }

  private checkSilence(): void {
    const limitMs = this.seq === null ? OPENING_LIMIT_MS : SILENCE_LIMIT_MS;
    if (this.socket !== null && performance.now() - this.heardAtMs > limitMs) this.lose();
  }

  private lose(): void {
    this.drop();
    this.events.onConnection("lost");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.connect(), backoffMs(this.attempt));
    this.attempt += 1;
  }

  private drop(): void {
    if (this.socket === null) return;
    this.socket.onmessage = null;
    this.socket.onclose = null;
    this.socket.close();
    this.socket = null;
    for (const resolve of this.unanswered.values()) resolve({ ok: false, message: texts.requests.notSent });
    this.unanswered.clear();
  }
}

function answerOf({ status, response, error }: StreamAnswer): ActionAnswer {
  if (response !== null) return { ok: true, value: response };
  return { ok: false, message: error === null ? texts.requests.unreadableAnswer : said(error.message), status };
}
