/** `tool0 view`: no physics; sliders set the joints. */
import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { connection } from "../connection";
import { t } from "../i18n";
import type { JointInfo } from "../protocol";
import { isOurs } from "../robots";
import { joints } from "../store";
import { Button } from "../ui/button";
import { spanOf } from "../units";
import { JointRow } from "./joint-row";
import { UnitSwitch } from "./unit-switch";

const FOLLOW_AFTER_MS = 500;

function free(): readonly JointInfo[] {
  return joints.value.filter(({ name, mimics }) => mimics === null && isOurs(name));
}

function pose(positionOf: (joint: JointInfo) => number): void {
  const positions = Object.fromEntries(
    free().map((joint) => {
      const [lower, upper] = spanOf(joint);
      return [joint.name, Math.min(upper, Math.max(lower, positionOf(joint)))];
    }),
  );
  connection.stream("pose_joints", { positions });
}

/** Return the middle of the limits; zero where there are none. */
function centre(joint: JointInfo): number {
  const [lower, upper] = spanOf(joint);
  return (lower + upper) / 2;
}

function anywhere(joint: JointInfo): number {
  const [lower, upper] = spanOf(joint);
  return lower + Math.random() * (upper - lower);
}

/** A slider that leads its joint while the user moves it, and follows it otherwise. */
function PosedJoint({ joint }: { joint: JointInfo }) {
  const goal = useRef(signal(0));
  const [isMoved, setMoved] = useState(false);
  const timer = useRef<ReturnType<typeof setTimeout>>(undefined);
  useEffect(() => {
    return () => {
      clearTimeout(timer.current);
    };
  }, []);

  const change = (position: number) => {
    goal.current.value = position;
    setMoved(true);
    clearTimeout(timer.current);
    timer.current = setTimeout(() => {
      setMoved(false);
    }, FOLLOW_AFTER_MS);
    connection.stream("pose_joints", { positions: { [joint.name]: position } });
  };
  return (
    <JointRow
      joint={joint}
      goal={isMoved ? goal.current : null}
      editable
      onChange={change}
    />
  );
}

export function ViewPanel() {
  return (
    <section class="group" aria-labelledby="view-title">
      <header>
        <h2 id="view-title">{t("view.joints")}</h2>
        <UnitSwitch />
      </header>
      <p class="hint">{t("view.explain")}</p>
      <ul class="joints">
        {free().map((joint) => (
          <PosedJoint key={joint.name} joint={joint} />
        ))}
      </ul>
      <div class="row">
        <Button
          data-testid="view-zero"
          onClick={() => {
            pose(() => 0);
          }}
        >
          {t("view.zero")}
        </Button>
        <Button
          data-testid="view-centre"
          onClick={() => {
            pose(centre);
          }}
        >
          {t("view.centre")}
        </Button>
        <Button
          data-testid="view-randomize"
          onClick={() => {
            pose(anywhere);
          }}
        >
          {t("view.randomize")}
        </Button>
      </div>
    </section>
  );
}
