/** View Prepare: the preflight checks of every vehicle, and the launch. */
import { useState } from "preact/hooks";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { keyOf, matrixOf } from "./checks";
import { VehicleChoice } from "./choice";
import { CheckDetail } from "./detail";
import { LaunchPanel } from "./launch";
import { PreflightMatrix } from "./matrix";
import "./prepare.css";
import { isSame, proposedIds } from "./vehicles";

export function PrepareView() {
  const { state } = useShell();
  const { mission } = state;
  const [chosen, setChosen] = useState<string | null>(null);
  const [edited, setEdited] = useState<readonly number[] | null>(null);
  const checks = mission?.preflight ?? [];
  const vehicles = edited ?? proposedIds(mission?.vehicles ?? [], mission?.planned_vehicles ?? 0);
  // What has been chosen while the station answered stays chosen.
  const forget = (confirmed: readonly number[]): void =>
    setEdited((now) => (now === null || isSame(now, confirmed) ? null : now));
  return (
    <>
      <Panel title={texts.prepare.panel} testId="preflight" class="preflight">
        {checks.length === 0 ? (
          <p class="empty">{texts.prepare.none}</p>
        ) : (
          <PreflightMatrix matrix={matrixOf(checks)} chosen={chosen} onChoose={setChosen} />
        )}
      </Panel>
      <div class="side">
        <CheckDetail check={checks.find((check) => keyOf(check) === chosen)} />
        <VehicleChoice chosen={vehicles} onChange={setEdited} onConfirmed={forget} />
        <LaunchPanel checks={checks} vehicles={vehicles} onChoose={setChosen} onConfirmed={forget} />
      </div>
    </>
  );
}
