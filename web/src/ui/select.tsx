import { ChevronDownIcon } from "./icons";

export interface Option {
  value: string;
  label: string;
  disabled?: boolean;
}

interface SelectProps {
  label: string;
  value: string;
  options: readonly Option[];
  disabled?: boolean;
  /** The tooltip: the label, if left out. */
  title?: string;
  class?: string;
  onChange: (value: string) => void;
  "data-testid"?: string;
}

export function Select(props: SelectProps) {
  return (
    <span class={`select ${props.class ?? ""}`}>
      <select
        aria-label={props.label}
        title={props.title ?? props.label}
        value={props.value}
        disabled={props.disabled ?? false}
        data-testid={props["data-testid"]}
        onChange={(event) => {
          props.onChange(event.currentTarget.value);
        }}
      >
        {props.options.map((option) => (
          <option
            key={option.value}
            value={option.value}
            disabled={option.disabled ?? false}
            selected={option.value === props.value}
          >
            {option.label}
          </option>
        ))}
      </select>
      <ChevronDownIcon />
    </span>
  );
}
