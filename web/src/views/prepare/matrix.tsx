/** Matrix of vehicles and checks: the Tab key stops once, and the arrow keys move from cell to cell. */
import { useRef } from "preact/hooks";
import type { PreflightCheck } from "../../api/types";
import { said, texts } from "../../texts";
import { useSize } from "../../ui/use_size";
import { areChecksRows, keyOf, type Matrix, nameOf, subjectOf, type CellStatus, cellStatusOf } from "./checks";

const SIGNS: Readonly<Record<CellStatus, string>> = { pass: "✓", warn: "!", fail: "✗", overridden: "⊘" };
const STEPS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowUp: [-1, 0],
  ArrowDown: [1, 0],
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
};

/** With more columns their names are rotated, so that the matrix fits the screen. */
const UPRIGHT_NAMES = 8;

interface Props {
  matrix: Matrix;
  chosen: string | null;
  onChoose(key: string): void;
}

export function PreflightMatrix({ matrix, chosen, onChoose }: Props) {
  const { mission, names, rows } = matrix;
  const scroll = useRef<HTMLDivElement>(null);
  const size = useSize(scroll);
  const isTurned = size !== null && areChecksRows(matrix, size.width_px);
  const ids = rows.map(({ id }) => String(id));
  const labels = names.map(nameOf);
  const lines = isTurned ? names.map((_, index) => rows.map(({ checks }) => checks[index])) : rows.map((r) => r.checks);
  const [columns, heads] = isTurned ? [ids, labels] : [labels, ids];
  const all = rows.flatMap(({ checks }) => checks).filter((check) => check !== undefined);
  const stop = all.find((check) => keyOf(check) === chosen) ?? all.find((check) => check.blocks) ?? all[0];
  return (
    <div class="scroll" ref={scroll} onKeyDown={moveFocus}>
      {mission.length > 0 && (
        <div class="mission-checks" role="group" aria-label={texts.prepare.mission}>
          <b>{texts.prepare.mission}</b>
          {mission.map((check) => (
            <label key={check.name}>
              <Cell check={check} isChosen={keyOf(check) === chosen} isStop onChoose={onChoose} />
              {nameOf(check.name)}
            </label>
          ))}
        </div>
      )}
      <table class={`matrix ${isTurned ? "is-turned" : names.length > UPRIGHT_NAMES ? "is-wide" : ""}`}>
        <thead>
          <tr>
            <th scope="col">
              <span>{texts.prepare.vehicle}</span>
            </th>
            {columns.map((column) => (
              <th key={column} scope="col">
                <span>{column}</span>
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {lines.map((checks, line) => (
            <tr key={heads[line]}>
              <th scope="row">{heads[line]}</th>
              {checks.map((check, column) => (
                <td key={columns[column]}>
                  {check && (
                    <Cell
                      check={check}
                      isChosen={keyOf(check) === chosen}
                      isStop={check === stop}
                      onChoose={onChoose}
                    />
                  )}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

interface CellProps {
  check: PreflightCheck;
  isChosen: boolean;
  /** Whether the Tab key stops at it. */
  isStop: boolean;
  onChoose(key: string): void;
}

function Cell({ check, isChosen, isStop, onChoose }: CellProps) {
  const status = cellStatusOf(check);
  const word = status === "overridden" ? texts.prepare.overridden : texts.prepare.status[status];
  const choose = (): void => onChoose(keyOf(check));
  return (
    <button
      type="button"
      class={`cell is-${status}`}
      data-testid={`check-${check.vehicle_id}-${check.name}`}
      data-status={status}
      aria-pressed={isChosen}
      tabIndex={isStop ? 0 : -1}
      aria-label={texts.prepare.cell(nameOf(check.name), subjectOf(check.vehicle_id), word)}
      title={said(check.text)}
      onFocus={choose}
      onClick={choose}
    >
      {SIGNS[status]}
    </button>
  );
}

function moveFocus(event: KeyboardEvent): void {
  const step = STEPS[event.key];
  const cell = event.target instanceof HTMLElement ? event.target.closest("td") : null;
  const row = cell?.closest("tr");
  if (step === undefined || !cell || !row) return;
  const table = row.closest("tbody");
  const next = table?.rows[row.sectionRowIndex + step[0]]?.cells[cell.cellIndex + step[1]];
  const button = next?.querySelector("button");
  if (!button) return;
  event.preventDefault();
  button.focus();
}
