/** The selected vehicle: what it needs, its camera's latest frame, battery, height and link over time, and its values. */
import { useMemo, useState } from "preact/hooks";
import { frameUrl } from "../../api/viewer";
import type { FrameKind, Vehicle } from "../../api/types";
import { written } from "../../coordinates";
import { age, bearing, distance, eastNorth, gpsFix, quantity } from "../../format";
import { vehicleColour } from "../../map/palette";
import { useShell } from "../../shell/context";
import { routeHash } from "../../shell/route";
import { attentionOf } from "../../state/attention";
import { linkAge_s } from "../../state/freshness";
import { allHeights, heightWords } from "../../state/heights";
import type { VehicleSample } from "../../state/samples";
import { NO_SELECTION } from "../../state/selection";
import { texts } from "../../texts";
import { type Fact, Facts } from "../../ui/facts";
import { useAtMostEvery } from "../../ui/pacing";
import { Panel } from "../../ui/panel";
import { Sparkline } from "../../ui/sparkline";

/** Frames of all vehicles are read for one of them: the station has better things to do more often. */
const PICTURE_INTERVAL_MS = 5000;
const PICTURE_PX = 480;

export function VehiclePanel() {
  const { state, selection, changeSelection, snapshotAge_s } = useShell();
  const [id] = selection.ids;
  const vehicle = state.mission?.vehicles.find(({ vehicle_id }) => vehicle_id === id);
  if (selection.ids.size !== 1 || vehicle === undefined) return null;
  const { causes, level } = attentionOf(vehicle, snapshotAge_s);
  return (
    <Panel
      title={texts.vehicle.panel(vehicle.vehicle_id)}
      testId="vehicle-panel"
      class="vehicle-panel"
      aside={
        <button type="button" data-testid="vehicle-close" onClick={() => changeSelection(() => NO_SELECTION)}>
          {texts.vehicle.close}
        </button>
      }
    >
      <p>
        <i class="swatch" style={{ background: vehicleColour(vehicle.vehicle_id) }} />
        <b>{texts.names.task[vehicle.task]}</b>
        {vehicle.mode !== "unknown" && ` · ${texts.names.mode[vehicle.mode]}`}
      </p>
      {causes.length > 0 && (
        <ul class={`causes is-${level}`} data-testid="vehicle-causes">
          {causes.map((cause) => (
            <li key={cause}>{cause}</li>
          ))}
        </ul>
      )}
      <CameraPicture key={vehicle.vehicle_id} vehicle={vehicle} />
      <Curves vehicle={vehicle} />
      <Facts facts={vehicleFacts(vehicle, snapshotAge_s)} class="rows" />
      <Where vehicle={vehicle} />
    </Panel>
  );
}

function CameraPicture({ vehicle: { vehicle_id: id, camera } }: { vehicle: Vehicle }) {
  const { capabilities, mission } = useShell().state;
  const [kind, setKind] = useState<FrameKind | null>("colour");
  const step = useAtMostEvery(camera?.last_step ?? null, PICTURE_INTERVAL_MS);
  if (mission === null || step === null || !capabilities.viewer || kind === null) return null;
  return (
    <a class="vehicle-picture" href={routeHash("see")} title={texts.vehicle.toFrames}>
      <img
        src={frameUrl({ missionId: mission.mission_id, step, vehicleId: id, kind }, PICTURE_PX)}
        alt={texts.vehicle.frame(texts.names.frame[kind], id, step)}
        data-testid="vehicle-picture"
        onError={() => setKind(kind === "colour" ? "thermal" : null)}
      />
      <span class="small">{texts.vehicle.caption(texts.names.frame[kind], step)}</span>
    </a>
  );
}

function Curves({ vehicle }: { vehicle: Vehicle }) {
  const { samples } = useShell().state;
  const { vehicle_id: id, battery_percent, link } = vehicle;
  const curves = useMemo(() => {
    const of = (figure: keyof VehicleSample) => samples.map(({ vehicles }) => vehicles.get(id)?.[figure] ?? null);
    return { battery: of("battery_percent"), height: of("height_m"), link: of("roundTrip_ms") };
  }, [samples, id]);
  return (
    <div class="curves">
      <Sparkline
        label={texts.fleet.columns.battery}
        words={quantity(battery_percent, 0, "%")}
        values={curves.battery}
        span={10}
      />
      <Sparkline label={texts.fleet.columns.height} words={heightWords(vehicle)} values={curves.height} span={5} />
      <Sparkline
        label={texts.vehicle.roundTrip}
        words={quantity(link?.round_trip_ms, 0, "ms")}
        values={curves.link}
        span={50}
      />
    </div>
  );
}

/** Values of a vehicle that are worth a line; unknown ones are dashes. */
function vehicleFacts(vehicle: Vehicle, snapshotAge_s: number): Fact[] {
  const { battery_percent, battery_voltage_v, gps_fix, satellites, camera, position, home } = vehicle;
  const away_m =
    position === null || home === null
      ? null
      : Math.hypot(position.east_m - home.east_m, position.north_m - home.north_m);
  return [
    [texts.fleet.columns.battery, `${quantity(battery_percent, 0, "%")} · ${quantity(battery_voltage_v, 1, "V")}`],
    [texts.fleet.columns.gps, `${gpsFix(gps_fix)} · ${quantity(satellites, 0)}`],
    [texts.fleet.columns.height, allHeights(vehicle)],
    [texts.vehicle.speed, quantity(vehicle.ground_speed_mps, 1, "m/s")],
    [texts.vehicle.away, away_m === null ? "" : distance(away_m)],
    [
      texts.fleet.columns.link,
      `${age(linkAge_s(vehicle, snapshotAge_s))} · ${quantity(vehicle.packet_loss_percent, 0, "%")}`,
    ],
    [texts.vehicle.frames, camera === null ? "" : texts.vehicle.framesOf(camera.frames, camera.failures)],
    [texts.vehicle.heading, vehicle.heading_deg === null ? "" : bearing(vehicle.heading_deg)],
  ];
}

function Where({ vehicle: { position } }: { vehicle: Vehicle }) {
  const { notation } = useShell();
  if (position === null) return null;
  const { latitude_deg, longitude_deg, east_m, north_m } = position;
  const isPlaced = latitude_deg !== null && longitude_deg !== null;
  return (
    <p class="small" data-testid="vehicle-position">
      {isPlaced ? written({ latitude_deg, longitude_deg }, notation) : eastNorth(east_m, north_m)}
    </p>
  );
}
