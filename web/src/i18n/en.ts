export const en = {
  "app.title": "tool0",
} as const;
