/** View Wall: live pictures of all cameras and of the integral. */
import { useRef, useState } from "preact/hooks";
import { useShell } from "../../shell/context";
import { readStored, store } from "../../storage";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Panel } from "../../ui/panel";
import { useSize } from "../../ui/use_size";
import { TileChoice } from "./choice";
import { Follow } from "./follow";
import { TilePicture } from "./tile";
import { columnsFor, firstTiles, tileOf, tilesOf, titleOf } from "./tiles";
import { useWall } from "./use_wall";
import { VideoPanel } from "./video";
import "./wall.css";

const TILES_KEY = "aos-gcs-wall";
const RATE_KEY = "aos-gcs-wall-rate";
const RATES = ["normal", "low"] as const;
const RATE_HZ = { normal: null, low: 0.5 } as const;
/** Smallest width of a tile, with room for a place. */
const LEAST_PX = 165;

export function WallView() {
  const { state } = useShell();
  if (!state.capabilities.wall) {
    return (
      <Panel title={texts.wall.panel} testId="wall" class="wall-panel">
        <p class="empty">{state.mission === null ? texts.waiting : texts.wall.missing}</p>
      </Panel>
    );
  }
  return <Wall />;
}

function Wall() {
  const { state, route, navigate, notation } = useShell();
  const [stored, setStored] = useState(storedTiles);
  const [rate, setRate] = useState(() => RATES.find((one) => one === readStored(RATE_KEY)) ?? "normal");
  const [first, setFirst] = useState<readonly string[]>([]);
  const grid = useRef<HTMLDivElement>(null);
  const size = useSize(grid);
  const followed = tileOf(route.params["follow"] ?? "");
  const chosen = stored ?? first;
  // While one tile fills the screen, it has the whole link.
  const wall = useWall(followed === null ? chosen : [], false, RATE_HZ[rate]);
  const there = wall.head?.tiles ?? [];
  const proposed = firstTiles(there);
  if (stored === null && proposed.join() !== first.join()) setFirst(proposed);
  const choose = (tiles: readonly string[]): void => {
    store(TILES_KEY, JSON.stringify(tiles));
    setStored(tiles);
  };
  const tiles = tilesOf(chosen);
  const columns = size === null ? 1 : columnsFor(tiles.length, size.width_px, size.height_px, LEAST_PX);
  return (
    <>
      <Panel title={texts.wall.panel} testId="wall" class="wall-panel">
        <div ref={grid} class="wall-grid scroll" style={{ "--columns": columns }} tabIndex={0}>
          {tiles.map((tile) => (
            <div key={tile.name} class="wall-tile">
              <TilePicture {...{ tile, wall, notation }} />
              <button
                type="button"
                class="wall-follow-button"
                data-testid={`follow-${tile.name}`}
                aria-label={texts.wall.follow(titleOf(tile))}
                onClick={() => navigate("wall", { follow: tile.name })}
              >
                {texts.wall.followShort}
              </button>
            </div>
          ))}
        </div>
        {tiles.length === 0 && <p class="empty">{there.length === 0 ? texts.wall.none : texts.wall.noneChosen}</p>}
      </Panel>
      <Panel title={texts.wall.choose} testId="wall-choice" class="wall-side scroll">
        <TileChoice there={withChosen(there, chosen)} chosen={chosen} onChoose={choose} />
        <h3>{texts.wall.rate}</h3>
        <Choice
          label={texts.wall.rate}
          testId="wall-rate"
          values={RATES}
          chosen={rate}
          labels={texts.wall.rates}
          onChoose={(value) => {
            store(RATE_KEY, value);
            setRate(value);
          }}
        />
        <p class="small">{texts.wall.rateHint}</p>
        {state.capabilities.video && <VideoPanel tiles={chosen.filter((name) => there.includes(name))} />}
      </Panel>
      {followed && <Follow tile={followed} rate_hz={RATE_HZ[rate]} onClose={() => navigate("wall")} />}
    </>
  );
}

/** All tiles that there are, and those that are chosen and not there now: they can be taken away. */
function withChosen(there: readonly string[], chosen: readonly string[]): string[] {
  const rank = (name: string): number => tileOf(name)?.vehicleId ?? -1;
  return [...new Set([...there, ...chosen])].sort((a, b) => rank(a) - rank(b) || a.localeCompare(b));
}

function storedTiles(): readonly string[] | null {
  try {
    const names: unknown = JSON.parse(readStored(TILES_KEY) ?? "null");
    if (!Array.isArray(names)) return null;
    return names.filter((name): name is string => typeof name === "string" && tileOf(name) !== null);
  } catch {
    return null;
  }
}
