/** Hold all vehicles by two ways at once; the station carries it out once. */
import { type ActionAnswer, postAction } from "./client";

/** The event stream, which is open while requests wait for one of the few connections of a browser. */
export interface HoldStream {
  /** Send a hold; null while the stream is not open. */
  hold(requestId: string): Promise<ActionAnswer> | null;
  /** Open the stream anew: it keeps the role that its client had when it was opened. */
  renew(): void;
}

const ID_BYTES = 16;

/** Name that no other request has. `crypto.randomUUID` is missing on pages without encryption. */
export function newRequestId(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(ID_BYTES));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

export function holdAll(stream: Pick<HoldStream, "hold">): Promise<ActionAnswer> {
  const requestId = newRequestId();
  const byStream = stream.hold(requestId);
  const byRequest = postAction({ action: "hold", vehicleIds: null, requestId });
  return byStream === null ? byRequest : firstAnswer([byStream, byRequest]);
}

/** First answer of the station; a way that was lost says nothing about the other. */
export function firstAnswer(ways: readonly Promise<ActionAnswer>[]): Promise<ActionAnswer> {
  return new Promise((resolve) => {
    let open = ways.length;
    for (const way of ways) {
      void way.then((answer) => {
        open -= 1;
        if (answer.ok || answer.status !== undefined || open === 0) resolve(answer);
      });
    }
  });
}
