/** The list of keyboard shortcuts. */
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { type Key, t } from "../i18n";
import { register, type ShortcutGroup, shortcuts } from "../shortcuts";
import { IconButton } from "../ui/button";
import { CloseIcon } from "../ui/icons";

const GROUPS: Record<ShortcutGroup, Key> = {
  general: "shortcuts.general",
  scene: "shortcuts.scene",
  jog: "shortcuts.jog",
  program: "shortcuts.program",
  timeline: "shortcuts.timeline",
};

const isOpen = signal(false);

export function toggleShortcutHelp(): void {
  isOpen.value = !isOpen.value;
}

register(
  {
    keys: ["?"],
    text: "shortcuts.help",
    group: "general",
    run: toggleShortcutHelp,
  },
  { keys: ["Escape"], text: "shortcuts.stop", group: "general" },
  { keys: ["1", "2", "3", "4", "5", "6"], text: "shortcuts.views", group: "scene" },
  { keys: ["f"], text: "shortcuts.fit", group: "scene" },
  { keys: ["←", "→", "↑", "↓"], text: "shortcuts.turn", group: "scene" },
  { keys: ["+", "-"], text: "shortcuts.zoom", group: "scene" },
);

export function ShortcutHelp() {
  return isOpen.value ? <Help /> : null;
}

function Help() {
  const root = useRef<HTMLDivElement | null>(null);
  useEffect(() => {
    const before = document.activeElement;
    root.current?.querySelector("button")?.focus();
    return () => {
      if (before instanceof HTMLElement) before.focus();
    };
  }, []);
  const groups = Object.entries(GROUPS) as [ShortcutGroup, Key][];
  return (
    <div
      class="shortcut-help"
      role="dialog"
      aria-labelledby="shortcuts-title"
      data-testid="shortcut-help"
      ref={root}
    >
      <div class="title">
        <h2 id="shortcuts-title">{t("shortcuts.title")}</h2>
        <IconButton
          label={t("app.close")}
          data-testid="shortcut-help-close"
          onClick={toggleShortcutHelp}
        >
          <CloseIcon />
        </IconButton>
      </div>
      {groups.map(([group, title]) => {
        const listed = shortcuts.value.filter((one) => one.group === group);
        if (listed.length === 0) return null;
        return (
          <section key={group}>
            <h3>{t(title)}</h3>
            <dl>
              {listed.map(({ keys, text }) => (
                <div key={text}>
                  <dt>
                    {keys.map((key) => (
                      <kbd key={key}>{key === " " ? t("shortcuts.space") : key}</kbd>
                    ))}
                  </dt>
                  <dd>{t(text)}</dd>
                </div>
              ))}
            </dl>
          </section>
        );
      })}
    </div>
  );
}
