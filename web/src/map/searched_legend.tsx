/** Legend of the layer that shows what has been searched. */
import { useShell } from "../shell/context";
import { searchedKind } from "../state/searched";
import { texts } from "../texts";

export function SearchedLegend({ isShown }: { isShown: boolean }) {
  const { state } = useShell();
  const kind = searchedKind(state.pictures);
  if (!isShown || kind === null) return null;
  const { title, low, high } = kind === "detection" ? texts.searched.detectionLegend : texts.searched.viewsLegend;
  return (
    <div class="map-legend" data-testid="searched-legend" role="img" aria-label={`${title}: ${low} – ${high}`}>
      <span>{title}</span>
      <span class="map-legend-scale">
        {low}
        <i class="map-legend-colours" />
        {high}
      </span>
    </div>
  );
}
