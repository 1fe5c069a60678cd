/** Decide: what was found, and where. */
import { useMemo } from "preact/hooks";
import { areaLayer } from "../../map/layers/area";
import { pictureLayer } from "../../map/layers/picture";
import { targetsLayer } from "../../map/layers/targets";
import { MapPanel } from "../../map/panel";
import { useBaseLayers } from "../../map/use_base";
import { TargetsPanel } from "../../panels/targets";
import { useShell } from "../../shell/context";
import "./decide.css";

const OVERLAY = { kind: "integral", opacity: 1 } as const;

export function DecideView() {
  const { state } = useShell();
  const base = useBaseLayers();
  const layers = useMemo(() => [...base, pictureLayer, areaLayer, targetsLayer], [base]);
  return (
    <>
      <TargetsPanel targets={state.mission?.targets ?? []} />
      <MapPanel layers={layers} overlay={OVERLAY} />
    </>
  );
}
