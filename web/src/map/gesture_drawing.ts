/**
 * Coarser drawing of the map during gestures, where no graphics card draws it: the processor then fills every pixel, and
 * half as many of them keep a dragged or zoomed map fluid. At rest the map is drawn with all pixels.
 */
import type { Map as MapLibreMap } from "maplibre-gl";

/** Share of the pixels along an edge that is drawn during a gesture. */
const COARSE_SHARE = 0.7;
/** Time without pointer, wheel and movement after which all pixels are drawn again. */
const REST_MS = 250;
/** Names by which browsers' renderers without a graphics card call themselves. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|basic render|software/i;

/** Draw the map coarsely during gestures if the browser has no graphics card; returns a function that ends it. */
export function drawGesturesCoarsely(map: MapLibreMap): () => void {
  if (!SOFTWARE.test(rendererOf(map))) return () => undefined;
  const container = map.getCanvasContainer();
  let timer: number | null = null;
  let isHeld = false;

  const settle = (): void => {
    if (timer !== null) window.clearTimeout(timer);
    timer = window.setTimeout(() => {
      if (isHeld || map.isMoving()) return settle();
      timer = null;
      map.setPixelRatio(window.devicePixelRatio);
    }, REST_MS);
  };
  // Before the map's own handlers: a change of resolution ends a gesture that they have begun.
  const coarsen = (): void => {
    if (timer === null) map.setPixelRatio(window.devicePixelRatio * COARSE_SHARE);
    settle();
  };
  const press = (): void => {
    isHeld = true;
    coarsen();
  };
  const release = (): void => {
    isHeld = false;
  };
  container.addEventListener("pointerdown", press, { capture: true });
  container.addEventListener("wheel", coarsen, { capture: true, passive: true });
  window.addEventListener("pointerup", release);
  window.addEventListener("pointercancel", release);
  return () => {
    if (timer !== null) window.clearTimeout(timer);
    container.removeEventListener("pointerdown", press, { capture: true });
    container.removeEventListener("wheel", coarsen, { capture: true });
    window.removeEventListener("pointerup", release);
    window.removeEventListener("pointercancel", release);
  };
}

/** Name of what draws the map's canvas; empty where the browser does not tell. */
function rendererOf(map: MapLibreMap): string {
  const gl = map.getCanvas().getContext("webgl2") ?? map.getCanvas().getContext("webgl");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  return gl && names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : "";
}
