import { useState } from "preact/hooks";
import { sendRequest } from "../connection";
import { adopt, mayMove, speedScale } from "../driving";
import { openingAt } from "../gripper-opening";
import { t } from "../i18n";
import { hasArm, letGo } from "../jog";
import { report } from "../notices";
import { goThere } from "../planning/way-around";
import type { PoseInfo } from "../protocol";
import { isOurs, selected } from "../robots";
import { offers, status, unlessOffered, view } from "../store";
import { arm } from "../tool";
import { Button, IconButton } from "../ui/button";
import { TrashIcon } from "../ui/icons";
import { confirm } from "./confirmation";

/** By which an opening differs before the gripper lets go [m]. */
const RELEASING = 1e-3;

/** The selected robot, as requests name it; nothing, if there is only one. */
function ofSelected(): { robot?: string } {
  return selected.value === null ? {} : { robot: selected.value.name };
}

function jointsOf(pose: PoseInfo): readonly string[] {
  return Object.keys(pose.positions);
}

/** Return the question whether to delete a pose, which other robots may have, too. */
function deletion(pose: PoseInfo): string {
  const isOurOwn = jointsOf(pose).every(isOurs);
  return t(isOurOwn ? "confirm.deletePose" : "confirm.deletePoseAll", {
    name: pose.name,
  });
}

/** Return the grippers that would drop what they hold on the way to a pose. */
function dropping(pose: PoseInfo): readonly string[] {
  return (view.value?.robot.grippers ?? [])
    .filter((gripper) => {
      const state = status.value?.grippers.find(({ name }) => name === gripper.name);
      const q = isOurs(gripper.joint) ? pose.positions[gripper.joint] : undefined;
      if (state === undefined || q === undefined) return false;
      const way = openingAt(gripper, q) - state.opening;
      const releases =
        (state.motion === "holding_inside" && way > 0) ||
        (state.motion === "holding_outside" && way < 0);
      return releases && Math.abs(way) > RELEASING;
    })
    .map(({ name }) => name);
}

/** Go to a pose; before a gripper drops what it holds, ask. */
function goOrAsk(pose: PoseInfo): void {
  const names = dropping(pose);
  if (names.length === 0) {
    void go(pose);
    return;
  }
  const values = { name: pose.name, grippers: names.join(", ") };
  confirm(t("confirm.dropping", values), t("confirm.letGo"), () => {
    void go(pose);
  });
}

async function go(pose: PoseInfo): Promise<void> {
  if (!mayMove.peek()) return;
  if (hasArm.peek()) await letGo();
  if (pose.is_gripper || arm.peek() === null) {
    await move(pose);
    return;
  }
  const joints = Object.entries(pose.positions).filter(([joint]) => isOurs(joint));
  const there = {
    arm: arm.peek()?.name ?? null,
    positions: Object.fromEntries(joints),
  };
  await goThere({
    direct: there,
    isStraight: false,
    target: there,
    move: () => move(pose),
  });
}

async function move(pose: PoseInfo): Promise<void> {
  if (!mayMove.peek()) return;
  const speed = speedScale.peek();
  const problem = await sendRequest("go_to_pose", {
    name: pose.name,
    speed,
    ...ofSelected(),
  });
  if (problem === null) adopt(pose.positions);
}

export function PosesPanel() {
  const poses = (status.value?.poses ?? []).filter(
    (pose) => selected.value === null || jointsOf(pose).some(isOurs),
  );
  const ofGrippers = poses.filter((pose) => pose.is_gripper);
  return (
    <section class="group" aria-labelledby="poses-title">
      <header>
        <h2 id="poses-title">{t("poses.title")}</h2>
        {offers("save_pose") && <SavePose />}
      </header>
      {poses.length === 0 && <p class="muted">{t("poses.none")}</p>}
      <Poses poses={poses.filter((pose) => !pose.is_gripper)} />
      {ofGrippers.length > 0 && (
        <div class="gripper-poses" role="group" aria-labelledby="gripper-poses-title">
          <h3 id="gripper-poses-title">{t("poses.ofGripper")}</h3>
          <Poses poses={ofGrippers} />
        </div>
      )}
    </section>
  );
}

function Poses({ poses }: { poses: readonly PoseInfo[] }) {
  return (
    <ul class="poses">
      {poses.map((pose) => (
        <li key={pose.name}>
          <Button
            aria-label={t("poses.goLong", { name: pose.name })}
            disabled={!mayMove.value}
            data-testid={`pose-go-${pose.name}`}
            onClick={() => {
              goOrAsk(pose);
            }}
            {...unlessOffered("go_to_pose")}
          >
            <span class="ellipsis">{pose.name}</span>
          </Button>
          {pose.saved && (
            <IconButton
              label={t("poses.delete", { name: pose.name })}
              data-testid={`pose-delete-${pose.name}`}
              onClick={() => {
                const { name } = pose;
                confirm(deletion(pose), t("confirm.delete"), () => {
                  void sendRequest("delete_pose", { name });
                });
              }}
              {...unlessOffered("delete_pose")}
            >
              <TrashIcon />
            </IconButton>
          )}
        </li>
      ))}
    </ul>
  );
}

function SavePose() {
  const [name, setName] = useState("");
  const save = async (chosen: string) => {
    const problem = await sendRequest("save_pose", {
      name: chosen,
      ...ofSelected(),
    });
    if (problem !== null) return;
    report("info", t("poses.saved", { name: chosen }));
    setName("");
  };
  return (
    <form
      class="pose-form"
      onSubmit={(event) => {
        event.preventDefault();
        const chosen = name.trim();
        if (chosen === "") return;
        const same = status.value?.poses.find(
          (pose) => pose.saved && pose.name === chosen,
        );
        if (!same || (selected.value !== null && !jointsOf(same).some(isOurs))) {
          void save(chosen);
          return;
        }
        confirm(
          t("confirm.overwritePose", { name: chosen }),
          t("confirm.overwrite"),
          () => {
            void save(chosen);
          },
        );
      }}
    >
      <span class="field">
        <input
          type="text"
          maxLength={200}
          value={name}
          placeholder={t("poses.name")}
          aria-label={t("poses.name")}
          data-testid="pose-name"
          onInput={(event) => {
            setName(event.currentTarget.value);
          }}
        />
      </span>
      <Button type="submit" disabled={name.trim() === ""} data-testid="pose-save">
        {t("poses.save")}
      </Button>
    </form>
  );
}
