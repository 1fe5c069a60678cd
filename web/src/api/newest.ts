/** One request at a time, however fast a slider moves: of those that wait only the newest is sent. */
export class Newest<Query> {
  private waiting: { readonly query: Query } | null = null;
  private isBusy = false;

  /** `send` must not throw: what becomes of a request is a value. */
  constructor(private readonly send: (query: Query) => Promise<void>) {}

  get isIdle(): boolean {
    return !this.isBusy;
  }

  ask(query: Query): void {
    this.waiting = { query };
    if (!this.isBusy) void this.work();
  }

  /** Give up what waits; what is on its way comes. */
  forget(): void {
    this.waiting = null;
  }

  private async work(): Promise<void> {
    this.isBusy = true;
    while (this.waiting !== null) {
      const { query } = this.waiting;
      this.waiting = null;
      await this.send(query);
    }
    this.isBusy = false;
  }
}
