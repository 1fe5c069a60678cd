import { expect, test } from "vitest";
import { isOwnHost } from "../src/shell/own_host";

test.each(["localhost", "station.localhost", "127.0.0.1", "127.1.2.3", "[::1]"])("%s is this computer", (hostname) => {
  expect(isOwnHost(hostname)).toBe(true);
});

test.each(["10.0.0.5", "station.local", "localhost.example.org", "[fe80::1]"])("%s is found by others", (hostname) => {
  expect(isOwnHost(hostname)).toBe(false);
});
