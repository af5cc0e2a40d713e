/** A connection to a fake server, fresh for each test. */
import { cleanup } from "@testing-library/preact";
import { afterEach, beforeEach, vi } from "vitest";
import { connection } from "../src/connection";
import { disable, endReason, forgetChoices, speedScale } from "../src/driving";
import { frames } from "../src/frames";
import { language } from "../src/i18n";
import { moving } from "../src/moving";
import { dismiss, toasts } from "../src/notices";
import { chosenRobot } from "../src/robots";
import * as store from "../src/store";
import { FakeSocket } from "./fixtures";

export function useFakeServer(): void {
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("WebSocket", FakeSocket);
    vi.stubGlobal("fetch", () => Promise.reject(new Error("nobody there")));
    FakeSocket.all = [];
    language.value = "en";
    store.connectionState.value = "connecting";
    store.view.value = null;
    store.status.value = null;
    store.notices.value = [];
    store.scene.value = null;
    moving.value = null;
    frames.clear();
    disable();
    forgetChoices();
    chosenRobot.value = null;
    endReason.value = null;
    speedScale.value = 0.5;
    for (const toast of toasts.value) dismiss(toast.key);
    connection.open();
  });
  afterEach(() => {
    cleanup();
    connection.close();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });
}
