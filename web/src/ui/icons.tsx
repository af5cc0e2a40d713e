/** Icons of 16 × 16, drawn in the colour of the text.  They are decoration: the button says its name. */
import type { ComponentChildren } from "preact";

export function icon(children: ComponentChildren) {
  return function Icon() {
    return (
      <svg
        class="icon"
        viewBox="0 0 16 16"
        fill="none"
        stroke="currentColor"
        stroke-width="1.5"
        stroke-linecap="round"
        stroke-linejoin="round"
        aria-hidden="true"
      >
        {children}
      </svg>
    );
  };
}

export const PlayIcon = icon(<path d="M5 3.2v9.6L12.5 8z" fill="currentColor" />);
export const PauseIcon = icon(<path d="M5.5 3.5v9M10.5 3.5v9" stroke-width="2" />);
export const StepIcon = icon(
  <>
    <path d="M4 3.5v9L10 8z" fill="currentColor" />
    <path d="M12.5 3.5v9" />
  </>,
);
export const ResetIcon = icon(<path d="M3 8a5 5 0 1 0 1.6-3.7L3 5.8M3 2.7v3.1h3.1" />);
export const UndoIcon = icon(<path d="M6 3 3 6l3 3M3 6h6a3.5 3.5 0 0 1 0 7H6" />);
export const RedoIcon = icon(<path d="m10 3 3 3-3 3M13 6H7a3.5 3.5 0 0 0 0 7h3" />);
export const StopIcon = icon(
  <rect x="4" y="4" width="8" height="8" rx="1" fill="currentColor" />,
);
export const RecordIcon = icon(<circle cx="8" cy="8" r="4.5" fill="currentColor" />);
export const CloseIcon = icon(<path d="m4 4 8 8m0-8-8 8" />);
export const ChevronDownIcon = icon(<path d="m4.5 6.5 3.5 3.5 3.5-3.5" />);
export const ChevronRightIcon = icon(<path d="M6.5 4.5 10 8l-3.5 3.5" />);
export const ChevronUpIcon = icon(<path d="M4.5 9.5 8 6l3.5 3.5" />);
export const SunIcon = icon(
  <>
    <circle cx="8" cy="8" r="2.8" />
    <path d="M8 1.5v1.2m0 10.6v1.2M1.5 8h1.2m10.6 0h1.2M3.4 3.4l.8.8m7.6 7.6.8.8m0-9.2-.8.8m-7.6 7.6-.8.8" />
  </>,
);
export const MoonIcon = icon(
  <path d="M13 9.7A5.5 5.5 0 0 1 6.3 3 5.5 5.5 0 1 0 13 9.7z" />,
);
export const SystemIcon = icon(
  <>
    <rect x="2" y="3" width="12" height="8" rx="1.2" />
    <path d="M6 13.5h4" />
  </>,
);
export const TrashIcon = icon(
  <path d="M3 4.5h10M6.5 4.5V3h3v1.5M4.5 4.5l.5 8.5h6l.5-8.5M7 7v3.5M9 7v3.5" />,
);
export const CopyIcon = icon(
  <>
    <rect x="5.5" y="5.5" width="8" height="8" rx="1.2" />
    <path d="M10.5 5.5v-2a1 1 0 0 0-1-1h-6a1 1 0 0 0-1 1v6a1 1 0 0 0 1 1h2" />
  </>,
);
export const AxesIcon = icon(
  <path d="M6 10V2.5m0 7.5h7.5M6 10l-3.5 3.5M4.5 4 6 2.5 7.5 4M12 8.5l1.5 1.5-1.5 1.5" />,
);
export const JointIcon = icon(
  <>
    <circle cx="8" cy="8" r="1.6" />
    <path d="M3.2 9.8a5 5 0 0 1 8.4-5.3M12 2v2.8H9.2" />
  </>,
);
export const LinkIcon = icon(
  <>
    <circle cx="3.8" cy="12.2" r="1.8" />
    <circle cx="12.2" cy="3.8" r="1.8" />
    <path d="m5.1 10.9 5.8-5.8" />
  </>,
);
export const InfoIcon = icon(
  <>
    <circle cx="8" cy="8" r="6" />
    <path d="M8 7.5v3.2M8 5.2v.1" />
  </>,
);
export const WarningIcon = icon(<path d="M8 2.3 14.3 13H1.7zM8 6.3v3.2M8 11.3v.1" />);
export const ErrorIcon = icon(
  <>
    <path d="M5.5 2h5L14 5.5v5L10.5 14h-5L2 10.5v-5z" />
    <path d="M8 5v3.5M8 10.8v.1" />
  </>,
);
export const EmergencyIcon = icon(
  <>
    <circle cx="8" cy="8" r="6.2" />
    <rect x="5.6" y="5.6" width="4.8" height="4.8" rx=".8" fill="currentColor" />
  </>,
);
export const PlotIcon = icon(<path d="M2.5 2.5v11h11M5 10l2.5-3.5 2.2 2L13 4.5" />);
export const PlusIcon = icon(<path d="M8 3v10M3 8h10" />);
export const DownloadIcon = icon(<path d="M8 2.5v7.5m-3-3 3 3 3-3M3 13h10" />);
export const EyeIcon = icon(
  <>
    <path d="M1.8 8S4 3.8 8 3.8 14.2 8 14.2 8 12 12.2 8 12.2 1.8 8 1.8 8z" />
    <circle cx="8" cy="8" r="1.8" />
  </>,
);
export const MenuIcon = icon(<path d="M2.5 4h11M2.5 8h11M2.5 12h11" />);
export const CameraIcon = icon(
  <>
    <path d="M2.5 5h2.6l1-1.5h3.8l1 1.5h2.6v7.5h-11z" />
    <circle cx="8" cy="8.6" r="2.2" />
  </>,
);
export const FullScreenIcon = icon(
  <path d="M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10" />,
);
export const KeyboardIcon = icon(
  <>
    <rect x="1.5" y="4" width="13" height="8.5" rx="1.2" />
    <path d="M4 6.7h.1m2.6 0h.1m2.6 0h.1m2.6 0h.1M5 10h6" />
  </>,
);
