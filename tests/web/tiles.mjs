// In the page: 3DTilesRendererJS and CesiumJS show a tileset as any application of theirs would, and tell what they drew.
// A view is {eye, target, up, fov_y_deg, error_px} in glTF's axes: y up.
import { TilesRenderer } from "3d-tiles-renderer";
import { GLTFExtensionsPlugin } from "3d-tiles-renderer/plugins";
import * as THREE from "three";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const size_px = 512;
const limit_ms = 120_000;
const settled_frames = 5;

const draco = new DRACOLoader().setDecoderPath("/node_modules/three/examples/jsm/libs/draco/gltf/");
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, antialias: false });
renderer.setSize(size_px, size_px);
renderer.setClearColor(0x000000, 0);

const frame = () => new Promise((resolve) => setTimeout(resolve, 20));

function camera_of({ eye, target, up, fov_y_deg }) {
  const [from, to] = [new THREE.Vector3(...eye), new THREE.Vector3(...target)];
  const distance = from.distanceTo(to);
  const camera = new THREE.PerspectiveCamera(fov_y_deg, 1, distance / 100, distance * 10);
  camera.position.copy(from);
  camera.up.set(...up);
  camera.lookAt(to);
  camera.updateMatrixWorld();
  return camera;
}

function lit(...objects) {
  const scene = new THREE.Scene();
  scene.add(new THREE.HemisphereLight(0xffffff, 0x404040, 2), ...objects);
  return scene;
}

function picture(scene, camera) {
  renderer.render(scene, camera);
  const pixels = new Uint8Array(size_px * size_px * 4);
  const gl = renderer.getContext();
  gl.readPixels(0, 0, size_px, size_px, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}

// What names a tile: its id where it tells one (instances share their contents), else its content.
const name_of = (extras, uri) => extras?.id ?? uri.split("/").pop();
const is_document = (uri) => uri.split("?")[0].endsWith(".json");

// `step` draws a frame and tells {settled, loaded}; a slow machine is given time for as long as tiles come.
async function until_settled(step) {
  let end = performance.now() + limit_ms, before = -1;
  for (let still = 0; still < settled_frames; ) {
    const { settled, loaded } = step();
    still = settled ? still + 1 : 0;
    if (loaded !== before) end = performance.now() + limit_ms;
    before = loaded;
    if (performance.now() > end) throw new Error(`no tile came for ${limit_ms / 1000} s; ${loaded} are there`);
    await frame();
  }
}

// The pixels of a picture of the tileset, and the file names of the tiles that it shows.
async function show_in_three(url, view) {
  const tiles = new TilesRenderer(url);
  tiles.registerPlugin(new GLTFExtensionsPlugin({ dracoLoader: draco }));
  tiles.errorTarget = view.error_px;
  tiles.group.rotation.x = -Math.PI / 2; // tiles are z up
  tiles.group.updateMatrixWorld(true);
  const camera = camera_of(view);
  tiles.setCamera(camera);
  tiles.setResolution(camera, size_px, size_px);
  let failed = 0;
  tiles.addEventListener("load-error", () => ++failed);
  await until_settled(() => {
    tiles.update();
    return { settled: tiles.loadProgress === 1 && tiles.visibleTiles.size > 0, loaded: tiles.stats.loaded };
  });
  const shown = [...tiles.visibleTiles].filter((tile) => !is_document(tile.content.uri));
  const drawn = shown.map((tile) => name_of(tile.extras, tile.content.uri));
  const pixels = picture(lit(tiles.group), camera);
  tiles.dispose();
  return { drawn, failed, pixels };
}

async function show_glb(url, view) {
  const { scene } = await new GLTFLoader().setDRACOLoader(draco).loadAsync(url);
  return picture(lit(scene), camera_of(view));
}

const shows = (pixels, i) => pixels[4 * i + 3] > 0;

function compare(a, b) {
  let either = 0, silhouette = 0, color = 0;
  for (let i = 0; i < size_px * size_px; ++i) {
    if (!shows(a, i) && !shows(b, i)) continue;
    ++either;
    if (shows(a, i) !== shows(b, i)) ++silhouette;
    else if ([0, 1, 2].some((k) => Math.abs(a[4 * i + k] - b[4 * i + k]) > 16)) ++color;
  }
  return { pixels: either, silhouette: silhouette / Math.max(1, either), color: color / Math.max(1, either) };
}

// Shows the tileset in 3DTilesRendererJS beside the whole model as one GLB, which may be seen from elsewhere.
window.measure_three = async (tileset, glb, view, glb_view = view) => {
  const { drawn, failed, pixels } = await show_in_three(tileset, view);
  return { drawn, failed, difference: compare(pixels, await show_glb(glb, glb_view)) };
};

// The last picture that three.js drew, as a data URL.
window.picture_three = () => renderer.domElement.toDataURL();

function cesium_scene() {
  const widget = new Cesium.CesiumWidget("cesium", {
    globe: false, skyBox: false, skyAtmosphere: false, baseLayer: false, useDefaultRenderLoop: false,
    contextOptions: { webgl: { preserveDrawingBuffer: true, alpha: true } },
  });
  widget.scene.backgroundColor = Cesium.Color.TRANSPARENT;
  return widget;
}

// Somewhere on the globe, as CesiumJS wants it: x east, y north, z up.
function place_in_cesium(widget, tileset, { eye, target, up, fov_y_deg }) {
  const placed = Cesium.Transforms.eastNorthUpToFixedFrame(Cesium.Cartesian3.fromDegrees(10, 50, 1000));
  tileset.modelMatrix = placed;
  const z_up = ([x, y, z]) => new Cesium.Cartesian3(x, -z, y);
  const point = (v) => Cesium.Matrix4.multiplyByPoint(placed, z_up(v), new Cesium.Cartesian3());
  const turned = (v) => Cesium.Matrix4.multiplyByPointAsVector(placed, v, new Cesium.Cartesian3());
  const direction = Cesium.Cartesian3.normalize(
    Cesium.Cartesian3.subtract(z_up(target), z_up(eye), new Cesium.Cartesian3()), new Cesium.Cartesian3());
  widget.camera.frustum.fov = (fov_y_deg * Math.PI) / 180;
  widget.camera.setView({ destination: point(eye), orientation: { direction: turned(direction), up: turned(z_up(up)) } });
}

// Nothing is drawn until all is here: without a GPU, frames of what comes in between take most of the time.
window.measure_cesium = async (url, view) => {
  const widget = cesium_scene();
  const tileset = await Cesium.Cesium3DTileset.fromUrl(url, { maximumScreenSpaceError: view.error_px, show: false, preloadWhenHidden: true });
  let failed = 0, drawn = new Set();
  tileset.tileFailed.addEventListener(() => ++failed);
  tileset.tileVisible.addEventListener((tile) => {
    if (!is_document(tile.content.url)) drawn.add(name_of(tile.extras, tile.content.url));
  });
  widget.scene.primitives.add(tileset);
  place_in_cesium(widget, tileset, view);
  const step = (is_settled) => until_settled(() => {
    drawn = new Set();
    widget.resize();
    widget.render();
    const loaded = tileset.statistics.numberOfTilesWithContentReady;
    return { settled: tileset.tilesLoaded && is_settled(loaded), loaded };
  });
  await step((loaded) => loaded > 0);
  tileset.show = true;
  await step(() => drawn.size > 0);
  return { drawn: [...drawn], failed, picture: widget.canvas.toDataURL() };
};
