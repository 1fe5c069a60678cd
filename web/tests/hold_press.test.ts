import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { CONFIRM_AFTER_MS, HoldPress } from "../src/ui/hold_press";

/** A button of 100 x 40 pixels that the page can move. */
class FakeButton {
  left = 0;
  top = 0;
  captured: number | null = null;
  setPointerCapture(pointerId: number): void {
    this.captured = pointerId;
  }
  getBoundingClientRect() {
    return { left: this.left, top: this.top, right: this.left + 100, bottom: this.top + 40 };
  }
}

let button: FakeButton;
let confirmed: number;
let pressed: boolean[];
let press: HoldPress;

beforeEach(() => {
  vi.useFakeTimers();
  button = new FakeButton();
  confirmed = 0;
  pressed = [];
  press = new HoldPress({ onPressed: (is) => pressed.push(is), onConfirm: () => (confirmed += 1) });
});
afterEach(() => vi.useRealTimers());

const begin = (): void => press.beginByPointer(button, { pointerId: 7, timeStamp: 0 });

test("a press that lasts confirms once, whenever it ends", () => {
  begin();
  vi.advanceTimersByTime(CONFIRM_AFTER_MS);
  press.release({ timeStamp: 2 * CONFIRM_AFTER_MS });
  expect(confirmed).toBe(1);
  expect(pressed).toEqual([true, false]);
});

test("a press that ends early does nothing", () => {
  begin();
  vi.advanceTimersByTime(CONFIRM_AFTER_MS - 1);
  press.release({ timeStamp: CONFIRM_AFTER_MS - 1 });
  vi.advanceTimersByTime(10 * CONFIRM_AFTER_MS);
  expect(confirmed).toBe(0);
});

test("a button that the page moves away keeps the pointer that presses it", () => {
  begin();
  expect(button.captured).toBe(7);
  button.top = 300;
  press.move({ clientX: 50, clientY: 20 });
  vi.advanceTimersByTime(CONFIRM_AFTER_MS);
  expect(confirmed).toBe(1);
});

test("a pointer that leaves the place of the button ends the press", () => {
  begin();
  press.move({ clientX: 50, clientY: 41 });
  vi.advanceTimersByTime(CONFIRM_AFTER_MS);
  expect(confirmed).toBe(0);
});

test("a press that is held on confirms once and says when it is let go", () => {
  let letGo = 0;
  press = new HoldPress({ onPressed: () => undefined, onConfirm: () => (confirmed += 1), onLetGo: () => (letGo += 1) });
  begin();
  vi.advanceTimersByTime(CONFIRM_AFTER_MS);
  press.begin({ timeStamp: 900 }); // a key that repeats
  press.move({ clientX: 50, clientY: 20 });
  vi.advanceTimersByTime(10 * CONFIRM_AFTER_MS);
  expect([confirmed, letGo]).toEqual([1, 0]);
  press.move({ clientX: 50, clientY: 41 });
  press.release({ timeStamp: 20 * CONFIRM_AFTER_MS });
  expect([confirmed, letGo]).toEqual([1, 1]);
});

test("a lost pointer ends the press", () => {
  begin();
  press.end();
  vi.advanceTimersByTime(CONFIRM_AFTER_MS);
  expect(confirmed).toBe(0);
});

test("the time of the events counts where the page was too busy for its timer", () => {
  begin();
  press.release({ timeStamp: CONFIRM_AFTER_MS });
  expect(confirmed).toBe(1);
});

test("a key that repeats goes on with its press, and needs no place", () => {
  press.begin({ timeStamp: 0 });
  press.begin({ timeStamp: 500 });
  press.move({ clientX: -1, clientY: -1 });
  vi.advanceTimersByTime(CONFIRM_AFTER_MS);
  expect(confirmed).toBe(1);
});
