/** Whether a CSS media query applies. */
import { useEffect, useState } from "preact/hooks";

export function useMedia(query: string): boolean {
  const [applies, setApplies] = useState(() => window.matchMedia(query).matches);
  useEffect(() => {
    const list = window.matchMedia(query);
    const update = () => {
      setApplies(list.matches);
    };
    update();
    list.addEventListener("change", update);
    return () => {
      list.removeEventListener("change", update);
    };
  }, [query]);
  return applies;
}
