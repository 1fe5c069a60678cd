/** Decide: what was found, and where. */
import { areaLayer } from "../../map/layers/area";
import { gridLayer } from "../../map/layers/grid";
import { pictureLayer } from "../../map/layers/picture";
import { targetsLayer } from "../../map/layers/targets";
import { MapPanel } from "../../map/panel";
import { TargetsPanel } from "../../panels/targets";
import { useShell } from "../../shell/context";
import "./decide.css";

const LAYERS = [gridLayer, pictureLayer, areaLayer, targetsLayer];
const OVERLAY = { kind: "integral", opacity: 1 } as const;

export function DecideView() {
  const { state } = useShell();
  return (
    <>
      <TargetsPanel targets={state.mission?.targets ?? []} />
      <MapPanel layers={LAYERS} overlay={OVERLAY} />
    </>
  );
}
