// What pages use of three.js (lagrange_cli/page/assets/space.js).

export { AmbientLight } from "three/src/lights/AmbientLight.js";
export { BufferAttribute } from "three/src/core/BufferAttribute.js";
export { BufferGeometry } from "three/src/core/BufferGeometry.js";
export { Color } from "three/src/math/Color.js";
export { DirectionalLight } from "three/src/lights/DirectionalLight.js";
export { DoubleSide } from "three/src/constants.js";
export { InstancedMesh } from "three/src/objects/InstancedMesh.js";
export { LineBasicMaterial } from "three/src/materials/LineBasicMaterial.js";
export { LineSegments } from "three/src/objects/LineSegments.js";
export { Matrix4 } from "three/src/math/Matrix4.js";
export { Mesh } from "three/src/objects/Mesh.js";
export { MeshBasicMaterial } from "three/src/materials/MeshBasicMaterial.js";
export { MeshLambertMaterial } from "three/src/materials/MeshLambertMaterial.js";
export { PerspectiveCamera } from "three/src/cameras/PerspectiveCamera.js";
export { Scene } from "three/src/scenes/Scene.js";
export { Vector3 } from "three/src/math/Vector3.js";
export { WebGLRenderer } from "three/src/renderers/WebGLRenderer.js";
