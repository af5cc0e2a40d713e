/** The way around what blocks the direct one, over the picture: search, plan, or neither. */
import { useEffect } from "preact/hooks";
import { mayMove } from "../driving";
import { t } from "../i18n";
import { durationOf } from "../planning/plan";
import {
  discard,
  moveAnyway,
  moveAround,
  shownTime,
  type WayAround,
  wayAround,
} from "../planning/way-around";
import type { Plan } from "../protocol";
import { Button } from "../ui/button";
import { WarningIcon } from "../ui/icons";
import { fixed } from "../ui/number-field";
import { Slider } from "../ui/slider";

export function PlanCard() {
  const now = wayAround.value;
  return now && <Shown now={now} />;
}

function Shown({ now }: { now: WayAround }) {
  useEffect(() => {
    // beside the emergency stop, which a robot may lack
    const escape = (event: KeyboardEvent) => {
      if (event.key === "Escape") discard();
    };
    window.addEventListener("keydown", escape, { capture: true });
    return () => {
      window.removeEventListener("keydown", escape, { capture: true });
    };
  }, []);
  return (
    <section
      class="scene-plan"
      aria-labelledby="plan-title"
      data-testid="plan"
      data-state={now.state}
    >
      <p class="plan-obstacle" role="status" data-testid="plan-obstacle">
        <WarningIcon />
        <span>
          <strong id="plan-title">{t("plan.title")}</strong> {now.obstacle}
        </span>
      </p>
      {now.state === "searching" && <Searching />}
      {now.state === "found" && <Found plan={now.plan} />}
      {now.state === "none" && <None problem={now.problem} />}
    </section>
  );
}

function Searching() {
  return (
    <div class="row">
      <span class="grow muted" role="status">
        {t("plan.searching")}
      </span>
      <Button data-testid="plan-cancel" onClick={discard}>
        {t("plan.cancel")}
      </Button>
    </div>
  );
}

/** Return how long the way takes, and how near bodies come to each other. */
function figuresOf(plan: Plan): string {
  const duration = fixed(durationOf(plan), 1);
  const { clearance, nearest: bodies } = plan;
  if (bodies === "") return t("plan.far", { duration });
  return t("plan.clearance", {
    duration,
    distance: fixed(clearance * 1000, 0),
    bodies,
  });
}

function Found({ plan }: { plan: Plan }) {
  const end = durationOf(plan);
  const time = shownTime.value;
  return (
    <>
      <div class="row">
        <Slider
          label={t("plan.time")}
          valueText={`${fixed(time, 1)} s`}
          min={0}
          max={end}
          step={end / 100}
          value={time}
          data-testid="plan-time"
          onInput={(value) => {
            shownTime.value = value;
          }}
        />
        <span class="figure">{fixed(time, 1)} s</span>
      </div>
      <div class="row">
        <span class="grow muted" data-testid="plan-figures">
          {figuresOf(plan)}
        </span>
        <Button data-testid="plan-discard" onClick={discard}>
          {t("plan.discard")}
        </Button>
        <Button
          kind="primary"
          disabled={!mayMove.value}
          data-testid="plan-move"
          onClick={() => void moveAround()}
        >
          {t("plan.move")}
        </Button>
      </div>
    </>
  );
}

function None({ problem }: { problem: string }) {
  return (
    <>
      <p class="refusal" role="alert" data-testid="plan-problem">
        {t("plan.none", { problem })}
      </p>
      <div class="row end">
        <Button data-testid="plan-discard" onClick={discard}>
          {t("plan.discard")}
        </Button>
        <Button
          kind="danger"
          disabled={!mayMove.value}
          data-testid="plan-anyway"
          onClick={() => void moveAnyway()}
        >
          {t("plan.anyway")}
        </Button>
      </div>
    </>
  );
}
