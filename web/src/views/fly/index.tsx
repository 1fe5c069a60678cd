/** View Fly: the fleet on the map and in a table, and its commands. */
import { useMemo } from "preact/hooks";
import { LayerSwitch, overlayOf, shownOf, useLayerChoice } from "../../map/layer_switch";
import { areaLayer } from "../../map/layers/area";
import { footprintsLayer } from "../../map/layers/footprints";
import { heightsLayer } from "../../map/layers/heights";
import { homesLayer } from "../../map/layers/homes";
import { legsLayer } from "../../map/layers/legs";
import { pictureLayer, searchedLayer } from "../../map/layers/picture";
import { targetsLayer } from "../../map/layers/targets";
import { trailsLayer } from "../../map/layers/trails";
import { vehiclesLayer } from "../../map/layers/vehicles";
import { waypointsLayer } from "../../map/layers/waypoints";
import { MapPanel } from "../../map/panel";
import { SearchedLegend } from "../../map/searched_legend";
import { useBaseLayers } from "../../map/use_base";
import { EventsPanel } from "../../panels/events";
import { RelayPanel } from "../../panels/relay";
import { SearchedPanel } from "../../panels/searched";
import { SharingPanel } from "../../panels/sharing";
import { TargetsPanel } from "../../panels/targets";
import { useShell } from "../../shell/context";
import { toggle } from "../../state/selection";
import { AlertedFinding } from "./alerted";
import { Controls } from "./controls";
import { FleetPanel } from "./fleet";
import "./fly.css";
import { VehiclePanel } from "./vehicle_panel";

export function FlyView() {
  const { state, changeSelection } = useShell();
  const [choice, setChoice] = useLayerChoice();
  const base = useBaseLayers();
  const layers = useMemo(() => {
    const vehicles = vehiclesLayer((id) => changeSelection((before) => toggle(before, id)));
    return [
      ...base,
      searchedLayer,
      pictureLayer,
      areaLayer,
      legsLayer,
      homesLayer,
      trailsLayer,
      footprintsLayer,
      waypointsLayer,
      targetsLayer,
      heightsLayer,
      vehicles,
    ];
  }, [base]);
  return (
    <>
      <MapPanel layers={shownOf(layers, choice)} overlay={overlayOf(choice)}>
        <LayerSwitch layers={layers} choice={choice} onChange={setChoice} />
        <SearchedLegend isShown={!choice.hidden.has(searchedLayer.id)} />
      </MapPanel>
      <AlertedFinding />
      <div class="side">
        <Controls />
        <VehiclePanel />
        <SearchedPanel mission={state.mission} hasFiles={state.capabilities.viewer} />
        <RelayPanel mission={state.mission} />
        <TargetsPanel targets={state.mission?.targets ?? []} later={state.mission?.left_for_later ?? []} />
        <SharingPanel channels={state.mission?.sharing ?? []} />
      </div>
      <FleetPanel />
      <EventsPanel notices={state.notices} acknowledgements={state.mission?.acknowledgements ?? []} />
    </>
  );
}
