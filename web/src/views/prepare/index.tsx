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

export function PrepareView() {
  const { state } = useShell();
  const [chosen, setChosen] = useState<string | null>(null);
  const checks = state.mission?.preflight ?? [];
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
        <VehicleChoice />
        <LaunchPanel checks={checks} onChoose={setChosen} />
      </div>
    </>
  );
}
