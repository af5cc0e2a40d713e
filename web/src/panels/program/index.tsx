/** The program of an arm: taught, edited, checked and run. */
import { useEffect } from "preact/hooks";
import { t } from "../../i18n";
import { watchKeys } from "../../program/keys";
import { hidePreview } from "../../program/checking";
import { refresh } from "../../program/files";
import { view } from "../../store";
import { AddBar } from "./add-bar";
import { Files } from "./files";
import { RunBar } from "./run-bar";
import { StepFields } from "./step-fields";
import { StepList } from "./step-list";
import "./program.css";

export default function ProgramPanel() {
  useEffect(() => hidePreview, []);
  const connected = view.value;
  useEffect(() => {
    void refresh();
  }, [connected]);
  return (
    <div class="program-panel" onKeyDown={watchKeys}>
      <Files />
      <RunBar />
      <section class="group" aria-labelledby="program-steps-title">
        <header>
          <h2 id="program-steps-title">{t("program.steps")}</h2>
        </header>
        <StepList />
        <AddBar />
      </section>
      <StepFields />
    </div>
  );
}
