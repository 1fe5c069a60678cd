/** Images of the ground at their true positions, north up: moved, zoomed, compared and measured in metres. */
import type { ComponentChildren } from "preact";
import { useRef, useState } from "preact/hooks";
import type { Geodetic, Target } from "../../api/types";
import { written } from "../../coordinates";
import { eastNorth, quantity } from "../../format";
import { type Bounds, placeAt, toLngLat } from "../../geometry";
import { useShell } from "../../shell/context";
import type { EnuPoint } from "../../state/state";
import { texts } from "../../texts";
import { type Size, useSize } from "../../ui/use_size";
import { useGestures } from "./use_gestures";
import { fitted, panned, scaleBar, toGround, toScreen, type Viewport, zoomed } from "./viewport";

/** Image with its bounds on the ground. */
export interface Placed {
  readonly url: string;
  readonly bounds: Bounds;
  readonly label: string;
}

interface Props {
  picture: Placed | null;
  /** Image on the left, up to `swipe` of the width. */
  before: Placed | null;
  swipe: number;
  origin: Geodetic | null;
  targets: readonly Target[];
  measured: readonly EnuPoint[];
  /** Called while measuring when the ground is tapped or M is pressed. */
  onMeasure: ((point: EnuPoint) => void) | null;
  viewport: Viewport | null;
  onViewport(viewport: Viewport): void;
  /** Content of the upper corner. */
  children?: ComponentChildren;
}

const KEY_PAN_PX = 60;
const KEY_ZOOM = 1.4;
const WIDEST_SCALE_PX = 140;

export function Stage(props: Props) {
  const { picture, before, swipe, origin, targets, measured, onMeasure, onViewport } = props;
  const { notation } = useShell();
  const element = useRef<HTMLDivElement>(null);
  const size = useSize(element);
  const [cursor, setCursor] = useState<EnuPoint | null>(null);
  const viewport = props.viewport ?? (picture && size ? fitted(picture.bounds, size) : null);
  useGestures(element, {
    onMove: (by, factor, at) => viewport && size && onViewport(zoomed(panned(viewport, by), size, factor, at)),
    onTap: (at) => viewport && size && onMeasure?.(toGround(viewport, size, at)),
    onHover: (at) => setCursor(at && viewport && size ? toGround(viewport, size, at) : null),
  });
  const press = (event: KeyboardEvent): void => {
    if (!viewport || !size || event.ctrlKey || event.metaKey || event.altKey) return;
    const pans = {
      ArrowLeft: [KEY_PAN_PX, 0],
      ArrowRight: [-KEY_PAN_PX, 0],
      ArrowUp: [0, KEY_PAN_PX],
      ArrowDown: [0, -KEY_PAN_PX],
    } as const;
    const by = pans[event.key as keyof typeof pans];
    const factor = { "+": KEY_ZOOM, "=": KEY_ZOOM, "-": 1 / KEY_ZOOM }[event.key];
    if (by !== undefined) onViewport(panned(viewport, by));
    else if (factor !== undefined) onViewport(zoomed(viewport, size, factor, [size.width_px / 2, size.height_px / 2]));
    else if (event.key === "Home" && picture) onViewport(fitted(picture.bounds, size));
    else if (event.key.toLowerCase() === "m" && onMeasure) onMeasure(viewport.centre);
    else return;
    event.preventDefault();
  };
  const place = cursor && origin ? placeAt(toLngLat(origin, cursor)) : null;

  return (
    <div class="stage-frame">
      <div
        ref={element}
        class={`stage ${onMeasure ? "is-measuring" : ""}`}
        tabIndex={0}
        role="application"
        aria-label={texts.see.stage}
        aria-describedby="stage-keys"
        data-testid="stage"
        data-metres-per-px={viewport?.metresPerPx}
        onKeyDown={press}
      >
        {viewport && size && (
          <>
            {picture && <Layer placed={picture} viewport={viewport} size={size} testId="picture" />}
            {before && (
              <div class="stage-before" style={{ clipPath: `inset(0 ${100 * (1 - swipe)}% 0 0)` }}>
                <Layer placed={before} viewport={viewport} size={size} testId="picture-before" />
              </div>
            )}
            <Drawing {...{ viewport, size, targets, measured }} isAiming={onMeasure !== null} />
            {before && <div class="stage-swipe" style={{ left: `${100 * swipe}%` }} />}
            <Scale metresPerPx={viewport.metresPerPx} />
          </>
        )}
      </div>
      <p id="stage-keys" class="visually-hidden">
        {texts.see.stageKeys}
      </p>
      <div class="stage-foot">
        <span data-testid="picture-label">{picture?.label}</span>
        <span class="stage-cursor" data-testid="stage-cursor">
          {cursor && eastNorth(cursor[0], cursor[1])}
          {place && ` · ${written(place, notation)}`}
        </span>
      </div>
      {props.children}
    </div>
  );
}

interface LayerProps {
  placed: Placed;
  viewport: Viewport;
  size: Size;
  testId: string;
}

function Layer({ placed: { url, bounds, label }, viewport, size, testId }: LayerProps) {
  const [left, top] = toScreen(viewport, size, [bounds.west_m, bounds.north_m]);
  const [right, bottom] = toScreen(viewport, size, [bounds.east_m, bounds.south_m]);
  const style = {
    width: `${right - left}px`,
    height: `${bottom - top}px`,
    transform: `translate(${left}px, ${top}px)`,
  };
  // The image is decoded already: synchronous decoding paints it at once, without an empty frame.
  return (
    <img src={url} alt={texts.see.alt(label)} style={style} decoding="sync" draggable={false} data-testid={testId} />
  );
}

interface DrawingProps {
  viewport: Viewport;
  size: Size;
  targets: readonly Target[];
  measured: readonly EnuPoint[];
  /** Whether to mark the centre, where the key M sets a point. */
  isAiming: boolean;
}

function Drawing({ viewport, size, targets, measured, isAiming }: DrawingProps) {
  const place = (point: EnuPoint): readonly [number, number] => toScreen(viewport, size, point);
  const [x, y] = [size.width_px / 2, size.height_px / 2];
  return (
    <svg class="stage-drawing" aria-hidden="true">
      {targets.map(({ track_id: id, position }) => {
        const [cx, cy] = place([position.east_m, position.north_m]);
        return (
          <g key={id} class="stage-target">
            <circle cx={cx} cy={cy} r={Math.max(10, 1 / viewport.metresPerPx)} />
            <text x={cx + 14} y={cy - 12}>
              {texts.map.target(id)}
            </text>
          </g>
        );
      })}
      {isAiming && <path class="stage-aim" d={`M${x - 9} ${y}H${x + 9}M${x} ${y - 9}V${y + 9}`} />}
      <polyline class="stage-measure" points={measured.map((point) => place(point).join()).join(" ")} />
      {measured.map((point, index) => {
        const [cx, cy] = place(point);
        return <circle key={index} class="stage-measure" cx={cx} cy={cy} r={4} />;
      })}
    </svg>
  );
}

function Scale({ metresPerPx }: { metresPerPx: number }) {
  const { length_m, width_px } = scaleBar(metresPerPx, WIDEST_SCALE_PX);
  return (
    <div class="stage-scale" style={{ width: `${width_px}px` }} data-testid="stage-scale">
      {length_m >= 1 ? quantity(length_m, 0, "m") : quantity(100 * length_m, 0, "cm")}
    </div>
  );
}
