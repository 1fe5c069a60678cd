/** Plan: where is searched and what no vehicle may leave. */
import { areaLayer } from "../../map/layers/area";
import { gridLayer } from "../../map/layers/grid";
import { homesLayer } from "../../map/layers/homes";
import { MapPanel } from "../../map/panel";

const LAYERS = [gridLayer, areaLayer, homesLayer];

export function PlanView() {
  return <MapPanel layers={LAYERS} />;
}
