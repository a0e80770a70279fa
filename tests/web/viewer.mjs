// In the page: loads a GLB as any three.js application would, draws it once, and tells what it found.
import * as THREE from "three";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";

const size_px = 256;
const draco = new DRACOLoader().setDecoderPath("/node_modules/three/examples/jsm/libs/draco/gltf/");
const loader = new GLTFLoader().setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder);
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(size_px, size_px);
renderer.setClearColor(0x000000, 0);

// A level of a few triangles may show nothing but their backs to one side.
const viewpoints = [new THREE.Vector3(0.5, 0.6, 1).normalize(), new THREE.Vector3(-0.5, -0.6, -1).normalize()];

function camera_for(box, direction) {
  const center = box.getCenter(new THREE.Vector3());
  const radius = Math.max(box.getSize(new THREE.Vector3()).length() / 2, Number.MIN_VALUE);
  const camera = new THREE.PerspectiveCamera(45, 1, radius / 10, radius * 10);
  camera.position.copy(center).addScaledVector(direction, 2.7 * radius);
  camera.lookAt(center);
  return camera;
}

function drawn_pixels(stage, camera) {
  renderer.render(stage, camera);
  const pixels = new Uint8Array(size_px * size_px * 4);
  const gl = renderer.getContext();
  gl.readPixels(0, 0, size_px, size_px, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels.filter((value, i) => i % 4 === 3 && value > 0).length;
}

function drawn_from_all_sides(scene, box) {
  const stage = new THREE.Scene();
  stage.add(scene, new THREE.HemisphereLight(0xffffff, 0x404040, 4));
  return viewpoints.reduce((sum, direction) => sum + drawn_pixels(stage, camera_for(box, direction)), 0);
}

// GLTFLoader takes a geometry's box from the accessor's min and max, which neither validator can hold against Draco's data.
function has_wrong_box(geometry) {
  const actual = new THREE.Box3().setFromBufferAttribute(geometry.attributes.position);
  const tolerance = 1e-6 * actual.getSize(new THREE.Vector3()).length();
  const { min, max } = geometry.boundingBox;
  return min.distanceTo(actual.min) > tolerance || max.distanceTo(actual.max) > tolerance;
}

function dispose(meshes) {
  for (const mesh of meshes) {
    mesh.geometry.dispose();
    mesh.material.dispose();
  }
}

window.measure = async (url) => {
  const { scene } = await loader.loadAsync(url);
  const meshes = [];
  scene.traverse((node) => (node.isMesh || node.isPoints) && meshes.push(node));
  const found = { gouraud: 0, flat: 0, points: 0, wrongly_shaded: 0, wrong_boxes: 0 };
  for (const { geometry, material, isPoints } of meshes) {
    if (isPoints) {
      found.points += geometry.attributes.position.count;
      continue;
    }
    const is_flat = geometry.attributes.normal === undefined;
    found[is_flat ? "flat" : "gouraud"] += (geometry.index ?? geometry.attributes.position).count / 3;
    found.wrong_boxes += Number(has_wrong_box(geometry));
    found.wrongly_shaded += Number(material.flatShading !== is_flat);
  }
  const box = new THREE.Box3().setFromObject(scene, true);
  const result = { ...found, bounds: [...box.min, ...box.max], pixels: drawn_from_all_sides(scene, box) };
  dispose(meshes);
  return result;
};
