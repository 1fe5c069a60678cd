/** Panel with the focal plane of the mission itself, which an operator can change for all screens. */
import { quantity } from "../../format";
import { useShell } from "../../shell/context";
import { makeFocusCommand } from "../../state/commands";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";

interface Props {
  /** Height of the displayed plane; null while it is not known. */
  viewed_m: number | null;
}

export function MissionPlane({ viewed_m }: Props) {
  const { state, mayCommand, isConnected, commands } = useShell();
  const focus = state.mission?.focus ?? null;
  const isOffered = isConnected && (state.mission?.allowed_actions.includes("focus") ?? false);
  const title = isOffered ? undefined : texts.unavailable;
  return (
    <Panel title={texts.focus.panel} testId="mission-plane" class="see-panel">
      <p data-testid="mission-focus" data-source={focus?.source}>
        {focus === null ? (
          texts.focus.none
        ) : (
          <>
            {texts.focus.now}: <b>{quantity(focus.height_m, 1, "m")}</b>, {texts.focus.source[focus.source]}
            {focus.sigma_m !== null && ` ± ${quantity(focus.sigma_m, 2, "m")}`}
          </>
        )}
      </p>
      {mayCommand && (
        <div class="see-buttons">
          {viewed_m !== null && (
            <button
              type="button"
              data-testid="use-plane"
              disabled={!isOffered}
              title={title}
              onClick={() => commands.ask(makeFocusCommand(viewed_m))}
            >
              {texts.focus.use(quantity(viewed_m, 1, "m"))}
            </button>
          )}
          {focus?.source === "operator" && (
            <button
              type="button"
              data-testid="leave-plane"
              disabled={!isOffered}
              title={title}
              onClick={() => commands.ask(makeFocusCommand(null))}
            >
              {texts.focus.leaveShort}
            </button>
          )}
        </div>
      )}
    </Panel>
  );
}
