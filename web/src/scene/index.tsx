export default function SceneView() {
  return null;
}
