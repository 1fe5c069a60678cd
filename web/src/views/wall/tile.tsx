/** One live picture with its place, time and age. */
import { useLayoutEffect, useRef } from "preact/hooks";
import { SILENCE_LIMIT_MS, tileAge_s, type WallState } from "../../api/wall";
import { type Notation, written } from "../../coordinates";
import { age, quantity, timeOfDay } from "../../format";
import { texts } from "../../texts";
import { type Tile, titleOf } from "./tiles";

interface Props {
  tile: Tile;
  wall: WallState;
  notation: Notation;
  /** Size of the letters of a tile that fills the screen. */
  isLarge?: boolean;
}

export function TilePicture({ tile, wall, notation, isLarge = false }: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const shown = wall.shown.get(tile.name);
  const bitmap = shown?.bitmap;
  useLayoutEffect(() => {
    if (canvas.current === null || bitmap === undefined || bitmap.width === 0) return;
    canvas.current.width = bitmap.width;
    canvas.current.height = bitmap.height;
    canvas.current.getContext("2d")?.drawImage(bitmap, 0, 0);
  }, [bitmap]);
  const title = titleOf(tile);
  const nowMs = performance.now();
  const age_s = tileAge_s(wall, tile.name, nowMs);
  if (shown === undefined || age_s === null) {
    return (
      <figure class="wall-picture" data-testid={`tile-${tile.name}`} data-state="waiting">
        <div class="wall-image">
          <p>{texts.wall.waiting}</p>
        </div>
        <figcaption>
          <strong>{title}</strong>
        </figcaption>
      </figure>
    );
  }
  const isCutOff = nowMs - wall.heardAtMs > SILENCE_LIMIT_MS;
  const isOld = isCutOff || age_s >= (wall.head?.stale_s ?? 0);
  const place = placeText(shown.picture, notation);
  const time = timeOfDay(shown.picture.utc_s);
  const ageText = isOld ? oldText(age_s, isCutOff) : texts.wall.age(wholeAge(age_s));
  return (
    <figure
      class={`wall-picture ${isOld ? "is-old-picture" : ""} ${isLarge ? "is-large" : ""}`}
      data-testid={`tile-${tile.name}`}
      data-state={isOld ? "old" : "live"}
      data-utc={shown.picture.utc_s}
    >
      <div class="wall-image">
        <canvas ref={canvas} role="img" aria-label={[title, place, time, ageText].join(", ")} />
        {isOld && <p class="wall-old">{ageText}</p>}
      </div>
      <figcaption>
        <strong>{title}</strong>
        <span class="wall-place">{place}</span>
        <span>
          {time}, {texts.wall.age(wholeAge(age_s))}
        </span>
        {tile.kind === "thermal" && <Scale picture={shown.picture} />}
      </figcaption>
    </figure>
  );
}

type Picture = NonNullable<ReturnType<WallState["shown"]["get"]>>["picture"];

function Scale({ picture: { scale } }: { picture: Picture }) {
  const { wall } = texts;
  const text =
    scale === null
      ? wall.relative
      : wall.scale(...([scale.low, scale.high].map((value) => quantity(value, 1, scale.celsius ? "°C" : "")) as Ends));
  return (
    <span class="wall-scale">
      <span class="wall-palette" aria-hidden="true" />
      {text}
      {scale !== null && !scale.celsius && ` (${wall.levels})`}
    </span>
  );
}

type Ends = [low: string, high: string];

/** Age in whole seconds: tenths would flicker. */
const wholeAge = (age_s: number): string => (age_s < 120 ? quantity(Math.floor(age_s), 0, "s") : age(age_s));

const oldText = (age_s: number, isCutOff: boolean): string =>
  isCutOff ? texts.wall.cutOff(wholeAge(age_s)) : texts.wall.old(wholeAge(age_s));

function placeText({ latitude_deg, longitude_deg, at_camera }: Picture, notation: Notation): string {
  if (latitude_deg === null || longitude_deg === null) return texts.wall.noPlace;
  const place = written({ latitude_deg, longitude_deg }, notation);
  return at_camera ? texts.wall.at(place) : place;
}
