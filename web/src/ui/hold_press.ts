/** Recognises a press that lasts long enough to confirm a dangerous command; one that ends earlier does nothing. */

export const CONFIRM_AFTER_MS = 800;

/** The part of a button that a press needs. */
export interface PressedElement {
  setPointerCapture(pointerId: number): void;
  getBoundingClientRect(): Box;
}

interface Box {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

interface PressEvents {
  onPressed(isPressed: boolean): void;
  onConfirm(): void;
  /** The button is no longer held after it has confirmed. */
  onLetGo?(): void;
}

export class HoldPress {
  private press: { readonly atMs: number; readonly timer: ReturnType<typeof setTimeout> } | null = null;
  /** Whether it has confirmed and the button is still held. */
  private isHeldOn = false;
  /** Box of the button at the beginning of a press by pointer; null for a press by key. */
  private box: Box | null = null;

  constructor(private readonly events: PressEvents) {}

  /**
   * Begin a press by pointer. The pointer is captured and compared with where the button was at first: a page that
   * moves the button meanwhile, for example because an answer has arrived above it, does not end the press.
   */
  beginByPointer(
    element: PressedElement,
    { pointerId, timeStamp }: Pick<PointerEvent, "pointerId" | "timeStamp">,
  ): void {
    if (this.press !== null || this.isHeldOn) return;
    element.setPointerCapture(pointerId);
    this.box = element.getBoundingClientRect();
    this.begin({ timeStamp });
  }

  /** Begin a press by key; a key that repeats goes on with the press. */
  begin({ timeStamp }: Pick<Event, "timeStamp">): void {
    if (this.press !== null || this.isHeldOn) return;
    this.press = { atMs: timeStamp, timer: setTimeout(() => this.confirm(), CONFIRM_AFTER_MS) };
    this.events.onPressed(true);
  }

  /** End the press when the pointer has left the place where the button was: this is how an operator changes their mind. */
  move({ clientX, clientY }: Pick<PointerEvent, "clientX" | "clientY">): void {
    if (this.box === null) return;
    const { left, top, right, bottom } = this.box;
    if (clientX < left || clientX > right || clientY < top || clientY > bottom) this.end();
  }

  release({ timeStamp }: Pick<Event, "timeStamp">): void {
    // A busy page may receive the release before its own timer: the time of the events counts.
    if (this.press !== null && timeStamp - this.press.atMs >= CONFIRM_AFTER_MS) this.confirm();
    this.end();
  }

  /** End the press: without confirming, unless it has lasted long enough already. */
  end(): void {
    this.box = null;
    this.stop();
    if (!this.isHeldOn) return;
    this.isHeldOn = false;
    this.events.onLetGo?.();
  }

  private confirm(): void {
    this.stop();
    this.isHeldOn = true;
    this.events.onConfirm();
  }

  private stop(): void {
    if (this.press === null) return;
    clearTimeout(this.press.timer);
    this.press = null;
    this.events.onPressed(false);
  }
}
