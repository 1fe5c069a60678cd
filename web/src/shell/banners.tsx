/** Says in large letters when the page does not show the present, or not all that has happened. */
import { useState } from "preact/hooks";
import type { Connection } from "../api/socket";
import { age } from "../format";
import { texts } from "../texts";

interface Props {
  connection: Connection;
  /** Seconds since the mission's last sign of life, where it should give one; null where all is well. */
  silence_s: number | null;
  missedNotices: number;
}

export function Banners({ connection, silence_s, missedNotices }: Props) {
  return (
    <>
      {(connection === "lost" || connection === "incompatible") && (
        <p class="banner" role="alert" data-testid="banner">
          {connection === "lost" ? texts.connection.lostBanner : texts.connection.incompatibleBanner}
        </p>
      )}
      {connection === "open" && silence_s !== null && (
        <p class="banner" data-testid="silent-banner">
          {/* Announced once: seconds that count would repeat themselves. */}
          <span role="alert">{texts.connection.silentBanner}</span> {texts.connection.silentFor(age(silence_s))}
        </p>
      )}
      <Missed count={missedNotices} />
    </>
  );
}

function Missed({ count }: { count: number }) {
  const [read, setRead] = useState(0);
  if (count <= read) return null;
  return (
    <div class="banner" data-testid="missed-banner">
      <span role="alert">{texts.connection.missed(count)}</span>{" "}
      <button type="button" data-testid="missed-dismiss" onClick={() => setRead(count)}>
        {texts.actions.dismiss}
      </button>
    </div>
  );
}
