// Three-dimensional views: the sphere of directions, and the lattice in a mode. Both can be rotated, also with the arrow keys.

import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  Group,
  InstancedMesh,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene,
  SphereGeometry,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Directions, Mode } from "./ask";
import { color } from "./dom";
import { displacement, PAUSE, PERIOD, type Moving } from "./moving";

/** Scene that can be rotated. */
function scene(place: HTMLElement, label: string, step: (now: number) => boolean) {
  const width = Math.max(place.clientWidth, 200);
  const side = Math.min(width, 360);
  const renderer = new WebGLRenderer({ antialias: true, alpha: true });
  renderer.setPixelRatio(window.devicePixelRatio || 1);
  renderer.setSize(width, side);
  const canvas = renderer.domElement;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", label);
  canvas.tabIndex = 0;
  place.replaceChildren(canvas);
  const world = new Scene();
  const root = new Group();
  // The third axis points upward.
  root.rotation.x = -Math.PI / 2;
  world.add(root, new AmbientLight(0xffffff, 1.6));
  const light = new DirectionalLight(0xffffff, 1.8);
  light.position.set(2, 3, 4);
  world.add(light);
  const camera = new PerspectiveCamera(35, width / side, 0.1, 100);
  camera.position.set(2.2, 1.6, 3.2);
  const controls = new OrbitControls(camera, canvas);
  controls.enablePan = false;
  canvas.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [0, -0.1], ArrowRight: [0, 0.1], ArrowUp: [-0.1, 0], ArrowDown: [0.1, 0] }[event.key];
    if (!turn) return;
    event.preventDefault();
    world.rotation.x += turn[0]!;
    world.rotation.y += turn[1]!;
    isTurned = true;
  });
  let frame = 0;
  let isTurned = true;
  controls.addEventListener("change", () => (isTurned = true));
  const draw = (now: number) => {
    frame = requestAnimationFrame(draw);
    const isMoved = step(now);
    // Frames without changes are skipped.
    if (!isMoved && !isTurned) return;
    isTurned = false;
    renderer.render(world, camera);
  };
  return {
    root,
    begin: () => draw(performance.now()),
    stop: () => {
      cancelAnimationFrame(frame);
      controls.dispose();
      renderer.dispose();
      renderer.forceContextLoss();
    },
  };
}

/** Smallest eigenvalue of the acoustic tensor over the sphere of directions, from blue (largest) to vermilion (smallest). */
export function sphere(place: HTMLElement, answer: Directions): { stop(): void } {
  const [circles, around] = answer.shape;
  const values = answer.eigenvalues.map((own) => own[0]!);
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const [cold, warm] = [new Color(color("sky")), new Color(color("vermilion"))];
  const positions: number[] = [];
  const colors: number[] = [];
  answer.normals.forEach((normal, n) => {
    positions.push(normal[0]!, normal[1]!, normal[2]!);
    // For an isotropic state all values agree to rounding.
    const share = high - low > 1e-9 * Math.abs(high) ? (values[n]! - low) / (high - low) : 1;
    const own = warm.clone().lerp(cold, share);
    colors.push(own.r, own.g, own.b);
  });
  const faces: number[] = [];
  for (let row = 0; row + 1 < circles; row++) {
    for (let column = 0; column < around; column++) {
      const [a, b] = [row * around + column, row * around + ((column + 1) % around)];
      faces.push(a, a + around, b, b, a + around, b + around);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(colors), 3));
  geometry.setIndex(faces);
  geometry.computeVertexNormals();
  const view = scene(place, "The smallest eigenvalue of the acoustic tensor on the sphere of directions; arrow keys turn it", () => false);
  view.root.add(new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true })));
  view.begin();
  return view;
}

/** Particles of a mode in three dimensions. */
export function lattice(place: HTMLElement, mode: Mode, amplitude: number, isPaused: boolean): Moving {
  const count = mode.particles.length;
  const center = [0, 1, 2].map((axis) => mode.particles.reduce((sum, own) => sum + own.place[axis]!, 0) / count);
  const far = Math.max(...mode.particles.map((own) => Math.hypot(...own.place.map((x, axis) => x - center[axis]!))), mode.spacing);
  const balls = new InstancedMesh(
    new SphereGeometry((0.18 * mode.spacing) / far, 16, 12),
    new MeshLambertMaterial({ color: color(mode.stable ? "blue" : "vermilion") }),
    count,
  );
  const state = { amplitude, isPaused, stop: () => view.stop() };
  const matrix = new Matrix4();
  let phase = 0;
  let last = -Infinity;
  let known = -1;
  const view = scene(place, "The particles in the mode, in three dimensions; arrow keys turn them", (now) => {
    if ((state.isPaused && known === state.amplitude) || now - last < 1000 * PAUSE) return false;
    if (!state.isPaused && Number.isFinite(last)) phase += (Math.min(now - last, 200) / 1000 / PERIOD) * 2 * Math.PI;
    last = now;
    known = state.amplitude;
    mode.particles.forEach((own, n) => {
      const at = own.place.map((x, axis) => (x - center[axis]! + state.amplitude * mode.spacing * displacement(own, phase, axis)) / far);
      balls.setMatrixAt(n, matrix.makeTranslation(at[0]!, at[1]!, at[2]!));
    });
    balls.instanceMatrix.needsUpdate = true;
    return true;
  });
  view.root.add(balls);
  view.begin();
  return state;
}
