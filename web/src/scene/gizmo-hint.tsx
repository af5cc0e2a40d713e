/** Why the arm cannot reach where the gizmo is. */
import { showGizmo, unreachable } from "../tool-target";

export function GizmoHint() {
  const reason = unreachable.value;
  if (!showGizmo.value || reason === null) return null;
  return (
    <p class="scene-hint problem" role="status" data-testid="gizmo-problem">
      {reason}
    </p>
  );
}
