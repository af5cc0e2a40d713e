import { describe, expect, it, vi } from "vitest";
import { connection, STREAM_INTERVAL_MS } from "../src/connection";
import { need } from "../src/forces";
import { frames } from "../src/frames";
import { PROTOCOL } from "../src/messages";
import { toasts } from "../src/notices";
import * as store from "../src/store";
import { FakeSocket, frame, view, status } from "./fixtures";
import { useFakeServer } from "./setup";

const setpoint = (pan: number) => ({
  controller: "arm",
  positions: { pan },
  speed: 0.5,
});
const steer = (pan: number) => ({ method: "steer_joints", params: setpoint(pan) });

function greet(protocol: number): FakeSocket {
  const socket = FakeSocket.newest;
  const [name, version, mode] = ["tool0", "0.0.0", "simulation"] as const;
  socket.say({ type: "hello", protocol, version, name, pid: 1, mode });
  return socket;
}

function connect(): FakeSocket {
  FakeSocket.newest.say(view());
  return FakeSocket.newest;
}

describe("the connection", () => {
  useFakeServer();

  it("carries the token of the page's address", () => {
    window.history.replaceState({}, "", "/?token=s%26cret");
    connection.open();
    const url = new URL(FakeSocket.newest.url);
    window.history.replaceState({}, "", "/");
    expect([url.pathname, url.searchParams.get("token")]).toEqual(["/ws", "s&cret"]);
  });

  it("subscribes to the view, and is open when that comes", () => {
    const socket = greet(PROTOCOL);
    expect(socket.sent.map(({ method }) => method)).toEqual(["subscribe_view"]);
    expect(store.connectionState.value).toBe("connecting");
    socket.say(view());
    expect(store.connectionState.value).toBe("open");
  });

  it("asks for forces while something needs them, also after it reconnects", () => {
    const socket = greet(PROTOCOL);
    const [one, other] = [need({ contacts: true }), need({ contacts: true })];
    one();
    one();
    const third = need({ wrenches: true });
    FakeSocket.newest.end();
    connection.open();
    const next = greet(PROTOCOL);
    other();
    third();
    const none = { contacts: false, wrenches: false };
    const both = { contacts: true, wrenches: true };
    expect(socket.sentOf("subscribe_view")).toEqual([
      none,
      { contacts: true, wrenches: false },
      both,
    ]);
    expect(next.sentOf("subscribe_view")).toEqual([
      both,
      { contacts: false, wrenches: true },
      none,
    ]);
  });

  it("fills the store", () => {
    const socket = connect();
    socket.say({ type: "scene", number: 4, objects: [] });
    socket.say(status());
    socket.say(frame());
    expect(store.connectionState.value).toBe("open");
    expect(store.scene.value?.number).toBe(4);
    expect(store.status.value?.controllers[0]?.name).toBe("arm");
    expect(frames.latest?.time).toBe(1);
  });

  it("drops a frame of another robot", () => {
    connect().say(frame({ position: [1, 2, 3] }));
    expect(frames.latest).toBeUndefined();
  });

  it("gives each request its own answer, whatever their order", async () => {
    const socket = connect();
    const [first, second] = [connection.request("pause"), connection.request("reset")];
    const [one, two] = socket.sent.map(({ id }) => id ?? -1);
    const error = { type: "ControlError", message: "not now" };
    socket.say({ type: "reply", id: two ?? null, error });
    socket.say({ type: "reply", id: one ?? null });
    expect(await first).toBeNull();
    expect(await second).toEqual(error);
  });

  it("answers what was asked of a server that went away, and asks nothing of none", async () => {
    const socket = connect();
    const asked = connection.request("pause");
    socket.end();
    expect((await asked)?.type).toBe("ConnectionLost");
    expect((await connection.request("pause"))?.type).toBe("ConnectionLost");
  });

  it("gives up waiting for a server that does not answer", async () => {
    connect();
    const asked = connection.request("pause");
    vi.advanceTimersByTime(20_000);
    expect((await asked)?.type).toBe("NoAnswer");
  });

  it("sends of a thousand slider events the first at once and the newest next", () => {
    const socket = connect();
    for (let event = 0; event < 1000; event++)
      connection.stream("steer_joints", setpoint(event));
    expect(socket.sent).toEqual([steer(0)]);
    vi.advanceTimersByTime(STREAM_INTERVAL_MS);
    expect(socket.sent).toEqual([steer(0), steer(999)]);
    vi.advanceTimersByTime(1000);
    expect(socket.sent).toHaveLength(2);
  });

  it("waits with streams while the network is behind, and then sends the newest", () => {
    const socket = connect();
    socket.bufferedAmount = 1_000_000;
    connection.stream("steer_joints", setpoint(1));
    connection.stream("steer_joints", setpoint(2));
    vi.advanceTimersByTime(500);
    expect(socket.sent).toEqual([]);
    socket.bufferedAmount = 0;
    vi.advanceTimersByTime(STREAM_INTERVAL_MS);
    expect(socket.sent).toEqual([steer(2)]);
  });

  it("queues nothing while it is lost", () => {
    const socket = connect();
    connection.stream("steer_joints", setpoint(1));
    connection.stream("steer_joints", setpoint(2));
    socket.end();
    connection.stream("steer_joints", setpoint(3));
    vi.advanceTimersByTime(250);
    const again = connect();
    vi.advanceTimersByTime(5000);
    expect(again).not.toBe(socket);
    expect(again.sent).toEqual([]);
  });

  it("comes back, ever more slowly, and begins anew with the next view", () => {
    connect().say(status());
    const waits: number[] = [];
    for (let attempt = 0; attempt < 6; attempt++) {
      const before = FakeSocket.all.length;
      FakeSocket.newest.end();
      expect(store.connectionState.value).toBe("lost");
      let waited = 0;
      while (FakeSocket.all.length === before && waited < 10_000) {
        vi.advanceTimersByTime(50);
        waited += 50;
      }
      waits.push(waited);
    }
    expect(waits).toEqual([250, 500, 1000, 2000, 2000, 2000]);
    const other = view();
    FakeSocket.newest.say({ ...other, robot: { ...other.robot, name: "another" } });
    expect(store.connectionState.value).toBe("open");
    expect(store.view.value?.robot.name).toBe("another");
    expect(store.status.value).toBeNull();
  });

  it("says what it does not understand, once, and goes on", () => {
    const socket = connect();
    for (const text of ["{", "[]", "null", '{"type":"?"}', '{"type":"state"}', 7]) {
      socket.sayText(text);
    }
    expect(toasts.value.map((toast) => [toast.severity, toast.count])).toEqual([
      ["error", 6],
    ]);
    socket.say(status());
    expect(store.status.value).not.toBeNull();
  });

  it.each([1008, 4401, 4403])("stops asking after a refusal, %i", (code) => {
    FakeSocket.newest.end(code);
    vi.advanceTimersByTime(60_000);
    expect(store.connectionState.value).toBe("refused");
    expect(FakeSocket.all).toHaveLength(1);
  });

  it.each([401, 403])(
    "learns by a page's status %i that it is refused",
    async (code) => {
      vi.stubGlobal("fetch", () => Promise.resolve(new Response("", { status: code })));
      FakeSocket.newest.end(1006);
      await vi.advanceTimersByTimeAsync(60_000);
      expect(store.connectionState.value).toBe("refused");
      expect(FakeSocket.all).toHaveLength(1);
    },
  );

  it("asks to be reloaded for a server of another protocol", () => {
    greet(PROTOCOL + 1).say(status());
    expect(store.connectionState.value).toBe("outdated");
    expect(store.status.value).toBeNull();
    FakeSocket.newest.end();
    expect(store.connectionState.value).toBe("outdated");
  });
});
