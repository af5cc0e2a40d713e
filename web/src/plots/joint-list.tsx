/** The joints to choose from, which is the legend too: colour, name, and value. */
import type { RefObject } from "preact";
import { t } from "../i18n";
import { isOurs, withoutPrefix } from "../robots";
import { joints } from "../store";
import { choose, colours } from "./state";

export function JointList({ root }: { root: RefObject<HTMLDivElement | null> }) {
  return (
    <div class="plots-joints" ref={root} role="group" aria-label={t("plots.joints")}>
      {joints.value.map(({ name }) => {
        if (!isOurs(name)) return null;
        const colour = colours.value.get(name);
        return (
          <label key={name} data-colour={colour === undefined ? null : colour + 1}>
            <input
              type="checkbox"
              checked={colour !== undefined}
              data-testid={`plots-joint-${name}`}
              onChange={(event) => {
                choose(name, event.currentTarget.checked);
              }}
            />
            <span class="name">{withoutPrefix(name)}</span>
            <output data-joint={name} />
          </label>
        );
      })}
    </div>
  );
}
