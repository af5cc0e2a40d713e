/** A posture that is planned and not yet executed: the ghost shows it. */
import { signal } from "@preact/signals";

/** Joint → position [rad | m], in place of the commanded goal; null for none. */
export const plannedPose = signal<Readonly<Record<string, number>> | null>(null);
