/**
 * Fewer drawings of the map at rest: what layers change at about the same time is drawn together.
 *
 * MapLibre draws whenever a tile of any source is ready, and again to place labels, which makes four drawings of one
 * message of the station. Without a graphics card each of them takes the processor a twentieth of a second.
 */
import type { Map as MapLibreMap } from "maplibre-gl";

/** Time in which changes are gathered. */
const GATHERING_MS = 80;
/** Time after an input in which everything is drawn at once, so that a gesture begins without delay. */
const ATTENTIVE_MS = 300;
const INPUTS = ["pointerdown", "pointermove", "wheel", "keydown"];

/** Gather changes of the layers while nobody touches or moves the map; returns a function that ends it. */
export function gatherDrawings(map: MapLibreMap): () => void {
  const container = map.getCanvasContainer();
  const draw = map.triggerRepaint.bind(map);
  let timer: number | null = null;
  let touchedAtMs = -Infinity;

  const note = (): void => {
    touchedAtMs = performance.now();
  };
  for (const input of INPUTS) container.addEventListener(input, note, { capture: true, passive: true });
  map.on("move", draw); // of another size, too: the canvas is empty until it is drawn
  map.triggerRepaint = () => {
    if (map.isMoving() || performance.now() - touchedAtMs < ATTENTIVE_MS) return draw();
    timer ??= window.setTimeout(() => {
      timer = null;
      draw();
    }, GATHERING_MS);
  };
  return () => {
    if (timer !== null) window.clearTimeout(timer);
    for (const input of INPUTS) container.removeEventListener(input, note, { capture: true });
    map.off("move", draw);
    map.triggerRepaint = draw;
  };
}
