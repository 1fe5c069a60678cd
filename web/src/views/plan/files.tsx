/** Plans stored by the station: save, load, delete. */
import { useEffect, useState } from "preact/hooks";
import { deletePlan, listPlans, readSavedPlan, savePlan } from "../../api/plans";
import type { Plan, SavedPlan } from "../../api/types";
import { texts } from "../../texts";
import { HoldButton } from "../../ui/hold_button";

interface Props {
  plan: Plan;
  onLoad(plan: Plan): void;
}

export function SavedPlans({ plan, onLoad }: Props) {
  const [saved, setSaved] = useState<readonly SavedPlan[]>([]);
  const [name, setName] = useState("");
  const [answer, setAnswer] = useState<{ isDone: boolean; text: string } | null>(null);
  const list = async (): Promise<void> => {
    const listed = await listPlans();
    if (listed.ok) setSaved(listed.value);
  };
  useEffect(() => void list(), []);
  const report = (result: { ok: true } | { ok: false; message: string }, done: string): void => {
    setAnswer(result.ok ? { isDone: true, text: done } : { isDone: false, text: result.message });
    void list();
  };
  const wanted = name.trim();
  const replaced = saved.find((entry) => entry.name === wanted.normalize("NFC"));
  const save = async (): Promise<void> =>
    report(await savePlan(wanted, plan, replaced?.version ?? null), texts.plan.saved(wanted));
  const load = async (chosen: string): Promise<void> => {
    const read = await readSavedPlan(chosen);
    if (read.ok) {
      setName(chosen);
      onLoad(read.value);
    }
    report(read, texts.plan.loaded(chosen));
  };
  const remove = async (chosen: string): Promise<void> => report(await deletePlan(chosen), texts.plan.deleted(chosen));
  return (
    <>
      <div class="button-row">
        <input
          type="text"
          aria-label={texts.plan.name}
          placeholder={texts.plan.name}
          maxLength={64}
          data-testid="plan-name"
          value={name}
          onInput={(event) => setName(event.currentTarget.value)}
        />
        {replaced ? (
          <HoldButton label={texts.plan.replace} testId="plan-replace" onConfirm={() => void save()} />
        ) : (
          <button type="button" data-testid="plan-save" disabled={wanted === ""} onClick={() => void save()}>
            {texts.plan.save}
          </button>
        )}
      </div>
      <p class={answer?.isDone ? "is-done" : "is-bad"} role="status" data-testid="plan-files-answer">
        {answer?.text}
      </p>
      <ul class="saved-plans">
        {saved.map((entry) => (
          <li key={entry.name} data-testid={`saved-${entry.name}`}>
            <span>
              {entry.name} <span class="small">{new Date(1000 * entry.saved_utc_s).toLocaleString()}</span>
            </span>
            <button type="button" aria-label={texts.plan.loadNamed(entry.name)} onClick={() => void load(entry.name)}>
              {texts.plan.load}
            </button>
            <HoldButton
              label={texts.plan.delete}
              testId={`delete-${entry.name}`}
              onConfirm={() => void remove(entry.name)}
            />
          </li>
        ))}
      </ul>
    </>
  );
}
