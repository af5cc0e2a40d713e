/** Buttons that act while they are pressed. */

/** Let a finger that slides off a button leave it, as a mouse does. */
export function uncapture(
  event: Pick<PointerEvent, "pointerId"> & { readonly currentTarget: Element },
): void {
  const { currentTarget: button, pointerId } = event;
  if (button.hasPointerCapture(pointerId)) button.releasePointerCapture(pointerId);
}
