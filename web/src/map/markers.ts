/** Vehicles and the target as HTML on top of the map: labels without a glyph server, and readable by screen readers. */
import { type Map as MapLibreMap, Marker } from "maplibre-gl";
import type { Geodetic, Mission, Vehicle } from "../api/types";
import { toLngLat } from "../geometry";
import { isStale } from "../state/freshness";
import { texts } from "../texts";
import { vehicleColour } from "./palette";

const ARROW = "M12 2 L19 20 L12 15.5 L5 20 Z";
const SVG = "http://www.w3.org/2000/svg";

interface VehicleMarker {
  marker: Marker;
  element: HTMLElement;
  arrow: SVGElement;
}

export class Markers {
  private readonly vehicles = new Map<number, VehicleMarker>();
  private target: Marker | null = null;

  constructor(
    private readonly map: MapLibreMap,
    private readonly onSelect: (vehicleId: number) => void,
  ) {}

  update(origin: Geodetic, mission: Mission, selected: ReadonlySet<number>, snapshotAge_s: number): void {
    const present = new Set<number>();
    for (const vehicle of mission.vehicles) {
      if (vehicle.position === null) continue;
      present.add(vehicle.vehicle_id);
      const place = toLngLat(origin, [vehicle.position.east_m, vehicle.position.north_m]);
      const { marker, element, arrow } = this.vehicles.get(vehicle.vehicle_id) ?? this.add(vehicle, place);
      marker.setLngLat(place);
      arrow.style.transform = `rotate(${vehicle.heading_deg ?? 0}deg)`;
      element.classList.toggle("is-selected", selected.has(vehicle.vehicle_id));
      element.classList.toggle("is-stale", isStale(vehicle, snapshotAge_s));
      element.classList.toggle("is-refused", vehicle.refusal !== null);
      element.dataset["east"] = vehicle.position.east_m.toFixed(2);
      element.dataset["north"] = vehicle.position.north_m.toFixed(2);
    }
    for (const [id, { marker }] of this.vehicles) {
      if (present.has(id)) continue;
      marker.remove();
      this.vehicles.delete(id);
    }
    this.updateTarget(origin, mission);
  }

  private add({ vehicle_id: id }: Vehicle, place: [number, number]): VehicleMarker {
    const element = document.createElement("button");
    element.type = "button";
    element.tabIndex = -1; // the table's rows are the keyboard's way to select
    element.className = "vehicle-marker";
    element.dataset["testid"] = `marker-${id}`;
    element.setAttribute("aria-label", texts.map.vehicle(id));
    element.style.setProperty("--colour", vehicleColour(id));
    element.onclick = () => this.onSelect(id);
    const arrow = document.createElementNS(SVG, "svg");
    arrow.setAttribute("viewBox", "0 0 24 24");
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("d", ARROW);
    arrow.append(path);
    const label = document.createElement("span");
    label.textContent = String(id);
    element.append(arrow, label);
    const added = { marker: new Marker({ element }).setLngLat(place).addTo(this.map), element, arrow };
    this.vehicles.set(id, added);
    return added;
  }

  private updateTarget(origin: Geodetic, mission: Mission): void {
    if (mission.target === null) {
      this.target?.remove();
      this.target = null;
      return;
    }
    const { east_m, north_m } = mission.target.position;
    const place = toLngLat(origin, [east_m, north_m]);
    this.target ??= this.makeTarget(place);
    this.target.setLngLat(place);
  }

  private makeTarget(place: [number, number]): Marker {
    const element = document.createElement("div");
    element.className = "target-marker";
    element.dataset["testid"] = "marker-target";
    element.setAttribute("role", "img");
    element.setAttribute("aria-label", texts.map.target);
    return new Marker({ element }).setLngLat(place).addTo(this.map);
  }
}
