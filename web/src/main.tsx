import "maplibre-gl/dist/maplibre-gl.css";
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
import { Store } from "./state/store";
import { chooseLanguage, storedLanguage } from "./texts";

const KEEP_PAGE_AFTER_MS = 3000;

const root = document.getElementById("app");
if (root === null) throw new Error("index.html has no element 'app'");

// Without the file of its language the page speaks English: what matters is that it is there.
await chooseLanguage(storedLanguage()).catch((error: unknown) => console.warn("The language cannot be loaded.", error));
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
// Once the page is there: what it needs itself comes first.
if (import.meta.env.PROD) setTimeout(() => void keepPage(), KEEP_PAGE_AFTER_MS);
render(<App store={store} stream={stream} />, root);
