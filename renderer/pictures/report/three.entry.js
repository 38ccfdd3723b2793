// What of three.js (MIT, https://threejs.org) the page uses; three.min.js.gz is made from this by `make three`.
export {
  BufferAttribute, BufferGeometry, ColorManagement, LineBasicMaterial, LineLoop, LinearSRGBColorSpace, Mesh,
  MeshBasicMaterial, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
