/** The tool on the motion tab: it can be folded; what is inside is loaded on demand. */
import { useRef } from "preact/hooks";
import { t } from "../i18n";
import { hasArm } from "../jog";
import { useLive } from "../live";
import { frameName, inNumberFrame } from "../number-frame";
import { arm, toolPose } from "../tool";
import { ChevronDownIcon, ChevronUpIcon } from "../ui/icons";
import { Lazy } from "../ui/lazy";
import { rememberedFlag } from "../ui/memory";
import { fixed } from "../ui/number-field";

const isOpen = rememberedFlag("tool", ["closed", "open"]);
const load = () => import("./tool/index");

export function ToolSection() {
  if (arm.value === null) return null;
  return (
    <section class="group tool" aria-labelledby="tool-title">
      <header>
        <h2 id="tool-title">
          <button
            type="button"
            class="fold"
            aria-expanded={isOpen.value}
            data-testid="tool-toggle"
            onClick={() => {
              isOpen.value = !isOpen.value;
            }}
          >
            {t("tool.title")} <code class="muted">{arm.value.tip}</code>
            {isOpen.value ? <ChevronUpIcon /> : <ChevronDownIcon />}
          </button>
        </h2>
        {!isOpen.value && <Position />}
        {isOpen.value && hasArm.value && (
          <span class="hint ellipsis" title={t("jog.active")}>
            {t("jog.active")}
          </span>
        )}
      </header>
      {isOpen.value && <Lazy load={load} />}
    </section>
  );
}

/** Where the tool is [mm], while the rest is folded. */
function Position() {
  const text = useRef<HTMLSpanElement | null>(null);
  useLive(() => {
    if (text.current === null) return;
    const { p } = inNumberFrame(toolPose());
    text.current.textContent = `${p.map((x) => fixed(x * 1000, 1)).join("  ")} mm`;
  });
  return (
    <span class="muted tool-position">
      {frameName()} <span ref={text} data-testid="tool-position" />
    </span>
  );
}
