/** Fleet as a table or as tiles, the worst first; commands go to the selected vehicles. */
import { useMemo, useRef, useState } from "preact/hooks";
import type { Vehicle } from "../../api/types";
import { useShell } from "../../shell/context";
import { extend, toggle } from "../../state/selection";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { useAtMostEvery } from "../../ui/pacing";
import { Panel } from "../../ui/panel";
import "./fleet.css";
import { type FleetSettings, layoutOf, storedSettings, storeSettings } from "./fleet_settings";
import { FleetTable } from "./fleet_table";
import { FleetTiles } from "./fleet_tiles";
import { FleetWindow } from "./fleet_window";
import { countRows, type Filter, FILTERS, makeRows, orderedIds, steadyOrder } from "./rows";

/** Numbers that change faster cannot be read; the map shows every change. */
const READING_INTERVAL_MS = 500;

const NO_VEHICLES: readonly Vehicle[] = [];

export function FleetPanel() {
  const { state, snapshotAge_s, selection, changeSelection } = useShell();
  const [filter, setFilter] = useState<Filter>("all");
  const [settings, setSettings] = useState(storedSettings);
  // As wide as it was at first: a phone that is turned keeps its tiles.
  const [screen_px] = useState(() => innerWidth);
  const [isWindowOpen, setWindowOpen] = useState(false);
  // What an operator is about to press does not move.
  const [isPointed, setPointed] = useState(false);
  const vehicles = useAtMostEvery(state.mission?.vehicles ?? NO_VEHICLES, READING_INTERVAL_MS);
  // Ages advance in whole seconds while no data arrive.
  const age_s = Math.floor(snapshotAge_s);
  const rows = useMemo(() => makeRows(vehicles, snapshotAge_s), [vehicles, age_s]);
  const wanted = orderedIds(rows, filter, settings.order);
  const shown = useRef<readonly number[]>(wanted);
  shown.current = isPointed ? steadyOrder(shown.current, wanted) : wanted;
  const order = shown.current.join();
  const layout = layoutOf(settings, vehicles.length, screen_px);
  const pick = (id: number, isRange: boolean): void =>
    changeSelection((before) => (isRange ? extend(before, id, shown.current) : toggle(before, id)));
  const list = useMemo(() => {
    const byId = new Map(rows.map((row) => [row.vehicle.vehicle_id, row]));
    const listed = shown.current.flatMap((id) => byId.get(id) ?? []);
    const props = { rows: listed, snapshotAge_s, selected: selection.ids, onPick: pick };
    return layout === "table" ? <FleetTable {...props} columns={settings.columns} /> : <FleetTiles {...props} />;
  }, [rows, order, layout, settings.columns, selection.ids, age_s]);

  const change = (changed: FleetSettings): void => {
    storeSettings(changed);
    setSettings(changed);
  };
  const counts = countRows(rows);
  const label = (name: Filter): string => `${texts.fleet.filters[name]} ${counts[name]}`;
  return (
    <Panel
      title={texts.fleet.panel}
      testId="vehicles"
      class={`fleet is-${layout}`}
      aside={
        <div class="fleet-head">
          <Choice
            label={texts.fleet.filter}
            testId="fleet-filter"
            values={FILTERS}
            chosen={filter}
            labels={{
              all: label("all"),
              attention: label("attention"),
              airborne: label("airborne"),
              battery: label("battery"),
            }}
            onChoose={setFilter}
          />
          <button type="button" data-testid="fleet-view" onClick={() => setWindowOpen(true)}>
            {texts.fleet.view}
          </button>
        </div>
      }
    >
      {shown.current.length === 0 ? (
        <p class="empty">{vehicles.length === 0 ? texts.fleet.none : texts.fleet.nonePass}</p>
      ) : (
        <div
          class="scroll"
          tabIndex={0}
          role="group"
          aria-label={texts.fleet.panel}
          onPointerEnter={() => setPointed(true)}
          onPointerLeave={() => setPointed(false)}
          onFocusCapture={() => setPointed(true)}
          onBlurCapture={() => setPointed(false)}
        >
          {list}
        </div>
      )}
      {isWindowOpen && (
        <FleetWindow settings={settings} layout={layout} onChange={change} onClose={() => setWindowOpen(false)} />
      )}
    </Panel>
  );
}
