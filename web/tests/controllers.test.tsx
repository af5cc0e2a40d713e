import { act, fireEvent, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { conflicting } from "../src/conflicts";
import { disable, enable } from "../src/driving";
import { ControllersPanel } from "../src/panels/controllers";
import { controller, FakeSocket, view, status } from "./fixtures";
import { useFakeServer } from "./setup";

const arm = controller({ name: "arm" });
const efforts = controller({ name: "efforts", state: "stopped", joints: ["lift"] });
const reader = controller({ name: "reader", interface: null, joints: [] });

describe("conflicts of controllers", () => {
  it("are running ones that claim a joint of the one to start", () => {
    expect(conflicting(efforts, [arm, efforts, reader])).toEqual(["arm"]);
  });

  it("are none for readers, for stopped ones and for other joints", () => {
    const other = controller({ name: "hand", joints: ["finger"] });
    const stopped = controller({ name: "spare", state: "stopped" });
    expect(conflicting(efforts, [efforts, reader, other, stopped])).toEqual([]);
    expect(conflicting(reader, [arm])).toEqual([]);
  });
});

describe("the table of controllers", () => {
  useFakeServer();
  beforeEach(() => {
    FakeSocket.newest.say(view());
    FakeSocket.newest.say(status({ controllers: [arm, efforts] }));
    enable();
    render(<ControllersPanel />);
  });

  it("starts nothing while the page is read-only", async () => {
    await act(() => {
      disable();
    });
    const start = screen.getByTestId<HTMLButtonElement>("controller-start-efforts");
    expect(start.disabled).toBe(true);
    expect(screen.getByTestId<HTMLButtonElement>("controller-stop-arm").disabled).toBe(
      false,
    );
  });

  it("shows why the server refused, and offers to switch at once", async () => {
    const socket = FakeSocket.newest;
    fireEvent.click(screen.getByTestId("controller-start-efforts"));
    expect(socket.sentOf("switch_controllers")).toEqual([{ start: ["efforts"] }]);
    await act(async () => {
      socket.refuse("switch_controllers", "arm claims lift");
      await vi.advanceTimersByTimeAsync(50);
    });
    expect(screen.getByTestId("controller-refusal-efforts").textContent).toBe(
      "arm claims lift",
    );
    fireEvent.click(screen.getByTestId("controller-switch-efforts"));
    expect(socket.sentOf("switch_controllers")[1]).toMatchObject({
      start: ["efforts"],
      stop: ["arm"],
    });
  });

  it("offers what fits the state", () => {
    expect(screen.getByTestId("controller-stop-arm")).toBeDefined();
    expect(screen.queryByTestId("controller-start-arm")).toBeNull();
    expect(screen.getByTestId("controller-unload-efforts")).toBeDefined();
  });
});
