/** The layer of what stands on the ground: robot and objects, but no ghost, grid or axes. */
export const MODEL_LAYER = 1;
