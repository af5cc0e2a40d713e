import { Euler, Object3D, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import {
  aboutAxis,
  apply,
  compose,
  fromQuaternion,
  fromRotationVector,
  fromRpy,
  IDENTITY,
  inverse,
  linkPose,
  type Pose,
  product,
  type Rotation,
  toQuaternion,
  toRotationVector,
  toRpy,
  transposed,
} from "../src/kinematics";
import { quaternionOf, rotationOf } from "../src/scene/orientation";
import { parseUrdf, type UrdfJoint, type Vector } from "../src/urdf";
import { UR5 } from "./ur5";

const RPY: readonly Vector[] = [
  [0, 0, 0],
  [0.1, -0.2, 0.3],
  [-3, 1.5, 2],
  [Math.PI, 0, 0],
  [0, 0, Math.PI],
  [Math.PI, 0, -Math.PI / 2],
  [1e-9, 0, -1e-9],
  [0, Math.PI / 2, 1],
];

function expectSame(actual: Rotation, wanted: Rotation): void {
  actual.forEach((row, i) => {
    row.forEach((value, j) => {
      expect(value).toBeCloseTo(wanted[i]?.[j] ?? NaN, 10);
    });
  });
}

describe("rotations", () => {
  it.each(RPY)("come back: roll %f, pitch %f, yaw %f", (...rpy) => {
    const R = fromRpy(rpy);
    expectSame(fromRpy(toRpy(R)), R);
    expectSame(fromQuaternion(toQuaternion(R)), R);
    expectSame(fromRotationVector(toRotationVector(R)), R);
    expectSame(product(R, transposed(R)), IDENTITY.R);
    expect(Math.hypot(...toQuaternion(R))).toBeCloseTo(1, 12);
  });

  it.each(RPY)("are those of three: roll %f, pitch %f, yaw %f", (...rpy) => {
    const R = fromRpy(rpy);
    const euler = new Euler(...rpy, "ZYX");
    const turned = new Vector3(1, -2, 0.5).applyEuler(euler);
    apply(R, [1, -2, 0.5]).forEach((value, i) => {
      expect(value).toBeCloseTo(turned.getComponent(i), 10);
    });
    expectSame(rotationOf(new Quaternion().setFromEuler(euler)), R);
    expectSame(rotationOf(quaternionOf(R)), R);
  });

  it("about an axis of any length are those of rotation vectors", () => {
    expectSame(aboutAxis([0, 3, 4], 0.7), fromRotationVector([0, 0.42, 0.56]));
  });
});

describe("poses", () => {
  const poses = RPY.map((rpy, i): Pose => ({ p: [i, -i, 0.5], R: fromRpy(rpy) }));

  it("compose with their inverses to none", () => {
    for (const pose of poses) {
      for (const none of [compose(pose, inverse(pose)), compose(inverse(pose), pose)]) {
        expectSame(none.R, IDENTITY.R);
        for (const value of none.p) expect(value).toBeCloseTo(0, 10);
      }
    }
  });

  it("of links are those of nested objects of three", () => {
    const ur5 = parseUrdf(UR5);
    const positionOf = (joint: string) => Math.sin(joint.length);
    const objects = new Map([[ur5.root, new Object3D()]]);
    const place = (parent: string) => {
      for (const joint of ur5.childJoints.get(parent) ?? []) {
        const child = nested(joint, positionOf(joint.name));
        objects.get(parent)?.add(child.parent ?? child);
        objects.set(joint.child, child);
        place(joint.child);
      }
    };
    place(ur5.root);
    objects.get(ur5.root)?.updateMatrixWorld(true);
    expect(objects.size).toBe(ur5.links.size);
    for (const [name, object] of objects) {
      const { p, R } = linkPose(ur5, name, positionOf);
      const seen = object.getWorldPosition(new Vector3());
      p.forEach((value, i) => {
        expect(value).toBeCloseTo(seen.getComponent(i), 10);
      });
      expectSame(R, rotationOf(object.getWorldQuaternion(new Quaternion())));
    }
  });
});

/** Return the child link of a joint, in an object at the joint's origin. */
function nested({ origin, axis, type }: UrdfJoint, position: number): Object3D {
  const [frame, child] = [new Object3D(), new Object3D()];
  frame.position.set(...origin.xyz);
  frame.rotation.set(...origin.rpy, "ZYX");
  frame.add(child);
  if (type !== "fixed") {
    child.quaternion.setFromAxisAngle(new Vector3(...axis).normalize(), position);
  }
  return child;
}
