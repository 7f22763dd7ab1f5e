// What viewer.js needs of three.js; esbuild bundles it at build time as the global `three`.
export {
  AmbientLight, BufferAttribute, BufferGeometry, ColorManagement, DirectionalLight, DoubleSide, LinearSRGBColorSpace,
  LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, OrthographicCamera, Plane, Points,
  PointsMaterial, Raycaster, Scene, Vector2, Vector3, WebGLRenderer, MOUSE, TOUCH,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
