export function FreezeIcon() {
  return (
    <svg
      class="icon"
      viewBox="0 0 16 16"
      fill="none"
      stroke="currentColor"
      stroke-width="1.4"
      stroke-linecap="round"
      aria-hidden="true"
    >
      <path d="M8 1.8v12.4M2.6 4.9l10.8 6.2M2.6 11.1l10.8-6.2M6.4 2.6 8 4l1.6-1.4M6.4 13.4 8 12l1.6 1.4" />
    </svg>
  );
}

export function PictureIcon() {
  return (
    <svg
      class="icon"
      viewBox="0 0 16 16"
      fill="none"
      stroke="currentColor"
      stroke-width="1.4"
      stroke-linejoin="round"
      aria-hidden="true"
    >
      <rect x="2" y="2.8" width="12" height="10.4" rx="1.4" />
      <path d="m2.6 11.4 3.4-3.6 2.6 2.6 1.8-1.8 3 3" />
      <circle cx="10.6" cy="5.9" r="1" />
    </svg>
  );
}
