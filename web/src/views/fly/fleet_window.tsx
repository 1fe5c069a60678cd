/** Window with the settings of the fleet's list on this screen. */
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { Dialog } from "../../ui/dialog";
import { COLUMNS, type FleetSettings, type Layout, LAYOUTS, ORDERS } from "./fleet_settings";

interface Props {
  settings: FleetSettings;
  /** Layout that is shown, by choice or by the size of the fleet. */
  layout: Layout;
  onChange(settings: FleetSettings): void;
  onClose(): void;
}

export function FleetWindow({ settings, layout, onChange, onClose }: Props) {
  const { fleet } = texts;
  const { columns } = settings;
  return (
    <Dialog title={fleet.viewTitle} testId="fleet-window" onClose={onClose}>
      <h3>{fleet.layout}</h3>
      <Choice
        label={fleet.layout}
        testId="fleet-layout"
        values={LAYOUTS}
        chosen={layout}
        labels={fleet.layouts}
        onChoose={(chosen) => onChange({ ...settings, layout: chosen })}
      />
      <h3>{fleet.order}</h3>
      <Choice
        label={fleet.order}
        testId="fleet-order"
        values={ORDERS}
        chosen={settings.order}
        labels={fleet.orders}
        onChoose={(order) => onChange({ ...settings, order })}
      />
      <fieldset class="fleet-columns">
        <legend>{fleet.columnsTitle}</legend>
        {COLUMNS.map((column) => (
          <label key={column}>
            <input
              type="checkbox"
              data-testid={`fleet-column-${column}`}
              checked={columns.includes(column)}
              onChange={({ currentTarget: { checked } }) =>
                onChange({
                  ...settings,
                  columns: COLUMNS.filter((other) => (other === column ? checked : columns.includes(other))),
                })
              }
            />{" "}
            {fleet.columns[column]}
          </label>
        ))}
      </fieldset>
    </Dialog>
  );
}
