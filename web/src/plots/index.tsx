export default function PlotsPanel() {
  return null;
}
