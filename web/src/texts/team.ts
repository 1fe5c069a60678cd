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
  join: "Create account",
  joinHint: "Enter your name, as it will appear in the log, and a password.",
  newPassword: "Password, 10 characters or more",
  joinSubmit: "Create account",
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
  link: "Link for one person, for 24 hours. Send it through a private channel.",
  onlyHere: "This link works on this computer only. For others, open this page by its address in the network first.",
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
  asked: "Request sent. Wait for the answer, or take over control.",
  take: "Take control",
  takeOver: "Take over control",
  reason: "Reason, for the audit log",
  give: (name: string) => `Give control to ${name}`,
  refuse: "Refuse",
  release: "Release control",
  close: "Close",
} as const;
