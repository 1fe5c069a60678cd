/** One request at a time, however fast a slider moves: of waiting requests only the newest is sent. */
export class Newest<Query> {
  private waiting: { readonly query: Query } | null = null;
  private isBusy = false;

  /** `send` must not throw: results and failures are values. */
  constructor(private readonly send: (query: Query) => Promise<void>) {}

  get isIdle(): boolean {
    return !this.isBusy;
  }

  ask(query: Query): void {
    this.waiting = { query };
    if (!this.isBusy) void this.work();
  }

  /** Drop the waiting request; one that is under way completes. */
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
