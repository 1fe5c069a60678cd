/** Texts about the people at a command post. */

export const roles = {
  visitor: "Not signed in",
  observer: "Observer",
  analyst: "Analyst",
  operator: "Operator",
  administrator: "Administrator",
} as const;

export const roleHints = {
  observer: "Sees everything",
  analyst: "Marks and judges findings",
  operator: "Flies",
  administrator: "Flies, and manages accounts",
} as const;

export const account = {
  title: "Sign in",
  name: "Name",
  password: "Password",
  signedInAs: (name: string, role: string) => `${name}, ${role}`,
  join: "Make your account",
  joinHint: "You were invited. Choose your name as it shall stand in the log, and a password.",
  newPassword: "Password, 10 characters or more",
  joinSubmit: "Make the account",
} as const;

export const accounts = {
  title: "Accounts",
  name: "Name",
  role: "Role",
  devices: "Devices",
  remove: "Remove",
  removeNow: (name: string) => `Remove ${name} now`,
  invite: "Invite",
  inviteRole: "Role of the new account",
  link: "Link for one person, for 24 hours. Send it by a way that others do not read.",
  signIns: "Latest sign-ins",
  loading: "Loading accounts …",
} as const;

export const control = {
  title: "Control",
  mine: "You have control",
  others: (name: string) => `${name} has control`,
  gone: (name: string) => `${name} had control and is not connected`,
  free: "Nobody has control",
  asks: (name: string) => `${name} asks for control`,
  hint: "One operator commands. Hold is possible for every operator at any time.",
  ask: "Ask for control",
  asked: "Asked. Wait for the answer, or take control over.",
  take: "Take control",
  takeOver: "Take control over",
  reason: "Reason, for the audit log",
  give: (name: string) => `Give control to ${name}`,
  refuse: "Refuse",
  release: "Give control up",
  close: "Close",
} as const;
