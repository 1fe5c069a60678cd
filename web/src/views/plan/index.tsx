/** Plan: where is searched and what no vehicle may leave. */
import { useMemo } from "preact/hooks";
import { areaLayer } from "../../map/layers/area";
import { homesLayer } from "../../map/layers/homes";
import { MapPanel } from "../../map/panel";
import { useBaseLayers } from "../../map/use_base";

export function PlanView() {
  const base = useBaseLayers();
  const layers = useMemo(() => [...base, areaLayer, homesLayer], [base]);
  return <MapPanel layers={layers} />;
}
