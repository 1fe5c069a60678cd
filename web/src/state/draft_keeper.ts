/** Keeps a draft while another view is open: answers that come then change it as well. */
export class DraftKeeper<Draft, Reading> {
  private draft: Draft | null = null;
  private readonly readers = new Set<(draft: Draft | null) => void>();

  /**
   * `keyOf` says what a draft belongs to, such as a mission; `afterReading` makes the draft after the station has sent
   * what it is a draft of.
   */
  constructor(
    private readonly keyOf: (draft: Draft) => string,
    private readonly afterReading: (before: Draft | null, read: Reading) => Draft,
  ) {}

  /** The draft of a key; drafts of others are forgotten. */
  of(key: string): Draft | null {
    if (this.draft !== null && this.keyOf(this.draft) !== key) this.draft = null;
    return this.draft;
  }

  /** Put the draft of a reading in place of the present one. */
  read(reading: Reading): void {
    this.put(this.afterReading(this.draft, reading));
  }

  /** Change the draft of a key, unless it is gone. */
  change(key: string, take: (before: Draft) => Draft): void {
    if (this.draft !== null && this.keyOf(this.draft) === key) this.put(take(this.draft));
  }

  /** Call `reader` with the draft now and after changes, until the returned function is called. */
  subscribe(reader: (draft: Draft | null) => void): () => void {
    this.readers.add(reader);
    reader(this.draft);
    return () => void this.readers.delete(reader);
  }

  private put(draft: Draft): void {
    this.draft = draft;
    for (const reader of this.readers) reader(draft);
  }
}
