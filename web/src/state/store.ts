/** Store of the state, which notifies its readers of changes at most a few times per second. */
import type { Connection, PageMessage } from "../api/socket";
import type { KeptState } from "../offline/last_state";
import { INITIAL_STATE, reduce, restore, type State } from "./state";

const NOTIFY_INTERVAL_MS = 150;

export class Store {
  private current: State = INITIAL_STATE;
  private readonly readers = new Set<(state: State) => void>();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private notifiedAtMs = -Infinity;

  get state(): State {
    return this.current;
  }

  receive(message: PageMessage): void {
    this.current = reduce(this.current, message, performance.now());
    const dueAtMs = this.notifiedAtMs + NOTIFY_INTERVAL_MS;
    this.timer ??= setTimeout(() => this.notify(), Math.max(0, dueAtMs - performance.now()));
  }

  /** Show a state of an earlier visit, until the station sends the present one. */
  restore(kept: KeptState): void {
    this.current = restore(this.current, kept, performance.now(), Date.now());
    this.notify();
  }

  /** Show nothing of an earlier visit any more. */
  forgetRestored(): void {
    if (this.current.keptAtMs === null) return;
    this.current = { ...INITIAL_STATE, connection: this.current.connection };
    this.notify();
  }

  setConnection(connection: Connection): void {
    this.current = { ...this.current, connection };
    this.notify();
  }

  /** Call `reader` after changes, until the returned function is called. */
  subscribe(reader: (state: State) => void): () => void {
    this.readers.add(reader);
    return () => this.readers.delete(reader);
  }

  private notify(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.notifiedAtMs = performance.now();
    for (const reader of this.readers) reader(this.current);
  }
}
