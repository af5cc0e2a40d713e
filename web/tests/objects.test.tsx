import { act, fireEvent, render, screen } from "@testing-library/preact";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { fromQuaternion, toRpy } from "../src/kinematics";
import { moving } from "../src/moving";
import { describeObject, grouped, ObjectsPanel } from "../src/panels/objects";
import { TopBar } from "../src/panels/top-bar";
import type { ViewObject } from "../src/protocol";
import { FakeSocket, frame, view } from "./fixtures";
import { useFakeServer } from "./setup";

const CUBE: ViewObject = {
  name: "cube",
  shape: { kind: "box", size: [0.04, 0.04, 0.04] },
  rgba: [1, 0, 0, 1],
  mass: 0.1,
  friction: 0.7,
};
const TABLE: ViewObject = {
  name: "table",
  shape: { kind: "box", size: [0.5, 1, 0.08] },
  rgba: [1, 1, 1, 1],
  mass: null,
  friction: 1,
};
const QUARTER = Math.SQRT1_2;

const server = () => FakeSocket.newest;
const press = (id: string) => fireEvent.click(screen.getByTestId(id));

/** Let what was clicked be rendered. */
const settle = () =>
  act(async () => {
    await vi.advanceTimersByTimeAsync(50);
  });

/** Let the server carry out the last request of a method. */
async function answered(method: string): Promise<void> {
  await settle();
  await act(async () => {
    server().accept(method);
    await vi.advanceTimersByTimeAsync(50);
  });
}

function type(id: string, text: string): void {
  const field = screen.getByTestId(id);
  fireEvent.input(field, { target: { value: text } });
  fireEvent.keyDown(field, { key: "Enter" });
}

async function refuse(method: string, message: string): Promise<void> {
  await act(async () => {
    server().refuse(method, message);
    await vi.advanceTimersByTimeAsync(50);
  });
}

describe("the objects", () => {
  useFakeServer();
  beforeEach(async () => {
    server().say(view());
    render(<ObjectsPanel />);
    await act(async () => {
      server().say({ type: "scene", number: 3, objects: [TABLE, CUBE] });
      server().say(
        frame({
          scene_number: 3,
          objects: [
            [
              [0.5, 0, 0],
              [1, 0, 0, 0],
            ],
            [
              [0.5, -0.1, 0.25],
              [QUARTER, 0, 0, QUARTER],
            ],
          ],
        }),
      );
      await vi.advanceTimersByTimeAsync(100);
    });
  });

  it("are told with what they are and where", () => {
    expect(screen.getByTestId("object-row-table").textContent).toContain(
      "Box 500 × 1000 × 80 mm, fixed",
    );
    const pose = screen.getByTestId("object-pose-cube").textContent;
    expect(pose).toMatch(/500\.0 {2}-100\.0 {2}250\.0 mm +0\.000 {2}0\.000 {2}1\.571/);
  });

  it("are put where numbers say, from where they are", async () => {
    press("object-move-cube");
    await settle();
    type("object-target-position-2", "300");
    await settle();
    press("object-put-cube");
    const [sent] = server().sentOf("place_object");
    expect(sent).toMatchObject({ name: "cube", xyz: [0.5, -0.1, 0.3] });
    expect((sent?.["rpy"] as number[])[2]).toBeCloseTo(Math.PI / 2);
    await refuse("place_object", "it cannot be there");
    expect(screen.getByTestId("object-refusal-cube").textContent).toBe(
      "it cannot be there",
    );
  });

  it("are removed at once, and come back by undo as they were", async () => {
    press("object-remove-cube");
    await answered("remove_object");
    expect(server().sentOf("remove_object")).toMatchObject([{ name: "cube" }]);
    press("objects-undo");
    await answered("add_object");
    const [back] = server().sentOf("add_object");
    const { shape, rgba, friction, mass } = CUBE;
    expect(back).toMatchObject({ name: "cube", shape, rgba, friction, mass });
    expect(back).toMatchObject({ xyz: [0.5, -0.1, 0.25] });
    press("objects-redo");
    await answered("remove_object");
    expect(server().sentOf("remove_object")).toHaveLength(2);
  });

  it("come back by an undo that was quicker than the answer", async () => {
    press("object-remove-cube");
    await settle();
    press("objects-undo");
    await settle();
    expect(server().sentOf("add_object")).toEqual([]);
    await answered("remove_object");
    expect(server().sentOf("add_object")).toMatchObject([{ name: "cube" }]);
  });

  it("return to where they were by undo", async () => {
    press("object-move-cube");
    await settle();
    type("object-target-position-2", "300");
    await settle();
    press("object-put-cube");
    await answered("place_object");
    press("objects-undo");
    await answered("place_object");
    const [, back] = server().sentOf("place_object");
    expect(back).toMatchObject({ name: "cube", xyz: [0.5, -0.1, 0.25] });
  });

  it("are no edit to undo if the server refused it", async () => {
    press("object-remove-cube");
    await settle();
    await refuse("remove_object", "not now");
    expect(screen.getByTestId("objects-undo").hasAttribute("disabled")).toBe(true);
  });

  it("are removed with all parts of what they are parts of", async () => {
    await act(() => {
      const parts = ["bin.floor", "bin.left"].map((name) => ({ ...TABLE, name }));
      server().say({ type: "scene", number: 4, objects: [...parts, CUBE] });
    });
    press("object-remove-bin");
    await settle();
    expect(server().sentOf("remove_object")).toMatchObject([
      { name: "bin.floor" },
      { name: "bin.left" },
    ]);
  });

  it("are moved one at a time, and no more once they are gone", async () => {
    press("object-move-cube");
    press("object-move-table");
    await settle();
    expect(moving.value?.name).toBe("table");
    await act(() => {
      server().say({ type: "scene", number: 4, objects: [CUBE] });
    });
    expect(moving.value).toBeNull();
  });

  it("are added as the fields say, under a free name", async () => {
    type("object-size-0", "50");
    await settle();
    press("object-add");
    await answered("add_object");
    press("object-kind-cylinder");
    await settle();
    type("object-radius", "25");
    press("object-movable");
    fireEvent.input(screen.getByTestId("object-name"), { target: { value: "can" } });
    await settle();
    press("object-add");
    expect(server().sentOf("add_object")).toMatchObject([
      {
        name: "box",
        shape: { kind: "box", size: [0.05, 0.04, 0.04] },
        xyz: [0.5, 0, 0.1],
        mass: 0.1,
        friction: 1,
      },
      {
        name: "can",
        shape: { kind: "cylinder", radius: 0.025, length: 0.1 },
        mass: null,
      },
    ]);
    await refuse("add_object", "the name is taken");
    expect(screen.getByTestId("object-add-refusal").textContent).toBe(
      "the name is taken",
    );
  });
});

