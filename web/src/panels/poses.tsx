import { useState } from "preact/hooks";
import { sendRequest } from "../connection";
import { adopt, mayMove, speedScale } from "../driving";
import { t } from "../i18n";
import { report } from "../notices";
import type { PoseInfo } from "../protocol";
import { status } from "../store";
import { Button, IconButton } from "../ui/button";
import { TrashIcon } from "../ui/icons";
import { confirm } from "./confirmation";

async function go(pose: PoseInfo): Promise<void> {
  const speed = speedScale.value;
  const problem = await sendRequest("go_to_pose", { name: pose.name, speed });
  if (problem === null) adopt(pose.positions);
}

export function PosesPanel() {
  const poses = status.value?.poses ?? [];
  return (
    <section class="group" aria-labelledby="poses-title">
      <header>
        <h2 id="poses-title">{t("poses.title")}</h2>
      </header>
      {poses.length === 0 && <p class="muted">{t("poses.none")}</p>}
      <ul class="poses">
        {poses.map((pose) => (
          <li key={pose.name}>
            <span class="grow ellipsis">{pose.name}</span>
            {pose.saved && (
              <IconButton
                label={t("poses.delete", { name: pose.name })}
                data-testid={`pose-delete-${pose.name}`}
                onClick={() => {
                  const { name } = pose;
                  confirm(
                    t("confirm.deletePose", { name }),
                    t("confirm.delete"),
                    () => {
                      void sendRequest("delete_pose", { name });
                    },
                  );
                }}
              >
                <TrashIcon />
              </IconButton>
            )}
            <Button
              aria-label={t("poses.goLong", { name: pose.name })}
              disabled={!mayMove.value}
              data-testid={`pose-go-${pose.name}`}
              onClick={() => void go(pose)}
            >
              {t("poses.go")}
            </Button>
          </li>
        ))}
      </ul>
      <SavePose />
    </section>
  );
}

function SavePose() {
  const [name, setName] = useState("");
  const save = async (chosen: string) => {
    const problem = await sendRequest("save_pose", { name: chosen });
    if (problem !== null) return;
    report("info", t("poses.saved", { name: chosen }));
    setName("");
  };
  return (
    <form
      class="row"
      onSubmit={(event) => {
        event.preventDefault();
        const chosen = name.trim();
        if (chosen === "") return;
        if (!status.value?.poses.some((pose) => pose.saved && pose.name === chosen)) {
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
      <span class="field grow">
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
