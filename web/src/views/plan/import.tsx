/** Import of shapes from a picked or dropped file, each with its role in the plan. */
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { importFile } from "../../api/plans";
import type { ImportedShape, Plan } from "../../api/types";
import { texts } from "../../texts";
import { Dialog } from "../../ui/dialog";
import { type ImportRole, proposedRoles, rolesFor, withImported } from "./shapes";

const SUFFIXES = ".geojson,.json,.kml,.plan";

export interface Import {
  /** Shapes of the file, whose roles the operator has to confirm. */
  readonly shapes: readonly ImportedShape[] | null;
  readonly refusal: string | null;
  read(file: File | undefined): void;
  forget(): void;
}

export function useImport(): Import {
  const [shapes, setShapes] = useState<readonly ImportedShape[] | null>(null);
  const [refusal, setRefusal] = useState<string | null>(null);
  const read = async (file: File): Promise<void> => {
    const answer = await importFile(file);
    setShapes(answer.ok ? answer.value : null);
    setRefusal(answer.ok ? null : `${file.name}: ${answer.message}`);
  };
  return { shapes, refusal, read: (file) => file && void read(file), forget: () => setShapes(null) };
}

export function ImportPicker({ files: { read, refusal } }: { files: Import }) {
  return (
    <>
      <label class="file-picker">
        {texts.plan.import}
        <input
          type="file"
          accept={SUFFIXES}
          data-testid="plan-import"
          onChange={({ currentTarget }) => {
            read(currentTarget.files?.[0]);
            currentTarget.value = ""; // lets the operator pick the same file again
          }}
        />
      </label>
      <p class="is-bad field-problem" role="alert" data-testid="import-refusal">
        {refusal}
      </p>
    </>
  );
}

/** Accepts files that are dropped on its content. */
export function DropZone({
  onFile,
  children,
}: {
  onFile: (file: File | undefined) => void;
  children: ComponentChildren;
}) {
  return (
    <div
      class="drop-zone"
      onDragOver={(event) => event.preventDefault()}
      onDrop={(event) => {
        event.preventDefault();
        onFile(event.dataTransfer?.files[0]);
      }}
    >
      {children}
    </div>
  );
}

interface DialogProps {
  plan: Plan;
  shapes: readonly ImportedShape[];
  onTake(plan: Plan): void;
  onClose(): void;
}

export function ImportDialog({ plan, shapes, onTake, onClose }: DialogProps) {
  const [roles, setRoles] = useState<readonly ImportRole[]>(() => proposedRoles(shapes));
  return (
    <Dialog title={texts.plan.importTitle} testId="import-dialog" onClose={onClose}>
      <ul class="import-list">
        {shapes.map((shape, index) => (
          <li key={index}>
            <label>
              <span>
                {shape.name || texts.plan.unnamed}{" "}
                <span class="small">{shape.places.length > 1 && texts.plan.corners(shape.places.length)}</span>
              </span>
              <select
                data-testid={`import-role-${index}`}
                value={roles[index] ?? "skip"}
                onChange={({ currentTarget: { value } }) => {
                  const role = rolesFor(shape).find((one) => one === value) ?? "skip";
                  setRoles(roles.map((before, i) => (i === index ? role : before)));
                }}
              >
                {rolesFor(shape).map((role) => (
                  <option key={role} value={role}>
                    {texts.plan.role[role]}
                  </option>
                ))}
              </select>
            </label>
          </li>
        ))}
      </ul>
      <div class="dialog-buttons">
        <button type="button" onClick={onClose}>
          {texts.actions.cancel}
        </button>
        <button
          type="button"
          class="primary"
          data-testid="import-ok"
          onClick={() => {
            onTake(withImported(plan, shapes, roles));
            onClose();
          }}
        >
          {texts.plan.takeShapes}
        </button>
      </div>
    </Dialog>
  );
}