describe("an object in words", () => {
  it("is told with its other parts, in the order in which they came", () => {
    const still = (name: string) => ({ ...TABLE, name });
    const objects = [still("bin.floor"), CUBE, still("bin.left"), still("a.b")];
    const movable = { ...CUBE, name: "bin.lid" };
    const found = grouped([...objects, movable]).map(([whole, parts]) => [
      whole,
      ...parts.map(({ name }) => name),
    ]);
    expect(found).toEqual([
      ["bin", "bin.floor", "bin.left"],
      [null, "cube"],
      [null, "a.b"],
      [null, "bin.lid"],
    ]);
  });

  it("has its measures in millimetres", () => {
    const shapes: [ViewObject["shape"], string][] = [
      [{ kind: "cylinder", radius: 0.03, length: 0.1 }, "Cylinder ⌀ 60 × 100 mm, 1 kg"],
      [{ kind: "sphere", radius: 0.0125 }, "Sphere ⌀ 25 mm, 1 kg"],
      [{ kind: "mesh", size: [1, 1, 1], url: "/a.stl" }, "Mesh, 1 kg"],
      [{ kind: "compound", parts: [] }, "Several shapes, 1 kg"],
    ];
    for (const [shape, words] of shapes) {
      expect(describeObject({ ...CUBE, shape, mass: 1 })).toBe(words);
    }
  });

  it("has the angles of its quaternion", () => {
    const [half, pitch] = [0.3, 0.6];
    const rpy = toRpy(fromQuaternion([Math.cos(half), 0, Math.sin(half), 0]));
    expect(rpy[1]).toBeCloseTo(pitch);
  });
});

describe("the grasp assist", () => {
  useFakeServer();

  it("is told for what it is while it is on", async () => {
    render(<TopBar />);
    await act(() => {
      server().say(view());
    });
    expect(screen.queryByTestId("grasp-assist")).toBeNull();
    await act(() => {
      server().say(view({ grasp_assist: true }));
    });
    expect(screen.getByTestId("grasp-assist").textContent).toBe(
      "Grasp assist (not physical)",
    );
  });
});
