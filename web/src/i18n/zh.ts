import type { Texts } from ".";

export const zh: Texts = {
  "app.title": "tool0",
};
