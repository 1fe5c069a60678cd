/** Fly: the fleet on the map and in a table, and the commands for it. */
import { useMemo, useState } from "preact/hooks";
import { ALL_LAYERS, type LayerName, LayerSwitch, overlayOf } from "../../map/layer_switch";
import { areaLayer } from "../../map/layers/area";
import { gridLayer } from "../../map/layers/grid";
import { homesLayer } from "../../map/layers/homes";
import { pictureLayer } from "../../map/layers/picture";
import { targetsLayer } from "../../map/layers/targets";
import { trailsLayer } from "../../map/layers/trails";
import { vehiclesLayer } from "../../map/layers/vehicles";
import { waypointsLayer } from "../../map/layers/waypoints";
import { MapPanel } from "../../map/panel";
import { EventsPanel } from "../../panels/events";
import { TargetsPanel } from "../../panels/targets";
import { useShell } from "../../shell/context";
import { toggle } from "../../state/selection";
import { Controls } from "./controls";
import { FleetPanel } from "./fleet";
import "./fly.css";

const SWITCHABLE: readonly LayerName[] = ["vehicles", "targets", "waypoints", "trails", "homes", "area", "grid"];

export function FlyView() {
  const { state, changeSelection } = useShell();
  const [choice, setChoice] = useState(ALL_LAYERS);
  const layers = useMemo(() => {
    const vehicles = vehiclesLayer((id) => changeSelection((before) => toggle(before, id)));
    return [gridLayer, pictureLayer, areaLayer, homesLayer, trailsLayer, waypointsLayer, targetsLayer, vehicles].filter(
      (layer) => !choice.hidden.has(layer.id),
    );
  }, [choice.hidden]);
  return (
    <>
      <MapPanel layers={layers} overlay={overlayOf(choice)}>
        <LayerSwitch names={SWITCHABLE} choice={choice} onChange={setChoice} />
      </MapPanel>
      <div class="side">
        <Controls />
        <TargetsPanel targets={state.mission?.targets ?? []} />
      </div>
      <FleetPanel />
      <EventsPanel notices={state.notices} />
    </>
  );
}
