/** A cube seen from each side; the side that is looked at is filled. */
import { icon } from "../ui/icons";
import type { View } from "./framing";

const CUBE = "M8 1.8 13.5 4.9v6.2L8 14.2l-5.5-3.1V4.9zM2.5 4.9 8 8l5.5-3.1M8 8v6.2";

function cube(side: string) {
  return icon(
    <>
      <path d={side} fill="currentColor" stroke="none" opacity="0.55" />
      <path d={CUBE} />
    </>,
  );
}

export const VIEW_ICONS: Record<View, ReturnType<typeof icon>> = {
  iso: icon(<path d={CUBE} />),
  front: icon(
    <>
      <rect
        x="5"
        y="5"
        width="8.5"
        height="8.5"
        fill="currentColor"
        fill-opacity="0.45"
      />
      <path d="M5 5 2.5 2.5M13.5 5 11 2.5H2.5V11L5 13.5" />
    </>,
  ),
  left: cube("M2.5 4.9 8 8v6.2l-5.5-3.1z"),
  right: cube("M13.5 4.9 8 8v6.2l5.5-3.1z"),
  top: cube("M8 1.8 13.5 4.9 8 8 2.5 4.9z"),
  tool: icon(
    <>
      <path d="M8 1.8v3.4M4.8 5.2h6.4" />
      <path d="M4.8 5.2 3 9.3l1.8 4.4M11.2 5.2 13 9.3l-1.8 4.4" />
    </>,
  ),
};

export const HandIcon = icon(
  <path d="M5 8.2V4a1.1 1.1 0 0 1 2.2 0v3.2-4.6a1.1 1.1 0 0 1 2.2 0v4.6-3.4a1.1 1.1 0 0 1 2.2 0v6.4a4 4 0 0 1-4 4c-2 0-2.9-.8-3.8-2.4L2.2 9.2a1.1 1.1 0 0 1 1.9-1.1z" />,
);

export const FitIcon = icon(
  <path d="M2.5 5.5v-3h3M10.5 2.5h3v3M13.5 10.5v3h-3M5.5 13.5h-3v-3M6 8h4M8 6v4" />,
);
