/** The controller manager: controllers, states and claims; load, start, switch. */
import { Fragment } from "preact";
import { useState } from "preact/hooks";
import { conflicting } from "../conflicts";
import { connection } from "../connection";
import { mayMove } from "../driving";
import { t } from "../i18n";
import type { Method, Params } from "../messages";
import type { ControllerInfo, ErrorInfo } from "../protocol";
import { robotOf, robots, selected } from "../robots";
import { status, unlessOffered } from "../store";
import { Badge } from "../ui/badge";
import type { Tone } from "../ui/badge";
import { Button } from "../ui/button";

const TONES: Record<ControllerInfo["state"], Tone> = {
  running: "ok",
  stopped: "neutral",
  initialized: "neutral",
  active: "ok",
  inactive: "neutral",
  unconfigured: "neutral",
  unloaded: "neutral",
};

interface Group {
  /** Its heading, if there are several robots. */
  readonly title: string | null;
  readonly controllers: readonly ControllerInfo[];
}

/** Return the controllers by robot, those of the selected one first. */
function groups(all: readonly ControllerInfo[]): readonly Group[] {
  if (robots.value.length === 0) return [{ title: null, controllers: all }];
  const order = [selected.value ?? undefined, undefined, ...robots.value];
  return [...new Set(order)]
    .map((robot) => ({
      title: robot?.name ?? t("controllers.shared"),
      controllers: all.filter((controller) => robotOf(controller) === robot),
    }))
    .filter(({ controllers }) => controllers.length > 0);
}

export function ControllersPanel() {
  const all = status.value?.controllers ?? [];
  return (
    <section class="group" aria-labelledby="controllers-title">
      <header>
        <h2 id="controllers-title">{t("controllers.title")}</h2>
      </header>
      {all.length === 0 && <p class="muted">{t("controllers.none")}</p>}
      {groups(all).map(({ title, controllers }) => (
        <Fragment key={title}>
          {title !== null && <h3 class="controllers-robot">{title}</h3>}
          <ul class="controllers">
            {controllers.map((controller) => (
              <ControllerRow key={controller.name} controller={controller} all={all} />
            ))}
          </ul>
        </Fragment>
      ))}
    </section>
  );
}

interface RowProps {
  controller: ControllerInfo;
  all: readonly ControllerInfo[];
}

function ControllerRow({ controller, all }: RowProps) {
  const [problem, setProblem] = useState<ErrorInfo | null>(null);
  const { name, state, is_running } = controller;
  const inTheWay = is_running ? [] : conflicting(controller, all);
  const send = <M extends Method>(method: M, ...params: Params<M>) => {
    void connection.request(method, ...params).then(setProblem);
  };
  const action = <M extends Method>(
    key: "load" | "configure" | "unload" | "start" | "stop",
    method: M,
    ...params: Params<M>
  ) => (
    <Button
      aria-label={t("controllers.action", { action: t(`controllers.${key}`), name })}
      disabled={key === "start" && !mayMove.value}
      data-testid={`controller-${key}-${name}`}
      onClick={() => {
        send(method, ...params);
      }}
      {...unlessOffered(method)}
    >
      {t(`controllers.${key}`)}
    </Button>
  );

  return (
    <li data-testid={`controller-row-${name}`} data-state={state}>
      <div class="controller-head">
        <code class="controller-name">{name}</code>
        <Badge tone={TONES[state]}>{t(`controllers.state.${state}`)}</Badge>
      </div>
      <div class="controller-type">
        <span class="muted">
          {controller.type.split("/").map((part, index) => (
            <Fragment key={index}>
              {index > 0 && "/"}
              <wbr />
              {part}
            </Fragment>
          ))}
        </span>
        {state === "unloaded" && action("load", "load_controller", { name })}
        {is_running && action("stop", "switch_controllers", { stop: [name] })}
        {state === "unconfigured" &&
          action("configure", "configure_controller", { name })}
        {!is_running && state !== "unloaded" && (
          <>
            {state !== "unconfigured" &&
              action("start", "switch_controllers", { start: [name] })}
            {action("unload", "unload_controller", { name })}
          </>
        )}
      </div>
      {state !== "unloaded" && <Claims controller={controller} />}
      {state !== "unloaded" && inTheWay.length > 0 && (
        <Button
          kind={problem === null ? "default" : "primary"}
          class="switch"
          disabled={!mayMove.value}
          data-testid={`controller-switch-${name}`}
          onClick={() => {
            send("switch_controllers", { start: [name], stop: [...inTheWay] });
          }}
          {...unlessOffered("switch_controllers")}
        >
          {t("controllers.switch", { stop: inTheWay.join(", "), start: name })}
        </Button>
      )}
      {problem && (
        <p class="refusal" role="alert" data-testid={`controller-refusal-${name}`}>
          {problem.message}
        </p>
      )}
    </li>
  );
}

function Claims({ controller }: { controller: ControllerInfo }) {
  if (controller.interface === null) {
    return <p class="muted">{t("controllers.reads")}</p>;
  }
  return (
    <p class="claims">
      <span class="muted">
        {t("controllers.claims", { interface: controller.interface })}
      </span>{" "}
      {controller.joints.map((joint) => (
        <code key={joint}>{joint}</code>
      ))}
    </p>
  );
}
