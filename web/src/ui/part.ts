/** Parts of the page that are loaded when they are first needed, or ahead of that, and then stay. */
import { useEffect, useState } from "preact/hooks";
import { backoffMs } from "../api/socket";

export class Part<T> {
  private loaded: T | null = null;
  private loading: Promise<T> | null = null;

  constructor(private readonly fetch: () => Promise<T>) {}

  /** Null until it has been loaded. */
  get now(): T | null {
    return this.loaded;
  }

  /** Load it, and wait for that; a station that does not answer is asked again. */
  load(): Promise<T> {
    return (this.loading ??= this.untilLoaded());
  }

  private async untilLoaded(): Promise<T> {
    for (let attempt = 0; ; attempt += 1) {
      try {
        return (this.loaded = await this.fetch());
      } catch (error) {
        console.warn("A part of the page cannot be loaded.", error);
        await new Promise((resolve) => setTimeout(resolve, backoffMs(attempt)));
      }
    }
  }
}

/** A part, loaded from now on; null until it is there. */
export function usePart<T>(part: Part<T>): T | null {
  const [, redraw] = useState(0);
  useEffect(() => {
    if (part.now === null) void part.load().then(() => redraw((count) => count + 1));
  }, [part]);
  return part.now;
}
