import { icon } from "../ui/icons";

export const PictureIcon = icon(
  <>
    <rect x="2" y="2.8" width="12" height="10.4" rx="1.4" />
    <path d="m2.6 11.4 3.4-3.6 2.6 2.6 1.8-1.8 3 3" />
    <circle cx="10.6" cy="5.9" r="1" />
  </>,
);
