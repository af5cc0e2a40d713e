import { icon } from "../ui/icons";

export const PreviousIcon = icon(
  <>
    <path d="M11.5 3.5v9L5.5 8z" fill="currentColor" />
    <path d="M3.5 3.5v9" />
  </>,
);
export const NextIcon = icon(
  <>
    <path d="M4.5 3.5v9l6-4.5z" fill="currentColor" />
    <path d="M12.5 3.5v9" />
  </>,
);
export const LoopIcon = icon(
  <path d="M3 9.5V7a2.5 2.5 0 0 1 2.5-2.5H12M9.8 2.3 12 4.5 9.8 6.7M13 6.5V9a2.5 2.5 0 0 1-2.5 2.5H4m2.2 2.2L4 11.5l2.2-2.2" />,
);
