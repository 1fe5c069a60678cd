import "./styles/theme.css";
import "./styles/ui.css";
import "./styles/shell.css";
import "./styles/alerts.css";
import "./styles/map.css";
import "./styles/panels.css";
import "./styles/forced_colors.css";
import { render } from "preact";
import { EventSocket } from "./api/socket";
import { keepPage, lastState, showLastState } from "./offline/page";
import { App } from "./shell/app";
import { parseRoute } from "./shell/route";
import { loadAllViews, VIEWS } from "./shell/views";
import { Store } from "./state/store";
import { chooseLanguage, storedLanguage } from "./texts";
import { Part } from "./ui/part";

/** Time that the page has for what it needs itself, before it loads what it may need later. */
const REST_AFTER_MS = 3000;

/** Without the file of its language the page speaks English: what matters is that it is there. */
const language = new Part(() =>
  chooseLanguage(storedLanguage()).catch((error: unknown) => {
    console.warn("The language cannot be loaded.", error);
    return chooseLanguage("en");
  }),
);

async function open(root: HTMLElement): Promise<void> {
  await Promise.all([language.load(), VIEWS[parseRoute(location.hash).view].load()]);
  const store = new Store();
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  const stream = new EventSocket(`${scheme}://${location.host}/api/events`, {
    onMessage: (message) => store.receive(message),
    onConnection: (connection) => {
      store.setConnection(connection);
      if (connection === "lost") void showLastState(store);
    },
  });
  store.subscribe((state) => void lastState.follow(state));
  render(<App store={store} stream={stream} />, root);
  setTimeout(() => {
    void loadAllViews();
    if (import.meta.env.PROD) void keepPage();
  }, REST_AFTER_MS);
}

const root = document.getElementById("app");
if (root === null) throw new Error("index.html has no element 'app'");
// No await of the module itself: the files of views import this one, and would wait for it in turn.
void open(root);
