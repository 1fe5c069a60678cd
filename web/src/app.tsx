/** The page: reads the store, hands its parts to the panels. */
import { useEffect, useState } from "preact/hooks";
import type { Phase } from "./api/types";
import { MapPanel } from "./map/panel";
import { ChartPanel } from "./panels/chart";
import { Controls } from "./panels/controls";
import { EventsPanel } from "./panels/events";
import { Header } from "./panels/header";
import { PicturePanel } from "./panels/pictures";
import { PreflightPanel } from "./panels/preflight";
import { VehicleTable } from "./panels/vehicles";
import type { State } from "./state/state";
import type { Store } from "./state/store";
import { texts } from "./texts";
import { useTheme } from "./theme";

const BEFORE_START: ReadonlySet<Phase> = new Set<Phase>(["connect", "preflight", "ready"]);
/** Ages go on counting while no data comes. */
const AGEING_INTERVAL_MS = 1000;

export function App({ store }: { store: Store }) {
  const state = useStoreState(store);
  const [theme, setTheme] = useTheme();
  const [selected, setSelected] = useState<ReadonlySet<number>>(new Set());
  const { mission, connection } = state;
  const snapshotAge_s = (performance.now() - state.missionAtMs) / 1000;
  const toggle = (id: number): void => {
    setSelected((before) => {
      const after = new Set(before);
      if (!after.delete(id)) after.add(id);
      return after;
    });
  };
  return (
    <div class="page">
      <Header mission={mission} connection={connection} theme={theme} onTheme={setTheme} />
      {(connection === "lost" || connection === "incompatible") && (
        <p class="banner" role="alert" data-testid="banner">
          {connection === "lost" ? texts.connection.lostBanner : texts.connection.incompatibleBanner}
        </p>
      )}
      <main class="main">
        <Controls
          mission={mission}
          isConnected={connection === "open"}
          selected={selected}
          onClearSelection={() => setSelected(new Set())}
        />
        <MapPanel state={state} theme={theme} selected={selected} onSelect={toggle} />
        <VehicleTable mission={mission} snapshotAge_s={snapshotAge_s} selected={selected} onSelect={toggle} />
        <aside class="side">
          {mission === null || BEFORE_START.has(mission.phase) ? (
            <PreflightPanel checks={mission?.preflight ?? []} />
          ) : (
            <>
              <PicturePanel pictures={state.pictures} />
              <ChartPanel steps={state.steps} theme={theme} />
            </>
          )}
          <EventsPanel notices={state.notices} />
        </aside>
      </main>
    </div>
  );
}

function useStoreState(store: Store): State {
  const [state, setState] = useState(store.state);
  const [, setTick] = useState(0);
  useEffect(() => store.subscribe(setState), [store]);
  useEffect(() => {
    const timer = setInterval(() => setTick((tick) => tick + 1), AGEING_INTERVAL_MS);
    return () => clearInterval(timer);
  }, []);
  return state;
}
