import type { Kind } from "../../program/steps";
import { icon } from "../../ui/icons";

export const GripIcon = icon(
  <path d="M6 4v.01M10 4v.01M6 8v.01M10 8v.01M6 12v.01M10 12v.01" stroke-width="2" />,
);
export const LoopIcon = icon(
  <path d="M3 8a4 4 0 0 1 4-4h6m-2-2 2 2-2 2M13 8a4 4 0 0 1-4 4H3m2 2-2-2 2-2" />,
);
export const UndoIcon = icon(<path d="M5.5 3 2.5 6l3 3M2.5 6h7a4 4 0 0 1 0 8H6" />);
export const RedoIcon = icon(<path d="m10.5 3 3 3-3 3M13.5 6h-7a4 4 0 0 0 0 8H10" />);
export const CheckIcon = icon(<path d="m3 8.5 3.5 3.5L13 4.5" />);
export const FileIcon = icon(<path d="M4 1.8h5L12.5 5v9.2H4zM9 1.8V5h3.5" />);

export const KIND_ICONS: Record<Kind, ReturnType<typeof icon>> = {
  move_joint: icon(<path d="M2.5 13C3 6 7 3.5 13 3.5m-3-2 3 2-3 2.2" />),
  move_linear: icon(<path d="M2.5 13.5 13 3M8.5 2.8H13V7" />),
  gripper: icon(
    <path d="M8 1.8v3.4M4.8 5.2h6.4M4.8 5.2 3 9.3l1.8 4.4M11.2 5.2 13 9.3l-1.8 4.4" />,
  ),
  wait: icon(
    <>
      <circle cx="8" cy="8" r="6" />
      <path d="M8 4.5V8l2.5 1.5" />
    </>,
  ),
  until: icon(<path d="M8 1.8v8m-3-3 3 3 3-3M2.5 13.5h11" />),
  place_object: icon(
    <path d="M8 1.8 13.5 4.9v6.2L8 14.2l-5.5-3.1V4.9zM2.5 4.9 8 8l5.5-3.1M8 8v6.2" />,
  ),
  set_output: icon(<path d="M2 10.5h3v-5h4v5h5" />),
  comment: icon(<path d="M2.5 3h11v8H8l-3 2.5V11H2.5z" />),
  loop: LoopIcon,
};
