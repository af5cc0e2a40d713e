/** The cameras to choose from. */
import { t } from "../i18n";
import { Toggle } from "../ui/toggle";
import { cameras, change, settingOf } from "./state";

export function CameraToggles() {
  if (cameras.value.length === 0) return null;
  return (
    <>
      <p class="scene-heading">{t("cameras.title")}</p>
      {cameras.value.map(({ name }) => (
        <Toggle
          key={name}
          label={name}
          checked={settingOf(name).isOpen}
          data-testid={`camera-toggle-${name}`}
          onChange={(isOpen) => {
            change(name, { isOpen });
          }}
        />
      ))}
    </>
  );
}
