/** The top bar: where the mission is, and whether what is shown is live. */
import type { Connection } from "../api/socket";
import type { Mission } from "../api/types";
import { duration, quantity, words } from "../format";
import type { Theme } from "../map/palette";
import { texts } from "../texts";

interface Props {
  mission: Mission | null;
  connection: Connection;
  theme: Theme;
  onTheme(theme: Theme): void;
}

export function Header({ mission, connection, theme, onTheme }: Props) {
  const otherTheme = theme === "dark" ? "light" : "dark";
  return (
    <header class="header">
      <h1>{texts.title}</h1>
      {mission && <Facts mission={mission} />}
      <span class={`connection is-${connection}`} data-testid="connection" data-state={connection} role="status">
        {texts.connection[connection]}
      </span>
      <button type="button" class="quiet" data-testid="theme" onClick={() => onTheme(otherTheme)}>
        {texts.header.theme[theme]}
      </button>
    </header>
  );
}

function Facts({ mission }: { mission: Mission }) {
  const { header } = texts;
  const isSuspended = mission.suspension !== "none";
  return (
    <dl class="facts">
      <div class={`phase ${isSuspended ? "is-suspended" : ""}`}>
        <dt>{header.phase}</dt>
        <dd>
          <span data-testid="phase">{mission.phase}</span>
          {isSuspended && <em data-testid="suspension">{mission.suspension}</em>}
        </dd>
      </div>
      <Fact name={header.elapsed} value={duration(mission.elapsed_s)} testId="elapsed" />
      <Fact name={header.step} value={String(mission.step)} testId="step" />
      <Fact name={header.outcome} value={words(mission.outcome)} testId="outcome" />
      <Fact name={header.strategy} value={mission.strategy} testId="strategy" />
      <Fact name={header.separation} value={quantity(mission.min_separation_m, 1, "m")} testId="separation" />
      {mission.focus && (
        <Fact
          name={header.focus}
          value={`${quantity(mission.focus.height_m, 1, "m")} (${mission.focus.source})`}
          testId="focus"
        />
      )}
    </dl>
  );
}

function Fact({ name, value, testId }: { name: string; value: string; testId: string }) {
  return (
    <div>
      <dt>{name}</dt>
      <dd data-testid={testId}>{value}</dd>
    </div>
  );
}
