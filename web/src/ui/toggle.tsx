import type { Signal } from "@preact/signals";

interface ToggleProps {
  label: string;
  checked: boolean;
  disabled?: boolean;
  onChange: (checked: boolean) => void;
  "data-testid"?: string;
}

export function Toggle({ label, checked, onChange, ...rest }: ToggleProps) {
  return (
    <button
      type="button"
      class="toggle"
      role="switch"
      aria-checked={checked}
      onClick={() => {
        onChange(!checked);
      }}
      {...rest}
    >
      <span class="knob" />
      {label}
    </button>
  );
}

interface SignalToggleProps {
  label: string;
  of: Signal<boolean>;
  "data-testid": string;
}

/** Switches a signal. */
export function SignalToggle({ of, ...rest }: SignalToggleProps) {
  return (
    <Toggle
      checked={of.value}
      onChange={(on) => {
        of.value = on;
      }}
      {...rest}
    />
  );
}
