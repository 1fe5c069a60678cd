/**
 * Last state that this browser has seen of the station, for a page that is opened while the station is out of reach.
 *
 * It is what everybody who is admitted sees: neither names of sign-ins nor codes are in it. It belongs to one build of
 * the page, since another one may read it otherwise.
 */
import type { State } from "../state/state";

/** What is kept of a state: values and texts, no images, which are large. */
export type KeptState = Pick<State, "mission" | "capabilities" | "steps" | "latestStep" | "notices"> & {
  readonly build: string;
  /** Clock time of this browser at which the state was valid, in milliseconds since 1970. */
  readonly validAtMs: number;
};

/** Place for one value, such as a database of the browser. Every function fails where it forbids storage or is full. */
export interface Shelf {
  put(value: KeptState): Promise<void>;
  get(): Promise<unknown>;
  clear(): Promise<void>;
}

export type Keeping = "idle" | "kept" | "failed";

/** Interval of savings while the mission changes. */
export const SAVE_INTERVAL_MS = 5000;

export class LastState {
  private savedAtMs = -Infinity;
  private savedMissionAtMs = -Infinity;
  private isAdmitted = false;
  private isBusy = false;
  private result: Keeping = "idle";

  constructor(
    private readonly shelf: Shelf,
    private readonly build: string,
    private readonly nowMs: () => number = () => performance.now(),
    private readonly clockMs: () => number = () => Date.now(),
  ) {}

  /** Whether states are kept, or could not be. */
  get keeping(): Keeping {
    return this.result;
  }

  /** Keep states from now on, or remove what is kept: whoever may not see the mission reads nothing of it here. */
  admit(isAdmitted: boolean): void {
    this.isAdmitted = isAdmitted;
    if (!isAdmitted) void this.forget();
  }

  /** Keep a state, at most once in five seconds; recordings are on the station's disk, and not the last state of anything. */
  async follow(state: State): Promise<void> {
    const { mission, missionAtMs, connection } = state;
    if (!this.isAdmitted || this.isBusy || connection !== "open" || mission === null || mission.replay !== null) return;
    if (missionAtMs === this.savedMissionAtMs || this.nowMs() - this.savedAtMs < SAVE_INTERVAL_MS) return;
    const { capabilities, steps, latestStep, notices } = state;
    const validAtMs = this.clockMs() - (this.nowMs() - missionAtMs);
    this.savedAtMs = this.nowMs();
    this.savedMissionAtMs = missionAtMs;
    this.isBusy = true;
    const kept = { build: this.build, validAtMs, mission, capabilities, steps, latestStep, notices };
    await this.attempt(() => this.shelf.put(kept));
    this.isBusy = false;
    // Somebody has signed out while it was written.
    if (!this.isAdmitted) await this.forget();
  }

  /** State that was kept by this build; null without one. */
  async recall(): Promise<KeptState | null> {
    try {
      const value = await this.shelf.get();
      return isKeptState(value) && value.build === this.build ? value : null;
    } catch {
      return null;
    }
  }

  async forget(): Promise<void> {
    this.savedAtMs = -Infinity;
    this.savedMissionAtMs = -Infinity;
    try {
      await this.shelf.clear();
      this.result = "idle";
    } catch {
      this.result = "failed";
    }
  }

  private async attempt(work: () => Promise<void>): Promise<void> {
    try {
      await work();
      this.result = "kept";
    } catch (error) {
      if (this.result !== "failed") console.warn("This browser cannot keep the last state.", error);
      this.result = "failed";
    }
  }
}

function isKeptState(value: unknown): value is KeptState {
  if (typeof value !== "object" || value === null) return false;
  const { build, validAtMs, mission } = value as Partial<KeptState>;
  return typeof build === "string" && typeof validAtMs === "number" && typeof mission === "object" && mission !== null;
}
