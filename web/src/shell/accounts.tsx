/** Accounts of the command post, for administrators: roles, invitations and the latest sign-ins. */
import { useEffect, useState } from "preact/hooks";
import { changeRole, invite, readAccounts, readSignIns, removeAccount } from "../api/accounts";
import type { Answer } from "../api/client";
import type { Account, SignInEntry } from "../api/types";
import { timeOfDay } from "../format";
import { GIVEN_ROLES, type GivenRole } from "../state/roles";
import "./accounts.css";
import { isOwnHost } from "./own_host";
import { texts } from "../texts";

const SIGN_INS_SHOWN = 12;

export function Accounts() {
  const [list, setList] = useState<readonly Account[] | null>(null);
  const [entries, setEntries] = useState<readonly SignInEntry[]>([]);
  const [refusal, setRefusal] = useState<string | null>(null);
  const { accounts } = texts.team;
  const take = (answer: Answer<Account[]>): void => {
    if (answer.ok) setList(answer.value);
    setRefusal(answer.ok ? null : answer.message);
    void readSignIns().then((found) => found.ok && setEntries(found.value.slice(0, SIGN_INS_SHOWN)));
  };
  useEffect(() => void readAccounts().then(take), []);
  return (
    <section data-testid="accounts" aria-label={accounts.title}>
      <h3>{accounts.title}</h3>
      {list === null ? (
        <p>{accounts.loading}</p>
      ) : (
        <table class="accounts">
          <thead>
            <tr>
              <th scope="col">{accounts.name}</th>
              <th scope="col">{accounts.role}</th>
              <th scope="col">{accounts.devices}</th>
              <td />
            </tr>
          </thead>
          <tbody>
            {list.map((account) => (
              <Row key={account.name} account={account} onAnswer={take} />
            ))}
          </tbody>
        </table>
      )}
      <p class="is-bad" role="alert" data-testid="accounts-refusal">
        {refusal}
      </p>
      <Invite />
      <h4>{accounts.signIns}</h4>
      <ul class="sign-ins" data-testid="sign-ins">
        {entries.map((entry) => (
          <li key={`${entry.utc_s} ${entry.name}`}>
            {timeOfDay(entry.utc_s)} {entry.name}: {entry.kind}
            {entry.detail && ` (${entry.detail})`}, {entry.address}
          </li>
        ))}
      </ul>
    </section>
  );
}

function Row({ account, onAnswer }: { account: Account; onAnswer(answer: Answer<Account[]>): void }) {
  const [isSure, setSure] = useState(false);
  const { accounts } = texts.team;
  const { name, role, sessions } = account;
  return (
    <tr data-testid={`account-${name}`}>
      <th scope="row">{name}</th>
      <td>
        <RoleChoice
          label={`${accounts.role}: ${name}`}
          value={role as GivenRole}
          onChange={(chosen) => void changeRole(name, chosen).then(onAnswer)}
        />
      </td>
      <td>{sessions}</td>
      <td>
        <button
          type="button"
          onClick={() => (isSure ? void removeAccount(name).then(onAnswer) : setSure(true))}
          onBlur={() => setSure(false)}
        >
          {isSure ? accounts.removeNow(name) : accounts.remove}
        </button>
      </td>
    </tr>
  );
}

function Invite() {
  const [role, setRole] = useState<GivenRole>("observer");
  const [link, setLink] = useState<string | null>(null);
  const [refusal, setRefusal] = useState<string | null>(null);
  const { accounts, roleHints } = texts.team;
  const make = async (): Promise<void> => {
    const answer = await invite(role);
    setLink(answer.ok ? `${location.origin}/#invite=${answer.value.token}` : null);
    setRefusal(answer.ok ? null : answer.message);
  };
  return (
    <>
      <p class="invite">
        <RoleChoice label={accounts.inviteRole} value={role} onChange={setRole} /> {roleHints[role]}{" "}
        <button type="button" data-testid="invite" onClick={() => void make()}>
          {accounts.invite}
        </button>
      </p>
      {link !== null && isOwnHost(location.hostname) && (
        <p class="is-bad" data-testid="invite-only-here">
          {accounts.onlyHere}
        </p>
      )}
      {link !== null && (
        <label>
          {accounts.link}
          <input data-testid="invite-link" readOnly value={link} onFocus={(event) => event.currentTarget.select()} />
        </label>
      )}
      <p class="is-bad" role="alert">
        {refusal}
      </p>
    </>
  );
}

interface ChoiceProps {
  label: string;
  value: GivenRole;
  onChange(role: GivenRole): void;
}

function RoleChoice({ label, value, onChange }: ChoiceProps) {
  return (
    <select aria-label={label} value={value} onChange={(event) => onChange(event.currentTarget.value as GivenRole)}>
      {GIVEN_ROLES.map((role) => (
        <option key={role} value={role}>
          {texts.team.roles[role]}
        </option>
      ))}
    </select>
  );
}
