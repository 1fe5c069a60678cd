/** Live pictures: one WebSocket for all tiles that this page watches. */
import type { components } from "./schema";
import { backoffMs } from "./socket";

export type WallMessage = components["schemas"]["WallMessage"];
type TilePicture = components["schemas"]["TilePictureModel"];

export interface Choice {
  readonly tiles: readonly string[];
  readonly large: boolean;
  /** Pictures per tile and second at most; null: as many as the station sends. */
  readonly rate_hz: number | null;
}

/** A picture that has been decoded. */
interface ShownTile {
  readonly picture: TilePicture;
  readonly bitmap: ImageBitmap;
}

/** What the wall shows: the latest head, and the newest picture of each tile. */
export interface WallState {
  readonly head: WallMessage | null;
  readonly shown: ReadonlyMap<string, ShownTile>;
  /** Time at which the station sent the head, by this page's clock, ms. */
  readonly sentAtMs: number;
  /** Time at which the page has heard from the station last, ms. */
  readonly heardAtMs: number;
}

export const NOTHING: WallState = { head: null, shown: new Map(), sentAtMs: 0, heardAtMs: 0 };
/** The station says something every second. */
export const SILENCE_LIMIT_MS = 3000;
const OPENING_LIMIT_MS = 8000;
const WATCH_INTERVAL_MS = 500;
const LENGTH_BYTES = 4;

export interface Parsed {
  readonly head: WallMessage;
  readonly files: readonly Blob[];
}

/** Head and files of a message; null for one that is none. */
export function parseWallMessage(data: ArrayBuffer): Parsed | null {
  if (data.byteLength < LENGTH_BYTES) return null;
  let begin = LENGTH_BYTES + new DataView(data).getUint32(0);
  try {
    const head: unknown = JSON.parse(new TextDecoder().decode(data.slice(LENGTH_BYTES, begin)));
    if (!isHead(head)) return null;
    const files = head.pictures.map(({ bytes }) => {
      const file = new Blob([data.slice(begin, begin + bytes)], { type: "image/jpeg" });
      begin += bytes;
      return file;
    });
    return begin === data.byteLength ? { head, files } : null;
  } catch {
    return null;
  }
}

const isHead = (value: unknown): value is WallMessage =>
  typeof value === "object" &&
  value !== null &&
  typeof (value as WallMessage).number === "number" &&
  typeof (value as WallMessage).sent_s === "number" &&
  Array.isArray((value as WallMessage).pictures) &&
  Array.isArray((value as WallMessage).tiles) &&
  typeof (value as WallMessage).ages_s === "object";

/**
 * Age of what a tile shows now, seconds; null before it shows something. In a flight it grows from the moment of sending, the
 * way of the message included; in a replay time may stand still.
 */
export function tileAge_s({ head, sentAtMs }: WallState, tile: string, nowMs: number): number | null {
  const age_s = head?.ages_s[tile];
  if (head === null || age_s === undefined) return null;
  return head.live ? age_s + Math.max(0, nowMs - sentAtMs) / 1000 : age_s;
}

/** Follows the wall until closed. It reconnects on its own, and shows nothing old as new meanwhile. */
export class WallSocket {
  private socket: WebSocket | null = null;
  private state = NOTHING;
  private attempt = 0;
  private openedAtMs = 0;
  /** Least difference seen between this page's clock and the station's, ms: that of the fastest message. */
  private offsetMs = Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly watch: ReturnType<typeof setInterval>;

  constructor(
    private readonly url: string,
    private choice: Choice,
    private readonly onState: (state: WallState) => void,
  ) {
    this.watch = setInterval(() => this.checkSilence(), WATCH_INTERVAL_MS);
    this.connect();
  }

  choose(choice: Choice): void {
    this.choice = choice;
    this.send({ kind: "watch", ...choice });
  }

  close(): void {
    clearInterval(this.watch);
    clearTimeout(this.timer);
    this.drop();
    for (const { bitmap } of this.state.shown.values()) bitmap.close();
  }

  private connect(): void {
    this.offsetMs = Infinity;
    this.openedAtMs = performance.now();
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.choose(this.choice);
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => void this.receive(socket, event.data);
    socket.onclose = () => this.lose();
    this.socket = socket;
  }

  private async receive(socket: WebSocket, data: ArrayBuffer): Promise<void> {
    const heardAtMs = performance.now();
    const parsed = parseWallMessage(data);
    if (parsed === null) {
      this.lose();
      return;
    }
    const { head, files } = parsed;
    this.attempt = 0;
    this.offsetMs = Math.min(this.offsetMs, heardAtMs - 1000 * head.sent_s);
    const bitmaps = await Promise.all(files.map((file) => createImageBitmap(file).catch(() => null)));
    if (this.socket !== socket) {
      for (const bitmap of bitmaps) bitmap?.close();
      return;
    }
    const shown = new Map([...this.state.shown].filter(([tile]) => tile in head.ages_s));
    head.pictures.forEach((picture, index) => {
      const bitmap = bitmaps[index];
      if (bitmap) shown.set(picture.tile, { picture, bitmap });
    });
    const former = this.state.shown;
    this.state = { head, shown, sentAtMs: 1000 * head.sent_s + this.offsetMs, heardAtMs };
    this.onState(this.state);
    for (const [tile, { bitmap }] of former) if (shown.get(tile)?.bitmap !== bitmap) bitmap.close();
    this.send({ kind: "shown", number: head.number });
  }

  private send(message: object): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  private checkSilence(): void {
    if (this.socket === null) return;
    const heardAtMs = Math.max(this.state.heardAtMs, this.openedAtMs);
    const limitMs = this.state.heardAtMs < this.openedAtMs ? OPENING_LIMIT_MS : 2 * SILENCE_LIMIT_MS;
    if (performance.now() - heardAtMs > limitMs) this.lose();
  }

  private lose(): void {
    this.drop();
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
  }
}

export const wallUrl = (): string => `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/wall`;
